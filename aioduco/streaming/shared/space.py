"""The spaces of set-points, joint angles and poses, and the limits in them.

A stream interpolates and limits *displacements*, six numbers each, so that the same code serves
both: for joints a displacement is a difference of angles, for poses it is a translation and a
rotation vector in the base frame. Rotations are never interpolated as roll, pitch and yaw.
Plain Python: for six numbers it is faster than numpy.
"""

from __future__ import annotations

from math import isfinite, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from aioduco.errors import ControllerError
from aioduco.models.quaternions import (
    from_rotvec,
    from_rpy,
    inverse,
    product,
    rotated,
    rotvec,
    rpy,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


#: a point of a space: six joint angles [rad], or position [m] and unit quaternion (w, x, y, z)
Config = tuple[float, ...]
#: the displacement from one point to another: six numbers [rad], or [m, m, m, rad, rad, rad]
Displacement = tuple[float, ...]

#: default jerk limit, per acceleration limit: full acceleration after 0.1 s [1/s]
JERK = 10.0


class Limits(NamedTuple):
    """Limits of a stream, one number per group of its space.

    Six numbers each for joints; two each for poses, for translation and for rotation.

    Attributes:
        velocity: [rad/s], or [m/s, rad/s].
        acceleration: [rad/s²], or [m/s², rad/s²].
        jerk: [rad/s³], or [m/s³, rad/s³]; kept only with up-sampling by ruckig.
    """

    velocity: tuple[float, ...]
    acceleration: tuple[float, ...]
    jerk: tuple[float, ...] = ()


class JointSpace:
    """Joint angles [rad], each with its own limit."""

    groups: tuple[slice, ...] = tuple(slice(axis, axis + 1) for axis in range(6))
    names: tuple[tuple[str, str], ...] = tuple((f"joint {axis}", "rad") for axis in range(1, 7))

    def decode(self, values: Sequence[float]) -> Config:
        """The point for six numbers of the wire."""
        return tuple(values)

    def encode(self, config: Config) -> tuple[float, ...]:
        """The six numbers of the wire for a point."""
        return config

    def difference(self, start: Config, end: Config) -> Displacement:
        """The displacement from `start` to `end`."""
        s0, s1, s2, s3, s4, s5 = start
        e0, e1, e2, e3, e4, e5 = end
        return (e0 - s0, e1 - s1, e2 - s2, e3 - s3, e4 - s4, e5 - s5)

    def moved(self, start: Config, displacement: Displacement) -> Config:
        """The point that a displacement leads to from `start`."""
        s0, s1, s2, s3, s4, s5 = start
        d0, d1, d2, d3, d4, d5 = displacement
        return (s0 + d0, s1 + d1, s2 + d2, s3 + d3, s4 + d4, s5 + d5)


class PoseSpace:
    """Poses (x, y, z [m], rx, ry, rz [rad], R = Rz·Ry·Rx), limited in speed and turning speed."""

    groups: tuple[slice, ...] = (slice(0, 3), slice(3, 6))
    names: tuple[tuple[str, str], ...] = (("position", "m"), ("orientation", "rad"))

    def decode(self, values: Sequence[float]) -> Config:
        """The point for six numbers of the wire."""
        x, y, z, rx, ry, rz = values
        return (x, y, z, *from_rpy(rx, ry, rz))

    def encode(self, config: Config) -> tuple[float, ...]:
        """The six numbers of the wire for a point."""
        x, y, z, *quaternion = config
        return (x, y, z, *rpy(*quaternion))

    def difference(self, start: Config, end: Config) -> Displacement:
        """The displacement from `start` to `end`; the rotation is the shorter one."""
        if start == end:
            # exactly zero, so that a stream can detect that it is at rest
            return (0.0,) * 6
        x, y, z, *turn = start
        u, v, w, *further = end
        return (u - x, v - y, w - z, *rotvec(product(further, inverse(turn))))

    def moved(self, start: Config, displacement: Displacement) -> Config:
        """The point that a displacement leads to from `start`."""
        x, y, z, *quaternion = start
        u, v, w, *rotation = displacement
        return (x + u, y + v, z + w, *product(from_rotvec(rotation), quaternion))

    def composed(self, pose: Config, offset: Config) -> Config:
        """The pose that an offset leads to; the offset is in the frame of `pose`."""
        x, y, z, *turn = pose
        ox, oy, oz, *further = offset
        u, v, w = rotated(turn, (ox, oy, oz))
        return (x + u, y + v, z + w, *product(turn, further))

    def offset(self, start: Config, end: Config) -> Config:
        """The offset from `start` to `end`, in the frame of `start`."""
        x, y, z, *turn = start
        u, v, w, *further = end
        back = inverse(turn)
        return (*rotated(back, (u - x, v - y, w - z)), *product(back, further))

    def in_axes(self, offset: Config, turn: Config) -> Config:
        """Convert an offset from the axes of a frame to those of a tool that is turned in it."""
        return self.offset(turn, self.composed(offset, turn))


#: what interpolation, limits and states use; each group of a displacement is limited by its length
Space: TypeAlias = JointSpace | PoseSpace

JOINT_SPACE = JointSpace()
POSE_SPACE = PoseSpace()


def six_numbers(read: Sequence[str], answer: Sequence[float]) -> tuple[float, ...]:
    """The six numbers of a place that a controller answered, without those of external axes.

    Args:
        read: the function that was called, and its arguments.
        answer: what it answered.

    Raises:
        ControllerError: these are fewer, or not finite.
    """
    name, *args = read
    six = tuple(answer[:6])
    if len(six) < 6 or not all(map(isfinite, six)):
        of = f" of {args}" if any(args) else ""
        named = ". Is there a tool or work object of that name?" if of else ""
        raise ControllerError(
            name, f"it answered {list(answer)}: the place{of} is not known{named}"
        )
    return six


def read_six(
    call: Callable[[str, tuple[str, ...], float], Any], read: Sequence[str], timeout: float
) -> tuple[float, ...]:
    """Read a place from the controller: `six_numbers`.

    Args:
        call: calls the controller: function of the wire, its arguments, time-out.
        read: the function, and its arguments.
        timeout: time-out of the call [s].

    Raises:
        ControllerError: it answers fewer than six numbers, or some that are not finite.
    """
    name, *args = read
    return six_numbers(read, call(name, tuple(args), timeout))


def too_far(space: Space, start: Config, end: Config, limits: Sequence[float]) -> str:
    """What of a point is further from another one than is allowed; empty if nothing is.

    Args:
        space: the space of the points.
        start: the other point.
        end: the point.
        limits: the largest distances, one per group of the space.
    """
    gap = space.difference(start, end)
    for group, (name, unit), most in zip(space.groups, space.names, limits, strict=True):
        length = sqrt(sum(g * g for g in gap[group]))
        if not length <= most:
            return f"{name}: {length:.4g} {unit} away, where {most:.4g} {unit} are allowed"
    return ""
