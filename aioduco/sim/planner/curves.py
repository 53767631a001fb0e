"""Curves of the tool centre point in space, with their orientations.

A curve has a length and gives poses for distances along it. Its unit is the metre, or the radian
for a curve that only turns. The length of lines and arcs is given by a formula, that of spirals and
splines by a table.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from aioduco.models.rotation import (
    matrix_from_quaternion,
    matrix_from_rotvec,
    quaternion_from_matrix,
    rotvec_from_matrix,
    transform,
)
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.slices import LONG_SLICE, slices, yield_now

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.models.rotation import Array


POINT = 1e-6  # positions closer than this are the same point [m]
ANGLE = 1e-6  # a smaller turn is none: its direction is a difference of rounding [rad]
_TABLE = 2000  # number of steps in which a curve's length is measured


class Curve(Protocol):
    """A curve of poses."""

    @property
    def length(self) -> float:
        """Distance from the first pose to the last: metres, or radians if the curve only turns."""
        ...

    @property
    def turning(self) -> float:
        """Angle by which the orientation turns from the first pose to the last [rad]."""
        ...

    @property
    def detail(self) -> float:
        """Sampling distance that resolves each bend; infinite if length and `turning` suffice."""
        ...

    def poses(self, s: Array) -> Array:
        """Give the poses at distances s, from zero to `length`. Shape (n,) to (n, 4, 4)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class StraightLine:
    """A straight line; the orientation turns at a constant rate the shorter way.

    If start and end are the same point, it only turns, and its length is the angle; zero if it does
    not turn either.

    Attributes:
        start: first pose. Shape (4, 4).
        end: last pose. Shape (4, 4).
        turn: rotation vector from the first to the last orientation, in the first [rad]. (3,)
        length: metres, or radians if it only turns.
    """

    start: Array
    end: Array
    turn: Array
    length: float

    @classmethod
    def between(cls, start: Array, end: Array) -> StraightLine:
        """Go straight from one pose to another. Shapes (4, 4)."""
        turn = rotvec_from_matrix(start[:3, :3].T @ end[:3, :3])
        metres = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
        angle = float(np.linalg.norm(turn))
        return cls(start, end, turn, metres if metres > POINT else angle if angle > ANGLE else 0.0)

    @property
    def turning(self) -> float:
        """Angle between the first and the last orientation [rad]."""
        return float(np.linalg.norm(self.turn))

    @property
    def detail(self) -> float:
        """Infinite: it has no bends."""
        return math.inf

    def poses(self, s: Array) -> Array:
        """Give the poses at distances s. Shape (n,) to (n, 4, 4)."""
        part = (s / self.length)[:, None]
        rotations = self.start[:3, :3] @ matrix_from_rotvec(part * self.turn)
        return transform(rotations, (1.0 - part) * self.start[:3, 3] + part * self.end[:3, 3])


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A circular arc.

    Attributes:
        start: first pose. Shape (4, 4).
        centre: centre of the circle [m]. Shape (3,).
        axis: unit normal of the circle; the arc turns right-handed about it. Shape (3,).
        angle: angle from the first pose to the last [rad].
        radius: radius of the circle [m].
        turn: rotation vector by which the orientation turns, in the base [rad]. Shape (3,).
    """

    start: Array
    centre: Array
    axis: Array
    angle: float
    radius: float
    turn: Array

    @property
    def length(self) -> float:
        """Length of the arc [m]."""
        return self.radius * self.angle

    @property
    def turning(self) -> float:
        """Angle by which the orientation turns [rad]."""
        return float(np.linalg.norm(self.turn))

    @property
    def detail(self) -> float:
        """Infinite: its length and `turning` determine how it bends."""
        return math.inf

    def poses(self, s: Array) -> Array:
        """Give the poses at distances s. Shape (n,) to (n, 4, 4)."""
        part = (s / self.length)[:, None]
        spoke = self.start[:3, 3] - self.centre
        around = matrix_from_rotvec(part * self.angle * self.axis)
        rotations = matrix_from_rotvec(part * self.turn) @ self.start[:3, :3]
        return transform(rotations, self.centre + around @ spoke)


class Orientation:
    """How a circular move turns the tool (manual section 1.3.5, movec, mode)."""

    TO_TARGET = 0  # turn to the orientation of the target
    FIXED = 1  # keep the orientation of the start
    TANGENT = 2  # keep the orientation relative to the tangent


def arc_through(start: Array, via: Array, end: Array, mode: int, *, full: bool = False) -> Arc:
    """Give the arc from the start through a point to the end.

    Args:
        start: first pose. Shape (4, 4).
        via: a pose whose position is on the arc; its orientation is ignored. Shape (4, 4).
        end: last pose, or another point of a full circle. Shape (4, 4).
        mode: 0 to turn to the orientation of the end, 1 to keep that of the start, 2 to keep it
            relative to the tangent; a full circle takes 1 or 2.
        full: whether to go round the whole circle and back to the start.

    Raises:
        PlanError: the points are on a line or coincide, or the mode is unknown.
    """
    if mode not in (Orientation.FIXED, Orientation.TANGENT) and (full or mode):
        what, modes = ("full circle", "1") if full else ("circular move", "0, 1")
        raise PlanError("parameter", f"mode {mode} of a {what} is not {modes} or 2")
    a, b, c = start[:3, 3], via[:3, 3], end[:3, 3]
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac)
    area = float(np.linalg.norm(normal))
    shortest = min(float(np.linalg.norm(side)) for side in (ab, ac, c - b))
    if shortest < POINT or area < 1e-6 * float(np.linalg.norm(ab) * np.linalg.norm(ac)):
        raise PlanError("parameter", "the three points of a circular move are on one line")
    axis = normal / area
    centre = a + np.cross(normal, ab) * (ac @ ac) / (2 * area**2)
    centre += np.cross(ac, normal) * (ab @ ab) / (2 * area**2)
    spoke = a - centre
    # About this axis the start, the via point and the end follow each other right-handed.
    angle = math.atan2(axis @ np.cross(spoke, c - centre), spoke @ (c - centre)) % (2 * math.pi)
    if full:
        angle = 2 * math.pi
    if mode == Orientation.TO_TARGET:
        turn = rotvec_from_matrix(end[:3, :3] @ start[:3, :3].T)
    elif mode == Orientation.TANGENT:
        turn = angle * axis
    else:
        turn = np.zeros(3)
    return Arc(start, centre, axis, angle, float(np.linalg.norm(spoke)), turn)


class ByLength:
    """A curve given over any parameter u from 0 to 1, converted to the distance along it.

    Args:
        poses: poses over u. Shape (n,) to (n, 4, 4).

    Attributes:
        length: length of the curve of the positions [m].
        turning: angle by which the orientation turns along the curve [rad].
        detail: infinite, as `turning` and the length determine how it bends.
    """

    detail: float = math.inf

    def __init__(self, poses: Callable[[Array], Array]) -> None:
        self._poses = poses
        self._u = np.linspace(0.0, 1.0, _TABLE + 1)
        table = np.empty((_TABLE + 1, 4, 4))
        for part in slices(_TABLE + 1, LONG_SLICE):
            table[part] = poses(self._u[part])
        points, rotations = table[:, :3, 3], table[:, :3, :3]
        step = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if step.min() < 1e-9 / _TABLE:
            raise PlanError("parameter", "the curve stands still somewhere")
        self._s = np.concatenate([[0.0], np.cumsum(step)])
        self._slope = np.gradient(self._u, self._s, edge_order=2)
        self.length: float = float(self._s[-1])
        self.turning: float = 0.0
        back = np.swapaxes(rotations[:-1], -1, -2)
        for part in slices(_TABLE, LONG_SLICE):
            turns = rotvec_from_matrix(back[part] @ rotations[1:][part])
            self.turning += float(np.linalg.norm(turns, axis=1).sum())

    def poses(self, s: Array) -> Array:
        """Give the poses at distances s. Shape (n,) to (n, 4, 4)."""
        i = np.clip(np.searchsorted(self._s, s, side="right") - 1, 0, _TABLE - 1)
        step = self._s[i + 1] - self._s[i]
        t = (s - self._s[i]) / step
        # Cubic between the points of the table, so that accelerations do not jump at them.
        rise = self._u[i + 1] - self._u[i]
        a, b = self._slope[i] * step, self._slope[i + 1] * step
        u = self._u[i] + t * (a + t * (3 * rise - 2 * a - b + t * (a + b - 2 * rise)))
        return self._poses(np.clip(u, 0.0, 1.0))


def spiral(
    start: Array,
    centre: Array,
    turns: float,
    axial: float,
    radius: float,
    end: Array | None = None,
) -> ByLength:
    """Give a spiral from the start (manual 1.3.5, move_spiral).

    It winds about the z axis of the centre; its radius and its height change evenly with the angle.
    (The manual names a centre pose, but no axis: z is an assumption.)

    Args:
        start: first pose. Shape (4, 4).
        centre: a pose whose z axis is that of the spiral. Shape (4, 4).
        turns: number of turns, with fractions; positive is right-handed about z.
        axial: distance along z [m].
        radius: radius at the end [m].
        end: last pose; if given, it determines the radius, the distance along z and the
            orientation, and the turns are those nearest to `turns` that end there. Shape (4, 4).

    Raises:
        PlanError: the start is on the axis, the radius is negative, or the spiral has no length.
    """
    back = np.linalg.inv(centre)
    first = (back @ start)[:3, 3]
    began = math.hypot(first[0], first[1])
    angle = 2 * math.pi * turns
    twist = np.zeros(3)
    if end is not None:
        last = (back @ end)[:3, 3]
        radius, axial = math.hypot(last[0], last[1]), last[2] - first[2]
        between = math.atan2(last[1], last[0]) - math.atan2(first[1], first[0])
        angle = between + 2 * math.pi * round((angle - between) / (2 * math.pi))
        twist = rotvec_from_matrix(end[:3, :3] @ start[:3, :3].T)
    if began < POINT or radius < 0.0:
        raise PlanError("parameter", "a spiral begins at a distance from its axis")
    if abs(angle) * max(began, radius) < POINT and abs(axial) < POINT:
        raise PlanError("parameter", "a spiral without turns goes nowhere")
    azimuth = math.atan2(first[1], first[0])

    def poses(u: Array) -> Array:
        around = azimuth + angle * u
        wide = began + (radius - began) * u
        points = np.stack(
            [wide * np.cos(around), wide * np.sin(around), first[2] + axial * u, np.ones_like(u)],
            axis=-1,
        )
        rotations = matrix_from_rotvec(u[:, None] * twist) @ start[:3, :3]
        return transform(rotations, (points @ centre.T)[:, :3])

    return ByLength(poses)


def spline(start: Array, targets: Sequence[Array]) -> ByLength:
    """Give a smooth curve from the start through poses (manual 1.3.5, spline).

    Position and orientation are natural cubic splines over the distance between the poses, with
    continuous curvature. (The manual does not say which spline it is.)

    Args:
        start: first pose. Shape (4, 4).
        targets: poses through which the curve goes; it ends at the last one. Shapes (4, 4).

    Raises:
        PlanError: there is no target, or two successive poses are at the same point.
    """
    through = np.array([start, *targets])
    chords = np.linalg.norm(np.diff(through[:, :3, 3], axis=0), axis=1)
    if not len(chords) or chords.min() < POINT:
        raise PlanError("parameter", "a spline goes through poses that are apart from each other")
    knots = np.concatenate([[0.0], np.cumsum(chords)]) / chords.sum()
    quaternions = quaternion_from_matrix(through[:, :3, :3])
    yield_now()
    for i in range(1, len(quaternions)):
        if quaternions[i] @ quaternions[i - 1] < 0:
            quaternions[i] *= -1.0
    values = np.concatenate([through[:, :3, 3], quaternions], axis=1)
    bends = _bends(knots, values)
    yield_now()

    def poses(u: Array) -> Array:
        i = np.clip(np.searchsorted(knots, u, side="right") - 1, 0, len(knots) - 2)
        step = (knots[i + 1] - knots[i])[:, None]
        b = (u - knots[i])[:, None] / step
        a = 1.0 - b
        found = a * values[i] + b * values[i + 1]
        found += ((a**3 - a) * bends[i] + (b**3 - b) * bends[i + 1]) * step**2 / 6.0
        unit = found[:, 3:] / np.linalg.norm(found[:, 3:], axis=1, keepdims=True)
        return transform(matrix_from_quaternion(unit), found[:, :3])

    return ByLength(poses)


def _bends(knots: Array, values: Array) -> Array:
    """Give the second derivatives of a natural cubic spline at its knots."""
    count = len(knots)
    step = np.diff(knots)
    matrix = np.eye(count)
    right = np.zeros_like(values)
    slopes = np.diff(values, axis=0) / step[:, None]
    for i in range(1, count - 1):
        if i % 16 == 0:
            yield_now()
        matrix[i, i - 1 : i + 2] = step[i - 1], 2 * (step[i - 1] + step[i]), step[i]
        right[i] = 6 * (slopes[i] - slopes[i - 1])
    return np.linalg.solve(matrix, right).astype(np.float64)
