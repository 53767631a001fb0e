"""Curves of the tool centre point in space: straight lines and arcs, with their orientations.

A curve knows its length and gives poses for distances along it; everything else follows from
that. Its unit is the metre, or the radian for a curve that only turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from aioduco.models.rotation import matrix_from_rotvec, rotvec_from_matrix
from aioduco.sim.planner.errors import PlanError

if TYPE_CHECKING:
    from aioduco.models.rotation import Array

__all__ = ["Arc", "Curve", "Line", "Orientation", "arc_through"]

POINT = 1e-6  # positions closer than this are the same point [m]


class Curve(Protocol):
    """A curve of poses."""

    @property
    def length(self) -> float:
        """Distance from the first pose to the last: metres, or radians where it only turns."""
        ...

    @property
    def turning(self) -> float:
        """Angle that the orientation turns by from the first pose to the last [rad]."""
        ...

    @property
    def detail(self) -> float:
        """Distance between samples that show each of its bends; infinite if `turning` says it."""
        ...

    def poses(self, s: Array) -> Array:
        """Give the poses at distances s, from zero to `length`. Shape (n,) to (n, 4, 4)."""
        ...


def _poses(rotations: Array, points: Array) -> Array:
    poses = np.zeros((len(points), 4, 4))
    poses[:, :3, :3] = rotations
    poses[:, :3, 3] = points
    poses[:, 3, 3] = 1.0
    return poses


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A straight line; the orientation turns at a constant rate the shorter way.

    Where start and end are one point it only turns, and its length is the angle.

    Attributes:
        start: first pose. Shape (4, 4).
        end: last pose. Shape (4, 4).
        turn: rotation vector from the first to the last orientation, in the first [rad]. (3,)
        length: metres, or radians where it only turns.
    """

    start: Array
    end: Array
    turn: Array
    length: float

    @classmethod
    def between(cls, start: Array, end: Array) -> Line:
        """Go straight from one pose to another. Shapes (4, 4)."""
        turn = rotvec_from_matrix(start[:3, :3].T @ end[:3, :3])
        metres = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
        return cls(start, end, turn, metres if metres > POINT else float(np.linalg.norm(turn)))

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
        return _poses(rotations, (1.0 - part) * self.start[:3, 3] + part * self.end[:3, 3])


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A circular arc.

    Attributes:
        start: first pose. Shape (4, 4).
        centre: of the circle [m]. Shape (3,).
        axis: unit normal of the circle; the arc turns about it by the right hand. Shape (3,).
        angle: from the first pose to the last [rad].
        radius: of the circle [m].
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
        """Angle that the orientation turns by [rad]."""
        return float(np.linalg.norm(self.turn))

    @property
    def detail(self) -> float:
        """Infinite: its length and `turning` say how it bends."""
        return math.inf

    def poses(self, s: Array) -> Array:
        """Give the poses at distances s. Shape (n,) to (n, 4, 4)."""
        part = (s / self.length)[:, None]
        spoke = self.start[:3, 3] - self.centre
        around = matrix_from_rotvec(part * self.angle * self.axis)
        rotations = matrix_from_rotvec(part * self.turn) @ self.start[:3, :3]
        return _poses(rotations, self.centre + around @ spoke)


class Orientation:
    """How a circular move turns the tool (manual section 1.3.5, movec, mode)."""

    TO_TARGET = 0  # turn to the orientation of the target
    FIXED = 1  # keep the orientation of the start
    TANGENT = 2  # keep the orientation relative to the tangent


def arc_through(start: Array, via: Array, end: Array, mode: int, *, full: bool = False) -> Arc:
    """Give the arc from the start through a point to the end.

    Args:
        start: first pose. Shape (4, 4).
        via: a pose whose position is on the arc; its orientation plays no part. Shape (4, 4).
        end: last pose, or another point of a full circle. Shape (4, 4).
        mode: 0 to turn to the orientation of the end, 1 to keep that of the start, 2 to keep it
            relative to the tangent.
        full: go round the whole circle and back to the start.

    Raises:
        PlanError: the points are on a line or coincide, or the mode is unknown.
    """
    if mode not in (Orientation.TO_TARGET, Orientation.FIXED, Orientation.TANGENT):
        raise PlanError("parameter", f"mode {mode} of a circular move is not 0, 1 or 2")
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
    # The axis is such that the start, the via point and the end follow each other rightwards.
    angle = math.atan2(axis @ np.cross(spoke, c - centre), spoke @ (c - centre)) % (2 * math.pi)
    if full:
        angle = 2 * math.pi
    if mode == Orientation.TO_TARGET and not full:
        turn = rotvec_from_matrix(end[:3, :3] @ start[:3, :3].T)
    elif mode == Orientation.TANGENT:
        turn = angle * axis
    else:
        turn = np.zeros(3)
    return Arc(start, centre, axis, angle, float(np.linalg.norm(spoke)), turn)
