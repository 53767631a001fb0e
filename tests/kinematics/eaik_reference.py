"""Solutions of inverse kinematics made by EAIK 1.2: it writes `eaik.json` anew.

pip install EAIK
python tests/kinematics/eaik_reference.py
"""

from __future__ import annotations

import importlib
import importlib.metadata
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from aioduco.kinematics import Arm, arm, inverse, models
from aioduco.kinematics.forward import singular_values
from aioduco.kinematics.geometry import Geometry
from aioduco.models.rotation import Array

REFERENCE = Path(__file__).with_name("eaik.json")
POSES = 12  # of each arm, in the reference


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
