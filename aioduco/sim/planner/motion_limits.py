"""Limits along paths, from the speeds and accelerations of joints and tool."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.planner.arrays import numbers
from aioduco.sim.planner.path import differentiate
from aioduco.sim.planner.slices import LONG_SLICE, slices, yield_now
from aioduco.sim.planner.timing import PathLimits

if TYPE_CHECKING:
    from array import array

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array


SHARE = 0.5
"""Share of a joint's acceleration that the bends of a path may take."""

STOPPING = 0.5
"""Share of the drives' acceleration that a stop uses. An assumption."""

_ACROSS = 0.98  # largest share of the acceleration for a bend, so that some is left along it
_STRAIGHT = 1e-6  # curvature that is only rounding [1/m]
_HIGHEST = 1e6  # stands for unlimited in arithmetic


def joint_limits(
    arm: Arm,
    nodes: Array,
    joints: Array,
    v: Array | float,
    a: Array | float,
    *,
    share: float = SHARE,
    top: Array | float = math.inf,
) -> PathLimits:
    """Give the limits of a path on which every joint keeps to a speed and an acceleration.

    Args:
        arm: the arm, whose own limits count, too.
        nodes: distances along the path. Shape (n + 1,).
        joints: q, dq/ds and d²q/ds² there. Shape (n + 1, 3, 6).
        v: joint speed [rad/s]; one, or one for each node.
        a: joint acceleration [rad/s²]; one, or one for each node.
        share: largest share of the acceleration for the bends of the path; the rest is for changes
            of the speed along it.
        top: highest (ds/dt)² for other reasons; one, or one for each node.
    """
    speeds = np.minimum(np.reshape(v, (-1, 1)), arm.velocity)
    drives = np.array(arm.acceleration)
    rates = np.minimum(np.reshape(a, (-1, 1)), drives)
    return axes_limits(nodes, joints, speeds, rates, STOPPING * drives, share, top)


def axes_limits(
    nodes: Array,
    axes: Array,
    speeds: Array,
    rates: Array,
    braking: Array,
    share: float = SHARE,
    top: Array | float = math.inf,
) -> PathLimits:
    """Give the limits of a path on which each of some axes keeps to a speed and an acceleration.

    Args:
        nodes: distances along the path. Shape (n + 1,).
        axes: positions, and their first and second derivatives there. Shape (n + 1, 3, k).
        speeds: highest speeds of the axes. Shape (k,) or (n + 1, k).
        rates: highest accelerations of the axes, in the same shapes.
        braking: accelerations that a stop uses. Shape (k,).
        share: largest share of the acceleration for the bends of the path.
        top: highest (ds/dt)² for other reasons; one, or one for each node.
    """
    count = len(nodes)
    speeds = np.broadcast_to(speeds, (count, axes.shape[2]))
    rates = np.broadcast_to(rates, (count, axes.shape[2]))
    top = np.broadcast_to(top, count)
    ceiling, push, brake = np.empty(count), np.empty(count), np.empty(count)
    for part in slices(count, LONG_SLICE):
        slope, bend = np.abs(axes[part, 1]), np.abs(axes[part, 2])
        with np.errstate(divide="ignore", over="ignore"):
            fast = (speeds[part] / slope).min(axis=1) ** 2
            highest = np.minimum(fast, (share * rates[part] / bend).min(axis=1))
            highest = np.minimum(np.minimum(highest, top[part]), _HIGHEST)
            ceiling[part] = highest
            push[part] = ((rates[part] - bend * highest[:, None]) / slope).min(axis=1)
            brake[part] = (braking / slope).min(axis=1)
    pieces = count - 1
    return PathLimits(
        numbers(nodes),
        numbers(ceiling),
        _least(push),
        numbers(np.full(pieces, math.inf)),
        numbers(np.zeros(pieces)),
        _least(brake),
    )


def _least(values: Array) -> array[float]:
    """Give the smaller of the values at both ends of each piece."""
    return numbers(np.minimum(np.minimum(values[:-1], values[1:]), _HIGHEST))


def tool_limits(
    arm: Arm,
    nodes: Array,
    joints: Array,
    points: Array,
    v: Array | float,
    a: float,
    *,
    share: float | None = None,
) -> PathLimits:
    """Give the limits of a path on which the tool centre point keeps to a speed and acceleration.

    Args:
        arm: the arm, whose joint limits count, too.
        nodes: even distances along the path. Shape (n + 1,).
        joints: q, dq/ds and d²q/ds² there. Shape (n + 1, 3, 6).
        points: the tool centre point there [m]. Shape (n + 1, 3).
        v: its speed [m/s]; one, or one for each node.
        a: its acceleration [m/s²].
        share: largest share of the acceleration for the bends of the path, if the path's parameter
            is not the distance, so that the acceleration along the path is not perpendicular to the
            one across it; None if the parameter is the distance.
    """
    velocity, acceleration = differentiate(points, float(nodes[1]))
    stretch, curvature = np.empty(len(points)), np.empty(len(points))
    for part in slices(len(points), LONG_SLICE):
        stretch[part] = np.linalg.norm(velocity[part], axis=1)
        curvature[part] = np.linalg.norm(acceleration[part], axis=1)
    if stretch.max() < _STRAIGHT:
        stretch = np.ones_like(stretch)  # the path only turns, and its unit is the radian
    curvature[curvature < _STRAIGHT] = 0.0
    most = _ACROSS if share is None else share
    with np.errstate(divide="ignore"):
        top = np.minimum((v / stretch) ** 2, most * a / curvature)
    yield_now()
    limits = joint_limits(arm, nodes, joints, math.inf, math.inf, share=share or SHARE, top=top)
    widest = np.maximum(np.maximum(stretch[:-1], stretch[1:]), _STRAIGHT)
    if share is not None:
        left = a - curvature * np.array(limits.ceiling)
        return limits._replace(total=numbers(np.minimum(left[:-1], left[1:]) / widest))
    bends = np.maximum(curvature[:-1], curvature[1:]) / widest
    yield_now()
    return limits._replace(total=numbers(a / widest), curvature=numbers(bends))
