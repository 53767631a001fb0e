"""EAIK's inverse kinematics for single poses, where it is installed: compiled, so it is faster."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.kinematics.forward import singular_values
from aioduco.kinematics.inverse import BRANCHES

if TYPE_CHECKING:
    from aioduco.kinematics.geometry import Geometry
    from aioduco.models.rotation import Array

__all__ = ["installed", "solutions"]

_REGULAR = 1e-4  # a singular value below this is left to the closed form, which has a rule for it


@cache
def _robot(geometry: Geometry) -> Any | None:
    try:
        from eaik.IK_DH import DhRobot  # noqa: PLC0415  # optional, and 60 ms to import
    except ImportError:
        return None
    return DhRobot(np.array(geometry.alpha), np.array(geometry.a), np.array(geometry.d))


def installed(geometry: Geometry) -> bool:
    """Tell whether EAIK is installed."""
    return _robot(geometry) is not None


def solutions(geometry: Geometry, flange: Array) -> Array | None:
    """Give all solutions of a pose.

    Args:
        geometry: the arm's lengths [m].
        flange: homogeneous matrix in the base frame. Shape (4, 4).

    Returns:
        Joint angles [rad], not wrapped, ordered as the closed form's. Shape (8, 6). None where
        EAIK is not installed or found fewer: either there are fewer, or it left out singular ones.
    """
    robot = _robot(geometry)
    if robot is None:
        return None
    answer = robot.IK(flange)
    exact = ~np.asarray(answer.is_LS, dtype=bool)
    if exact.sum() != BRANCHES:
        return None
    q = np.asarray(answer.Q)[exact] - np.array(geometry.theta)
    values = singular_values(geometry, q)
    if np.abs(values).min() < _REGULAR:
        return None
    q[:, 2] -= 2 * math.pi * np.round(q[:, 2] / (2 * math.pi))
    branch = 4 * (_second_shoulder(geometry, q, flange)) + 2 * (q[:, 2] < 0) + (values[:, 2] < 0)
    ordered: Array = q[np.argsort(branch)]
    return ordered


def _second_shoulder(geometry: Geometry, q: Array, flange: Array) -> Array:
    # In the first shoulder branch the wrist's centre is ahead of joint 1's axis, not behind it.
    wrist = flange[:2, 3] - geometry.d6 * flange[:2, 2]
    behind: Array = np.cos(q[:, 0]) * wrist[0] + np.sin(q[:, 0]) * wrist[1] < 0
    return behind
