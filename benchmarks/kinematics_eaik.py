"""`Arm.ikine` as it was with EAIK 1.2, before the closed form in plain floats took its place.

    pip install EAIK
    python benchmarks/kinematics_eaik.py    write tests/kinematics/eaik.json anew

It is what the benchmark compares with. Reference solutions for the tests are made of EAIK alone.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.kinematics import arm, inverse, models
from aioduco.kinematics.forward import singular_values

if TYPE_CHECKING:
    from aioduco.kinematics import Arm
    from aioduco.kinematics.geometry import Geometry
    from aioduco.models.rotation import Array

REFERENCE = Path(__file__).parents[1] / "tests" / "kinematics" / "eaik.json"
POSES = 12  # of each arm, in the reference
_REGULAR = 1e-4  # a singular value below this was left to the closed form
_EDGE = 1e-10


def robot_of(geometry: Geometry) -> Any:
    """EAIK's robot for an arm."""
    family = importlib.import_module("eaik.IK_DH")
    return family.DhRobot(np.array(geometry.alpha), np.array(geometry.a), np.array(geometry.d))


def exact(robot: Any, geometry: Geometry, flange: Array) -> Array:
    """All solutions that EAIK does not mark as least squares: joint angles [rad]. Shape (n, 6)."""
    answer = robot.IK(flange)
    found: Array = np.asarray(answer.Q).reshape(-1, 6)[~np.asarray(answer.is_LS, dtype=bool)]
    joints: Array = found - np.array(geometry.theta)
    return joints


class EaikArm:
    """An arm with the inverse kinematics of then."""

    def __init__(self, any_arm: Arm) -> None:
        self._arm = any_arm
        self._robot = robot_of(any_arm.geometry)

    def ikine(self, flange: Array, near: Array) -> Array:
        """The configuration that is nearest: joint angles [rad]. Shape (6,)."""
        found = self._solve(flange, float(near[5]))
        lower, upper = np.array(self._arm.lower), np.array(self._arm.upper)
        turned = _wrap_near(found, near, lower, upper)
        inside = turned[~np.isnan(turned).any(axis=1)]
        best: Array = inside[np.argmin(((inside - near) ** 2).sum(axis=1))]
        return best

    def ikine_all(self, flange: Array) -> Array:
        """Every configuration: joint angles [rad]. Shape (n, 6)."""
        return inverse.wrap(self._solve(flange, 0.0))

    def _solve(self, target: Array, q6: float) -> Array:
        geometry = self._arm.geometry
        found = self._regular(target)
        if found is None:
            found = inverse.closed_form(geometry, target, q6)
            found = found[~np.isnan(found).any(axis=1)]
        error = np.abs(inverse.residual(geometry, found, target)).max(axis=-1, initial=0.0)
        if (error > 1e-12).any():
            found = inverse.refine(geometry, found, target)
            error = np.abs(inverse.residual(geometry, found, target)).max(axis=-1)
        kept: Array = found[error < 1e-9]
        return kept

    def _regular(self, flange: Array) -> Array | None:
        geometry = self._arm.geometry
        q = exact(self._robot, geometry, flange)
        if len(q) != inverse.BRANCHES:
            return None
        values = singular_values(geometry, q)
        if np.abs(values).min() < _REGULAR:
            return None
        q[:, 2] -= 2 * math.pi * np.round(q[:, 2] / (2 * math.pi))
        wrist = flange[:2, 3] - geometry.d6 * flange[:2, 2]
        behind = np.cos(q[:, 0]) * wrist[0] + np.sin(q[:, 0]) * wrist[1] < 0
        branch = 4 * behind + 2 * (q[:, 2] < 0) + (values[:, 2] < 0)
        ordered: Array = q[np.argsort(branch)]
        return ordered


def _wrap_near(q: Array, near: Array, lower: Array, upper: Array) -> Array:
    turn = 2 * np.pi
    fewest = np.ceil((lower - q) / turn - _EDGE)
    most = np.floor((upper - q) / turn + _EDGE)
    wrapped = q + turn * np.clip(np.round((near - q) / turn), fewest, most)
    return np.where(fewest > most, np.nan, np.clip(wrapped, lower, upper))


def reference(any_arm: Arm, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Poses, told by one configuration each, and EAIK's solutions."""
    robot = robot_of(any_arm.geometry)
    poses: list[dict[str, Any]] = []
    while len(poses) < POSES:
        q = rng.uniform(-math.pi, math.pi, 6).round(4)
        found = inverse.wrap(exact(robot, any_arm.geometry, any_arm.fkine(q)))
        # Near a singularity EAIK counts a solution twice, or not at all.
        if np.abs(singular_values(any_arm.geometry, found)).min() > 1e-2:
            poses.append({"q": q.tolist(), "solutions": found.round(11).tolist()})
    return poses


def main() -> None:
    rng = np.random.default_rng(5)
    arms = {model: reference(arm(model), rng) for model in models()}
    data = {"EAIK": importlib.metadata.version("EAIK"), "arms": arms}
    text = json.dumps(data, separators=(",", ":")).replace('{"q"', '\n{"q"')
    REFERENCE.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
