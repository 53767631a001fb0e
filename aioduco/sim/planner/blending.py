"""Blends (轨迹融合): transitions from one motion into the next without a stop at the corner.

This module computes for the queue of motions as a whole where they blend, and how fast each may
end. The queue's entries are values. A new motion makes a new queue. That takes long, so it is
computed while the old queue runs. The new queue is used only if the motion that is running by then
can still follow it. Otherwise there is no blend, and the old queue remains.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.models.rotation import Array, transform
from aioduco.sim.planner.motion_limits import joint_limits, tool_limits
from aioduco.sim.planner.path import Path, PlanError
from aioduco.sim.planner.slices import yield_now
from aioduco.sim.planner.timing import PathLimits, allowed, backward
from aioduco.sim.planner.tracing import check_limits, fit, trace

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.sim.planner.segments import ExternalAxesMove, Segment


def blended(first: ExternalAxesMove, second: ExternalAxesMove, leave: float, enter: float) -> Path:
    """Give the path of the axes through a blend: the sum of their movements in both motions.

    Args:
        first: movement in the motion before the blend.
        second: movement in the motion behind it; the same axes.
        leave: distance on the first motion where the blend begins.
        enter: distance on the second motion where it ends.
    """
    assert first.path is not None
    assert second.path is not None
    # Like the arm: the first motion decelerates evenly to rest, while the second accelerates.
    left = first.end - first.path.sample(np.array([leave]))[0, 0]
    gone = second.path.sample(np.array([enter]))[0, 0] - second.start
    coefficients = np.zeros((6, len(left)))
    coefficients[0] = first.end - left
    coefficients[1] = 2.0 * left
    coefficients[2] = gone - left
    return Path.of_one(coefficients, 2.0 * enter)


_PIECES = 24
_LEAST = 1e-6  # radius below which there is no blend [m]
_SEARCH = 129  # samples of the search for the blend radius


class CornerLaw(NamedTuple):
    """How a corner is cut.

    Attributes:
        reach: distance at which the tool leaves its path before the corner, as a share of the
            blend radius.
        share: share of the acceleration that the bend takes; the rest changes the speed along it.
    """

    reach: float = 1.0
    share: float = 0.8


class Corners(NamedTuple):
    """How corners are cut after joint moves, and after motions on a curve of the tool."""

    joint: CornerLaw = CornerLaw()
    line: CornerLaw = CornerLaw()

    def after(self, segment: Segment) -> CornerLaw:
        """The law for the corner at the end of a motion."""
        return self.joint if segment.curve is None else self.line


class Blend(NamedTuple):
    """A corner that is cut.

    Attributes:
        leave: distance on the first motion where the blend begins.
        enter: distance on the second motion where it ends.
        path: path of the blend, in the unit of the second motion; its length is twice `enter`.
        limits: limits along the path.
        ratio: distance on the second motion per distance on the first where the blend begins.
        axes: path of the external axes; None if there are none.
    """

    leave: float
    enter: float
    path: Path
    limits: PathLimits
    ratio: float
    axes: Path | None = None


def blend(first: Segment, second: Segment, corners: Corners = Corners()) -> Blend | None:  # noqa: B008 - a value
    """Blend one motion into the next, within the radius of the first.

    While the first motion decelerates to its end, the second accelerates from its start, and both
    movements are added. Two straight lines give a parabola. A blend takes at most half of each
    motion.

    Args:
        first: a motion with a blend radius.
        second: the motion that begins where the first ends.
        corners: how corners are cut.

    Returns:
        The blend; None if none is possible, for instance between motions with different external
        axes: the first motion then stops at its end.
    """
    if first.path is None or second.path is None or first.radius < _LEAST:
        return None
    one, two = first.axes, second.axes
    if (one and one.numbers) != (two and two.numbers):
        return None
    law = corners.after(first)
    radius = law.reach * first.radius
    left = _reach(first, radius, backwards=True)
    yield_now()
    enter = _reach(second, radius, backwards=False)
    yield_now()
    if left is None or enter is None:
        return None
    corner = _Corner(first, second, first.path.end - left, enter)
    together = (
        first.curve is not None
        and second.curve is not None
        and np.array_equal(first.tool, second.tool)
    )
    try:
        if together:
            start = corner.joints(np.zeros(1))[0]
            yield_now()
            path = trace(first.arm, start, corner, first.tool)
        else:
            path, samples = fit(corner.joints, corner.length, _PIECES)
            check_limits(first.arm, samples)
    except PlanError:
        return None
    nodes = path.nodes()
    joints = path.sample(nodes)
    yield_now()
    speed = first.v + (second.v - first.v) * nodes / corner.length
    if together:
        points, rate = corner.poses(nodes)[:, :3, 3], min(first.a, second.a)
        yield_now()
        limits = tool_limits(first.arm, nodes, joints, points, speed, rate, share=law.share)
    else:
        # Between a joint move and a line only the joints have a common limit.
        moves = [segment for segment in (first, second) if segment.curve is None]
        rate = min((segment.a for segment in moves), default=math.inf)
        common = speed if len(moves) == 2 else math.inf
        limits = joint_limits(first.arm, nodes, joints, common, rate, share=law.share)
    axes = None
    if one is not None and two is not None:
        axes = blended(one, two, corner.leave, enter)
        for move in (one, two):
            limits = limits.stricter(move.limits(axes, nodes, law.share))
    return Blend(corner.leave, enter, path, limits, enter / left, axes)


class _Corner:
    """The sum of the end of one motion and the start of the next.

    Attributes:
        leave: distance on the first motion where the blend begins.
        enter: distance on the second motion where it ends.
        length: length of the blend, in the unit of the second motion.
        turning: largest angle by which the orientation may turn [rad].
        detail: distance between samples that resolves each of its bends.
    """

    def __init__(self, first: Segment, second: Segment, leave: float, enter: float) -> None:
        self._first, self._second = first, second
        self.leave, self.enter = leave, enter
        self.length = 2.0 * enter
        self.turning = sum(
            segment.curve.turning if segment.curve is not None else 0.0
            for segment in (first, second)
        )
        # At its ends the blend moves twice as fast along one of the two curves as at its middle.
        self.detail = 0.5 * min(
            segment.curve.detail if segment.curve is not None else math.inf
            for segment in (first, second)
        )

    def _distances(self, s: Array) -> tuple[Array, Array]:
        # One decelerates evenly while the other accelerates.
        u = s / self.length
        return (
            self.leave + (self._first.length - self.leave) * (2.0 * u - u * u),
            self.enter * u * u,
        )

    def joints(self, s: Array) -> Array:
        """Give the joints [rad], summed joint by joint. Shape (n,) to (n, 6)."""
        one, two = self._distances(s)
        assert self._first.path is not None
        assert self._second.path is not None
        q: Array = self._first.path.sample(one)[:, 0] + self._second.path.sample(two)[:, 0]
        return q - self._second.q_start

    def poses(self, s: Array) -> Array:
        """Give the tool centre point from summed positions and turns. Shape (n,) to (n, 4, 4)."""
        assert self._first.curve is not None
        assert self._second.curve is not None
        one, two = self._distances(s)
        first, second = self._first.curve.poses(one), self._second.curve.poses(two)
        corner = self._second.curve.poses(np.zeros(1))[0]
        rotations = first[:, :3, :3] @ corner[:3, :3].T @ second[:, :3, :3]
        return transform(rotations, first[:, :3, 3] + second[:, :3, 3] - corner[:3, 3])


def _reach(segment: Segment, radius: float, *, backwards: bool) -> float | None:
    """Give the distance along a motion, from one end, at which the tool is a radius away."""
    along = np.linspace(0.0, 0.5 * segment.length, _SEARCH)
    points = segment.tcp(segment.length - along if backwards else along)[:, :3, 3]
    yield_now()
    away = np.linalg.norm(points - points[0], axis=1)
    if away.max() < 1e-6:
        return None  # the motion only turns: a radius does not apply
    outside = np.flatnonzero(away >= radius)
    if not len(outside):
        return float(along[-1])
    i = int(outside[0])
    part = (radius - away[i - 1]) / (away[i] - away[i - 1])
    return float(along[i - 1] + part * (along[i] - along[i - 1]))


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A motion in the queue, from the blend into it to the blend out of it.

    Attributes:
        key: the motion's key.
        segment: the motion.
        path: the blend into it and the rest of its own path; None if it does not move.
        limits: along that path.
        blend: the blend into it, which is the first part of its path.
        blends: whether it ends in a blend into the next motion.
        exit: highest (ds/dt)² at its end that the motions after it allow.
        back: highest (ds/dt)² at each node of its limits.
        axes: path of the external axes along `path`; None if they do not move.
    """

    key: int
    segment: Segment
    path: Path | None
    limits: PathLimits | None
    blend: Blend | None = None
    blends: bool = False
    exit: float = -1.0
    back: Sequence[float] = ()
    axes: Path | None = None

    @property
    def length(self) -> float:
        """Length of its path between the blends, the blend into it included."""
        return self.path.end if self.path is not None else 0.0


def alone(key: int, segment: Segment) -> Entry:
    """Give the entry of a motion that begins and ends at rest.

    Args:
        key: the motion's key.
        segment: the motion.
    """
    axes = segment.axes.path if segment.axes is not None else None
    entry = Entry(key, segment, segment.path, segment.limits, axes=axes)
    return _with_exits((entry,))[0]


def joined(
    queue: tuple[Entry, ...],
    new: Entry,
    corners: Corners = Corners(),  # noqa: B008 - a value
) -> tuple[Entry, ...] | None:
    """Blend the last motion of a queue into a new one.

    Args:
        queue: the queue, the running motion first.
        new: the new motion, alone.
        corners: how corners are cut.

    Returns:
        The new queue; None if the last motion stops at its end.
    """
    corner = blend(queue[-1].segment, new.segment, corners) if queue else None
    if corner is None:
        return None
    left = _leave(queue[-1], corner)
    return _with_exits((*queue[:-1], left, _enter(new, corner)))


def keeps(entry: Entry, at: float, speed: float) -> bool:
    """Whether a running motion can follow another entry for the same motion.

    Args:
        entry: the other entry.
        at: distance along its path.
        speed: highest ds/dt there by the time law that the motion follows now.
    """
    if entry.path is None or entry.limits is None:
        return True
    return at < entry.path.end and speed * speed <= allowed(entry.limits, entry.back, at)


def _leave(entry: Entry, corner: Blend) -> Entry:
    assert entry.path is not None
    assert entry.limits is not None
    end = corner.leave + (entry.blend.enter if entry.blend is not None else 0.0)
    path = entry.path.slice(0.0, end)
    yield_now()
    return replace(
        entry,
        path=path,
        limits=entry.limits.slice(0.0, end),
        blends=True,
        exit=-1.0,
        axes=entry.axes.slice(0.0, end) if entry.axes is not None else None,
    )


def _enter(entry: Entry, corner: Blend) -> Entry:
    assert entry.path is not None
    assert entry.limits is not None
    axes = entry.axes
    if axes is not None and corner.axes is not None:
        axes = corner.axes.then(axes.slice(corner.enter, axes.end))
    path = entry.path.slice(corner.enter, entry.path.end)
    yield_now()
    path = corner.path.then(path)
    yield_now()
    limits = entry.limits.slice(corner.enter, entry.path.end)
    yield_now()
    limits = corner.limits.then(limits)
    yield_now()
    # The motion still ends at rest, but its nodes have changed.
    return replace(entry, path=path, limits=limits, blend=corner, axes=axes, exit=-1.0)


def _with_exits(queue: tuple[Entry, ...]) -> tuple[Entry, ...]:
    """Compute how fast each motion may end, from the last one to the first."""
    entries = list(queue)
    exit_ = 0.0
    for i in range(len(queue) - 1, -1, -1):
        entry = queue[i]
        if entry.exit == exit_:
            break  # nothing changed for this one, nor for those before it
        if entry.limits is None:
            entries[i] = replace(entry, exit=exit_)
            exit_ = 0.0
            continue
        back = backward(entry.limits, exit_)
        entries[i] = replace(entry, exit=exit_, back=back)
        exit_ = back[0] / entry.blend.ratio**2 if entry.blend is not None else 0.0
    return tuple(entries)
