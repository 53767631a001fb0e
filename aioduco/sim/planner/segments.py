"""Segments: motions with a path and its limits, ready to be timed.

External axes that move together with the arm (外部轴, manual 1.3.14) share the motion's path: the
position of each axis is linear in the distance along it. So one time law moves arm and axes; they
start and end together, and stay synchronous through pauses, stops and changes of the global speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypedDict, Unpack

import numpy as np

from aioduco.kinematics.forward import fkine
from aioduco.models.rotation import Array, rotvec_from_matrix
from aioduco.sim.planner.curves import Curve, StraightLine, arc_through, spiral, spline
from aioduco.sim.planner.motion_limits import SHARE, axes_limits, joint_limits, tool_limits
from aioduco.sim.planner.path import Path, PlanError
from aioduco.sim.planner.slices import LONG_SLICE, slices, yield_now
from aioduco.sim.planner.timing import PathLimits, backward, fastest
from aioduco.sim.planner.tracing import check_limits, pass_singularities, passing_limits, trace

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from aioduco.kinematics import Arm
    from aioduco.sim.planner.weaving import Weave

_STILL = 1e-9  # a motion shorter than this stays where it is [rad, m]
_SAME = 1e-4  # poses that differ by less are the same, at the start of a spline [m, rad]
_SLOWEST = 0.02  # share of the requested speed, below which a path counts as singular


class PathOptions(TypedDict, total=False):
    """What may be added to a path along a curve of the tool.

    Attributes:
        weave: weave to add to the path; None for none.
        around: whether to leave the path near singularities instead of refusing it.
    """

    weave: Weave | None
    around: bool


@dataclass(frozen=True, slots=True, eq=False)
class ExternalAxesMove:
    """Movement of external axes during a motion, in the unit of each: rad or m.

    Attributes:
        numbers: numbers of the axes.
        start: positions at the start. Shape (n,).
        end: positions at the end. Shape (n,).
        velocity: highest speeds [1/s]. Shape (n,).
        acceleration: highest accelerations [1/s²]. Shape (n,).
        braking: accelerations that their drives can do, which a stop uses [1/s²]. Shape (n,).
        path: positions over the distance along the motion's path; None before `segments.carry`.
    """

    numbers: tuple[int, ...]
    start: Array
    end: Array
    velocity: Array
    acceleration: Array
    braking: Array
    path: Path | None = None

    def limits(self, path: Path, nodes: Array, share: float = SHARE) -> PathLimits:
        """Give the limits along the path from the axes' speeds and accelerations."""
        speeds, rates, ways = self.velocity, self.acceleration, path.sample(nodes)
        return axes_limits(nodes, ways, speeds, rates, self.braking, share)


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """One motion: its path and its limits.

    Attributes:
        arm: the arm.
        path: joints over the distance along the path; None if the motion does not move the arm.
        limits: limits along the path.
        q_start: joints at the start [rad]. Shape (6,).
        q_end: joints at the end [rad]. Shape (6,).
        radius: distance of the tool centre point from the end, where it may blend into the next
            motion [m]; zero to stop at the end.
        v: requested speed [m/s, or rad/s for joint moves].
        a: requested acceleration [m/s², or rad/s²].
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        curve: curve of the tool centre point; None for a joint move, and if the tool leaves it.
        axes: movement of external axes meanwhile; None if they do not move.
    """

    arm: Arm
    path: Path | None
    limits: PathLimits | None
    q_start: Array
    q_end: Array
    radius: float
    v: float
    a: float
    tool: Array
    curve: Curve | None = None
    axes: ExternalAxesMove | None = None

    @property
    def length(self) -> float:
        """Length in the unit of the path: radians of the furthest joint, or metres."""
        return self.path.end if self.path is not None else 0.0

    @property
    def duration(self) -> float:
        """Time from standstill to standstill at full speed [s]."""
        if self.limits is None:
            return 0.0
        return fastest(self.limits, backward(self.limits, 0.0), 0.0, 0.0).duration

    def tcp(self, s: Array) -> Array:
        """Give the tool centre point at distances along the path. Shape (n,) to (n, 4, 4)."""
        assert self.path is not None
        joints = self.path.sample(s)[:, 0]
        yield_now()
        poses: Array = fkine(self.arm.geometry, joints) @ self.tool
        return poses


def carry(segment: Segment, before: Mapping[int, float]) -> Segment:
    """Let the external axes of a motion move with it.

    Args:
        segment: the motion, with the movement of its axes.
        before: positions at which the motions before it leave external axes, by number.

    Returns:
        The motion, with the limits of both arm and axes. If the arm does not move, the path is that
        of the axes alone, and its length is one.
    """
    move = segment.axes
    assert move is not None
    start = np.array([before.get(n, at) for n, at in zip(move.numbers, move.start, strict=True)])
    move = replace(move, start=start)
    path, limits = segment.path, segment.limits
    if path is None:
        if np.array_equal(start, move.end):
            return replace(segment, axes=move)
        path = Path.straight(segment.q_start, segment.q_start, 1.0)
    move = replace(move, path=Path.straight(start, move.end, path.end))
    assert move.path is not None
    nodes = np.array(limits.nodes if limits is not None else path.bounds)
    axes = move.limits(move.path, nodes)
    return replace(
        segment, path=path, limits=axes if limits is None else limits.stricter(axes), axes=move
    )


def stay(arm: Arm, q: Array) -> Segment:
    """Stay where the arm is, at joints q [rad]."""
    q = np.array(q, dtype=float)
    return Segment(arm, None, None, q, q, 0.0, 1.0, 1.0, np.eye(4))


def joint_move(
    arm: Arm,
    q0: Array,
    q1: Array,
    v: float,
    a: float,
    r: float = 0.0,
    *,
    tool: Array | None = None,
) -> Segment:
    """Move all joints together, straight in joint space (manual 1.3.5, movej2).

    Args:
        arm: the arm.
        q0: joints at the start [rad]. Shape (6,).
        q1: joints at the end [rad]. Shape (6,).
        v: speed of the joint that turns furthest [rad/s].
        a: its acceleration [rad/s²].
        r: blend radius [m].
        tool: tool centre point in the frame of the flange. Shape (4, 4).

    Raises:
        PlanError: a joint would leave its limits, or a parameter is not positive.
    """
    q0, q1 = np.array(q0, dtype=float), np.array(q1, dtype=float)
    _check(v, a, r)
    try:
        check_limits(arm, q1[None])
    except PlanError as exc:
        exc.joints = q1
        raise
    frame = np.eye(4) if tool is None else tool
    length = float(np.abs(q1 - q0).max())
    if length < _STILL:
        return Segment(arm, None, None, q0, q0, r, v, a, frame)
    path = Path.straight(q0, q1, length)
    ends = np.array(path.bounds)
    limits = joint_limits(arm, ends, path.sample(ends), v, a)
    return Segment(arm, path, limits, q0, q1, r, v, a, frame)


def line_move(
    arm: Arm,
    q0: Array,
    target: Array,
    v: float,
    a: float,
    r: float = 0.0,
    *,
    tool: Array | None = None,
    **options: Unpack[PathOptions],
) -> Segment:
    """Move the tool centre point along a straight line (manual 1.3.5, movel).

    If it only turns, v and a are taken as rad/s and rad/s². (The manual says that they are
    converted in proportion, but gives no factor; a factor of one is an assumption.)

    Args:
        arm: the arm.
        q0: joints at the start [rad]. Shape (6,).
        target: pose of the flange at the end, in the base frame. Shape (4, 4).
        v: speed of the tool centre point [m/s].
        a: its acceleration [m/s²].
        r: blend radius [m].
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        options: what may be added to the path.

    Raises:
        PlanError: unreachable, singular, beyond the joint limits, or a bad parameter.
    """
    start, frame = _start(arm, q0, tool)
    curve = StraightLine.between(start, target @ frame)
    return _cartesian(arm, q0, curve, v, a, r, frame, **options)


def arc_move(
    arm: Arm,
    q0: Array,
    via: Array,
    target: Array,
    v: float,
    a: float,
    r: float = 0.0,
    *,
    mode: int = 0,
    full: bool = False,
    tool: Array | None = None,
    **options: Unpack[PathOptions],
) -> Segment:
    """Move the tool centre point along an arc through a point (manual 1.3.5, movec, move_circle).

    Args:
        arm: the arm.
        q0: joints at the start [rad]. Shape (6,).
        via: pose of the flange at a point of the arc, in the base frame. Shape (4, 4).
        target: pose of the flange at the end, or at another point of a full circle. Shape (4, 4).
        v: speed of the tool centre point [m/s].
        a: its acceleration, along and across the arc together [m/s²].
        r: blend radius [m].
        mode: orientation: 0 turns to that of the target, 1 keeps that of the start, 2 keeps it
            relative to the tangent. A full circle takes 1 or 2.
        full: whether to go once round the whole circle.
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        options: what may be added to the path.

    Raises:
        PlanError: unreachable, singular, beyond the joint limits, or a bad parameter.
    """
    start, frame = _start(arm, q0, tool)
    curve = arc_through(start, via @ frame, target @ frame, mode, full=full)
    return _cartesian(arm, q0, curve, v, a, r, frame, **options)


def spiral_move(
    arm: Arm,
    q0: Array,
    centre: Array,
    turns: float,
    v: float,
    a: float,
    r: float = 0.0,
    *,
    axial: float = 0.0,
    radius: float = 0.0,
    target: Array | None = None,
    tool: Array | None = None,
    **options: Unpack[PathOptions],
) -> Segment:
    """Move the tool centre point along a spiral (manual 1.3.5, move_spiral).

    Args:
        arm: the arm.
        q0: joints at the start [rad]. Shape (6,).
        centre: pose whose z axis is that of the spiral, in the base frame. Shape (4, 4).
        turns: number of turns; positive is right-handed about z.
        v: speed of the tool centre point [m/s].
        a: its acceleration [m/s²].
        r: blend radius [m].
        axial: distance along z [m]; the target's, if there is one.
        radius: radius at the end [m]; the target's, if there is one.
        target: pose of the flange at the end, in the base frame. Shape (4, 4).
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        options: what may be added to the path.

    Raises:
        PlanError: unreachable, singular, beyond the joint limits, or a bad parameter.
    """
    start, frame = _start(arm, q0, tool)
    end = None if target is None else target @ frame
    curve = spiral(start, centre, turns, axial, radius, end)
    return _cartesian(arm, q0, curve, v, a, r, frame, **options)


def spline_move(
    arm: Arm,
    q0: Array,
    targets: Sequence[Array],
    v: float,
    a: float,
    r: float = 0.0,
    *,
    tool: Array | None = None,
    apart: bool = False,
    **options: Unpack[PathOptions],
) -> Segment:
    """Move the tool centre point along a smooth curve through poses (manual 1.3.5, spline).

    Args:
        arm: the arm.
        q0: joints at the start [rad]. Shape (6,).
        targets: poses of the flange, in the base frame. Shapes (4, 4).
        v: speed of the tool centre point [m/s].
        a: its acceleration [m/s²].
        r: blend radius [m].
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        options: what may be added to the path.
        apart: whether the first pose must differ from the start of the motion, as behind another
            spline; otherwise it may be the same.

    Raises:
        PlanError: unreachable, singular, beyond the joint limits, or a bad parameter.
    """
    start, frame = _start(arm, q0, tool)
    through = [target @ frame for target in targets]
    yield_now()
    if not apart and through and _same(start, through[0]):
        del through[0]
        if not through:
            _check(v, a, r)
            return replace(stay(arm, q0), radius=r, v=v, a=a, tool=frame)
    curve = spline(start, through)
    return _cartesian(arm, q0, curve, v, a, r, frame, **options)


def _same(one: Array, other: Array) -> bool:
    """Whether two poses are the same within the precision in which poses are written."""
    turn = rotvec_from_matrix(one[:3, :3].T @ other[:3, :3])
    return bool(np.linalg.norm(one[:3, 3] - other[:3, 3]) < _SAME and np.linalg.norm(turn) < _SAME)


def _start(arm: Arm, q0: Array, tool: Array | None) -> tuple[Array, Array]:
    """Give the tool centre point at the start, and in the frame of the flange. Shapes (4, 4)."""
    frame = np.eye(4) if tool is None else tool
    return fkine(arm.geometry, np.asarray(q0, dtype=float)) @ frame, frame


def _cartesian(
    arm: Arm,
    q0: Array,
    curve: Curve,
    v: float,
    a: float,
    r: float,
    tool: Array,
    weave: Weave | None = None,
    around: bool = False,
) -> Segment:
    q0 = np.array(q0, dtype=float)
    _check(v, a, r)
    if curve.length < _STILL:
        return Segment(arm, None, None, q0, q0, r, v, a, tool)
    woven = None if weave is None else weave.over(curve, v)
    yield_now()
    laid: Curve = curve if woven is None else woven
    kept: Curve | None = laid
    try:
        try:
            path, limits = _followed(arm, q0, curve, laid, v, a, tool)
        except PlanError as exc:
            if exc.code != "singular" or not around:
                raise
            path = pass_singularities(arm, q0, laid, tool)
            limits, kept = passing_limits(arm, path, laid, v, a, tool), None
    except PlanError as exc:
        exc.flange = flange_along(curve, tool)
        raise
    yield_now()
    if woven is not None:
        limits = limits.waiting(woven.stops)
    q_end = path.sample(np.array([path.end]))[0, 0]
    return Segment(arm, path, limits, q0, q_end, r, v, a, tool, kept)


def flange_along(curve: Curve, tool: Array) -> Callable[[float], Array]:
    """Give a function for the pose of the flange at a share of a curve of its tool, 0 to 1.

    Args:
        curve: curve of the tool centre point.
        tool: tool centre point in the frame of the flange. Shape (4, 4).
    """
    back = np.linalg.inv(tool)

    def pose(share: float) -> Array:
        found: Array = curve.poses(np.array([share * curve.length]))[0] @ back
        return found

    return pose


def _followed(
    arm: Arm,
    q0: Array,
    curve: Curve,
    laid: Curve,
    v: float,
    a: float,
    tool: Array,
) -> tuple[Path, PathLimits]:
    """Give the joints' path along `laid`, which is `curve` with or without a weave, and its limits.

    Speed and acceleration are those along `curve`; only the joints limit the weave.
    """
    path = trace(arm, q0, laid, tool)
    nodes = path.nodes()
    points = np.empty((len(nodes), 3))
    for part in slices(len(nodes), LONG_SLICE):
        points[part] = curve.poses(nodes[part])[:, :3, 3]
    limits = tool_limits(arm, nodes, path.sample(nodes), points, v, a)
    yield_now()
    slowest = math.sqrt(np.asarray(limits.ceiling).min())
    # A curve that mostly turns is slow for its turn, at which a singularity has no part.
    wanted = v if curve.turning == 0.0 else min(v, curve.length / curve.turning)
    # One that bends is slow for its bend.
    if (bend := max(limits.curvature)) > 0.0:
        wanted = min(wanted, math.sqrt(a / bend))
    if slowest < _SLOWEST * wanted:
        place = "near a singularity of the path" if laid is curve else "the weave"
        raise PlanError("singular", f"the joints cannot follow {place}")
    return path, limits


def _check(v: float, a: float, r: float) -> None:
    # An infinite acceleration is allowed: only the joints limit it.
    if not (v > 0.0 and a > 0.0 and r >= 0.0 and math.isfinite(v) and math.isfinite(r)):
        raise PlanError("parameter", f"speed {v}, acceleration {a} or radius {r} is not positive")
