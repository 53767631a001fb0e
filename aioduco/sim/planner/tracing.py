"""From curves of the tool to paths of the joints: inverse kinematics along a curve."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from aioduco.kinematics.forward import singular_values
from aioduco.kinematics.inverse import closed_form, shortfall, wrap
from aioduco.sim.planner.errors import PlanError
from aioduco.sim.planner.path import Path, differentiate

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.curves import Curve

__all__ = ["check_limits", "fit", "follow", "trace"]

SINGULAR = 1e-3
"""Singular value (see `Arm.singularity`) below which a path is refused. An assumption."""

STRIDE = 0.35
"""Largest step of a joint between samples: more is a jump to another branch [rad]."""

_EXACT = 1e-5  # largest deviation of the path from the curve [rad of a joint]
_SPACING = 0.01  # distance of samples to begin with [m]
_TURNING = 0.05  # angle between samples to begin with [rad]
_FEWEST, _MOST = 24, 3072  # samples, if no bend needs more
_NAMES = ("shoulder", "elbow", "wrist")


def follow(arm: Arm, q0: Array, flange: Array) -> Array:
    """Give the joints along a sequence of poses, on the branch and the turn of q0.

    Args:
        arm: the arm.
        q0: joints at the first pose [rad]. Shape (6,).
        flange: poses of the flange in the base frame. Shape (n, 4, 4).

    Returns:
        Joint angles [rad]. Shape (n, 6).

    Raises:
        PlanError: a pose cannot be reached, or the path meets a singularity.
    """
    solutions = closed_form(arm.geometry, flange, float(q0[5]))
    off = np.nan_to_num(np.abs(wrap(solutions[0] - q0)).max(axis=-1), nan=np.inf)
    branch = int(np.argmin(off))
    _check_singular(arm, q0[None])
    if off[branch] > 1e-6:
        raise PlanError("parameter", "the motion does not begin where the arm is")
    q = solutions[:, branch]
    lost = np.flatnonzero(np.isnan(q).any(axis=-1))
    if len(lost):
        if not np.isnan(solutions[lost]).any(axis=-1).all(axis=-1).any():
            # Every pose is in reach, but from another shoulder, elbow or wrist.
            raise PlanError("singular", "the path passes through a singularity")
        missing = max(shortfall(arm.geometry, flange[place]) for place in (lost[0], lost[-1]))
        by = f"by at least {missing:.4f} m" if missing > 0.0 else "in these orientations"
        raise PlanError("unreachable", f"the path leaves the reach of the arm, {by}")
    q = np.unwrap(q, axis=0)
    turned: Array = q + 2 * math.pi * np.round((q0 - q[0]) / (2 * math.pi))
    return turned


def _check_singular(arm: Arm, q: Array) -> None:
    values = np.abs(singular_values(arm.geometry, q))
    if values.min() < SINGULAR:
        place, kind = np.unravel_index(int(values.argmin()), values.shape)
        part = float(place) / max(len(q) - 1, 1)
        raise PlanError("singular", f"{_NAMES[int(kind)]} singularity {part:.0%} along the path")


def check_limits(arm: Arm, q: Array) -> None:
    """Raise PlanError where joints of shape (n, 6) are outside the arm's limits."""
    outside = (q < np.array(arm.lower) - 1e-9) | (q > np.array(arm.upper) + 1e-9)
    if outside.any():
        joint = int(np.argmax(outside.any(axis=0)))
        raise PlanError(
            "limits",
            f"joint {joint + 1} would leave {arm.lower[joint]:.4f} to {arm.upper[joint]:.4f} rad",
        )


def trace(arm: Arm, q0: Array, curve: Curve, tool: Array) -> Path:
    """Give the joints' path along a curve of the tool centre point.

    Args:
        arm: the arm.
        q0: joints at the beginning of the curve [rad]. Shape (6,).
        curve: of the tool centre point in the base frame.
        tool: tool centre point in the frame of the flange. Shape (4, 4).

    Raises:
        PlanError: unreachable, singular or beyond the joint limits.
    """
    back = np.linalg.inv(tool)

    def joints(s: Array) -> Array:
        return follow(arm, q0, curve.poses(s) @ back)

    length = curve.length
    count = min(max(length / _SPACING, curve.turning / _TURNING), _MOST)
    path, samples = fit(joints, length, max(count, length / curve.detail))
    _check_singular(arm, samples)
    check_limits(arm, samples)
    return path


def fit(joints: Callable[[Array], Array], length: float, count: float) -> tuple[Path, Array]:
    """Give a path through samples of a function, as many as it takes to be exact between them.

    Args:
        joints: joint angles over distance. Shape (n,) to (n, 6).
        length: to which distance, from zero.
        count: samples to begin with.

    Returns:
        The path, within 10 µrad of the function half-way between its samples; and the samples,
        these between them included.

    Raises:
        PlanError: the function jumps; or what it raises.
    """
    pieces = math.ceil(max(count, _FEWEST))
    most = max(2 * pieces, _MOST)
    while True:
        # Every second sample only checks the path through the others.
        s = np.linspace(0.0, length, 2 * pieces + 1)
        every = joints(s)
        q = every[::2]
        if np.abs(np.diff(q, axis=0)).max() < STRIDE:
            path = Path.through(q, *differentiate(q, length / pieces), length)
            if np.abs(path.sample(s[1::2])[:, 0] - every[1::2]).max() < _EXACT:
                return path, every
        if 2 * pieces > most:
            raise PlanError("singular", "the path passes through a singularity")
        pieces *= 2
