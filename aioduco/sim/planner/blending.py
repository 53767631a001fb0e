"""Blends (轨迹融合): from one motion into the next without standing at the corner between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.sim.planner.errors import PlanError
from aioduco.sim.planner.limits import cartesian_limits, joint_limits
from aioduco.sim.planner.path import Path, differentiate
from aioduco.sim.planner.tracing import follow

if TYPE_CHECKING:
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.segments import Segment
    from aioduco.sim.planner.timing import Limits

__all__ = ["Blend", "blend"]

_PIECES = 24
_SEARCH = 129  # samples in which the blend radius is looked for
_SHARE = 0.8  # of the acceleration for the bend; the rest is for the speed along it


class Blend(NamedTuple):
    """A corner that is cut.

    Attributes:
        leave: distance on the first motion where the blend begins.
        enter: distance on the second motion where it ends.
        path: of the blend, in the unit of the second motion; it is twice `enter` long.
        limits: along it.
        ratio: distance on the second motion per distance on the first where the blend begins.
    """

    leave: float
    enter: float
    path: Path
    limits: Limits
    ratio: float


def blend(first: Segment, second: Segment) -> Blend | None:
    """Blend one motion into the next, within the radius of the first.

    While the first motion slows down to its end, the second sets off from its start; what each
    has moved is added up. Two straight lines give a parabola. A blend takes at most half of each
    motion.

    Args:
        first: a motion with a blend radius.
        second: the motion that begins where the first ends.

    Returns:
        The blend, or None where there can be none and the first motion stops at its end.
    """
    if first.path is None or second.path is None or first.radius <= 0.0:
        return None
    left = _reach(first, backwards=True)
    enter = _reach(second, backwards=False, radius=first.radius)
    if left is None or enter is None:
        return None
    leave = first.path.end - left
    u = np.linspace(0.0, 1.0, _PIECES + 1)
    s1 = leave + left * (2.0 * u - u * u)
    s2 = enter * u * u
    length = 2.0 * enter
    together = (
        first.curve is not None
        and second.curve is not None
        and np.array_equal(first.tool, second.tool)
    )
    try:
        q = _tool_space(first, second, s1, s2) if together else _joint_space(first, second, s1, s2)
    except PlanError:
        return None
    slope, bend = differentiate(q, length / _PIECES)
    path = Path.through(q, slope, bend, length)
    speed = first.v + (second.v - first.v) * u
    rate = min(first.a, second.a)
    if together:
        points = (first.tcp(s1) + second.tcp(s2))[:, :3, 3]
        velocity, acceleration = differentiate(points, length / _PIECES)
        limits = cartesian_limits(
            first.arm, path.bounds, slope, bend, velocity, acceleration, speed, rate, share=_SHARE
        )
    else:
        # Between a joint move and a line only the joints have a common limit.
        joint = [segment for segment in (first, second) if segment.curve is None]
        rate = min(segment.a for segment in joint)
        speed = speed if len(joint) == 2 else np.full(len(u), np.inf)
        limits = joint_limits(first.arm, path.bounds, slope, bend, speed, rate, share=_SHARE)
    return Blend(leave, enter, path, limits, enter / left)


def _reach(segment: Segment, *, backwards: bool, radius: float | None = None) -> float | None:
    """Give the distance along a motion, from one end, at which the tool is the radius away."""
    radius = segment.radius if radius is None else radius
    along = np.linspace(0.0, 0.5 * segment.length, _SEARCH)
    points = segment.tcp(segment.length - along if backwards else along)[:, :3, 3]
    away = np.linalg.norm(points - points[0], axis=1)
    if away.max() < 1e-6:
        return None  # only turns: a radius says nothing about it
    outside = np.flatnonzero(away >= radius)
    if not len(outside):
        return float(along[-1])
    i = int(outside[0])
    part = (radius - away[i - 1]) / (away[i] - away[i - 1])
    return float(along[i - 1] + part * (along[i] - along[i - 1]))


def _joint_space(first: Segment, second: Segment, s1: Array, s2: Array) -> Array:
    assert first.path is not None
    assert second.path is not None
    q: Array = first.path.sample(s1)[:, 0] + second.path.sample(s2)[:, 0] - second.q_start
    return q


def _tool_space(first: Segment, second: Segment, s1: Array, s2: Array) -> Array:
    assert first.path is not None
    assert first.curve is not None
    assert second.curve is not None
    one, two = first.curve.poses(s1), second.curve.poses(s2)
    corner = second.curve.poses(np.zeros(1))[0]
    both = np.zeros_like(one)
    both[:, :3, :3] = one[:, :3, :3] @ corner[:3, :3].T @ two[:, :3, :3]
    both[:, :3, 3] = one[:, :3, 3] + two[:, :3, 3] - corner[:3, 3]
    both[:, 3, 3] = 1.0
    return follow(first.arm, first.path.sample(s1[:1])[0, 0], both @ np.linalg.inv(first.tool))
