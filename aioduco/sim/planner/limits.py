"""Limits of paths: what speeds and accelerations of joints and tool leave along a path."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.planner.timing import Limits

if TYPE_CHECKING:
    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array

__all__ = ["SHARE", "STOPPING", "cartesian_limits", "joint_limits"]

SHARE = 0.5
"""Share of a joint's acceleration for the bends of a path; the rest is for the speed along it."""

STOPPING = 0.5
"""Share of the drives' acceleration that a stop uses. An assumption."""

_ACROSS = 0.98  # of the acceleration goes into a bend at most, so that some is left along it
_STRAIGHT = 1e-6  # curvature that is only rounding [1/m]
_HIGHEST = 1e6  # stands for unlimited in arithmetic


def joint_limits(
    arm: Arm,
    nodes: list[float],
    slope: Array,
    bend: Array,
    v: Array | float,
    a: Array | float,
    *,
    share: float = SHARE,
) -> Limits:
    """Give the limits of a path on which every joint keeps to a speed and an acceleration.

    Args:
        arm: the arm, whose own limits count, too.
        nodes: n + 1 distances along the path.
        slope: dq/ds there. Shape (n + 1, 6).
        bend: d²q/ds² there. Shape (n + 1, 6).
        v: joint speed [rad/s]; one, or one for each node.
        a: joint acceleration [rad/s²]; one, or one for each node.
        share: of the acceleration that the bends of the path may take; the rest is for changes
            of the speed along it. A path without bends leaves all of it.
    """
    speeds = np.minimum(np.broadcast_to(v, len(nodes))[:, None], arm.velocity)
    drives = np.broadcast_to(np.array(arm.acceleration), slope.shape)
    rates = np.minimum(np.broadcast_to(a, len(nodes))[:, None], drives)
    curved = bool(np.abs(bend).max() > 1e-9)
    with np.errstate(divide="ignore", over="ignore"):
        ceiling = ((speeds / np.abs(slope)).min(axis=1)) ** 2
        if curved:
            ceiling = np.minimum(ceiling, (share * rates / np.abs(bend)).min(axis=1))
        rest = 1.0 - share if curved else 1.0
        push = (rest * rates / np.abs(slope)).min(axis=1)
        brake = (STOPPING * drives / np.abs(slope)).min(axis=1)
    pieces = len(nodes) - 1
    return Limits(
        nodes,
        np.minimum(ceiling, _HIGHEST).tolist(),
        np.minimum(np.minimum(push[:-1], push[1:]), _HIGHEST).tolist(),
        [math.inf] * pieces,
        [0.0] * pieces,
        np.minimum(np.minimum(brake[:-1], brake[1:]), _HIGHEST).tolist(),
    )


def cartesian_limits(
    arm: Arm,
    nodes: list[float],
    slope: Array,
    bend: Array,
    velocity: Array,
    acceleration: Array,
    v: Array,
    a: float,
    *,
    share: float | None = None,
) -> Limits:
    """Give the limits of a path on which the tool centre point keeps to a speed and acceleration.

    Args:
        arm: the arm, whose joint limits count, too.
        nodes: n + 1 distances along the path.
        slope: dq/ds there. Shape (n + 1, 6).
        bend: d²q/ds² there. Shape (n + 1, 6).
        velocity: derivative of the tool centre point's position by s. Shape (n + 1, 3).
        acceleration: its second derivative. Shape (n + 1, 3).
        v: speed of the tool centre point at each node [m/s]. Shape (n + 1,).
        a: its acceleration [m/s²].
        share: of the acceleration that the bends of the path may take, where its parameter is not
            the distance and the two parts are not square to each other; None where they are.
    """
    joints = joint_limits(arm, nodes, slope, bend, math.inf, math.inf, share=share or SHARE)
    stretch = np.linalg.norm(velocity, axis=1)
    turning_only = stretch.max() < 1e-9
    if turning_only:
        stretch = np.ones_like(stretch)
    curvature = np.linalg.norm(acceleration, axis=1)
    curvature[curvature < _STRAIGHT] = 0.0
    with np.errstate(divide="ignore"):
        most = _ACROSS * a if share is None else share * a
        ceiling = np.minimum((v / stretch) ** 2, most / curvature)
    if share is not None:
        a *= 1.0 - share
        curvature[:] = 0.0
    pieces = slice(None, -1)
    widest = np.maximum(np.maximum(stretch[pieces], stretch[1:]), _STRAIGHT)
    return Limits(
        nodes,
        np.minimum(joints.ceiling, ceiling).tolist(),
        joints.push,
        (a / widest).tolist(),
        (np.maximum(curvature[pieces], curvature[1:]) / widest).tolist(),
        joints.brake,
    )
