"""The spaces of set-points, joint angles and poses, and the limits in them.

A stream interpolates and limits *displacements*, six numbers each, so that the same code serves
both: for joints a displacement is a difference of angles, for poses it is a translation and a
rotation vector in the base frame. Rotations are never interpolated as roll, pitch and yaw.
Plain Python: for six numbers it is faster than numpy.
"""

from __future__ import annotations

from math import atan2, copysign, cos, hypot, pi, sin, sqrt
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Sequence


#: a point of a space: six joint angles [rad], or position [m] and unit quaternion (w, x, y, z)
Config = tuple[float, ...]
#: the displacement from one point to another: six numbers [rad], or [m, m, m, rad, rad, rad]
Displacement = tuple[float, ...]

Quaternion = tuple[float, float, float, float]


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
        return (x, y, z, *_quaternion(rx, ry, rz))

    def encode(self, config: Config) -> tuple[float, ...]:
        """The six numbers of the wire for a point."""
        x, y, z, *quaternion = config
        return (x, y, z, *_angles(*quaternion))

    def difference(self, start: Config, end: Config) -> Displacement:
        """The displacement from `start` to `end`; the rotation is the shorter one."""
        if start == end:
            # exactly zero, so that a stream can detect that it is at rest
            return (0.0,) * 6
        x, y, z, qw, qx, qy, qz = start
        u, v, w, *quaternion = end
        turn = _product(quaternion, (qw, -qx, -qy, -qz))
        return (u - x, v - y, w - z, *_rotation_vector(turn))

    def moved(self, start: Config, displacement: Displacement) -> Config:
        """The point that a displacement leads to from `start`."""
        x, y, z, *quaternion = start
        u, v, w, *rotation = displacement
        return (x + u, y + v, z + w, *_product(_exponential(rotation), quaternion))

    def composed(self, pose: Config, offset: Config) -> Config:
        """The pose that an offset leads to; the offset is in the frame of `pose`."""
        x, y, z, *turn = pose
        ox, oy, oz, *further = offset
        u, v, w = rotated(turn, (ox, oy, oz))
        return (x + u, y + v, z + w, *_product(turn, further))

    def offset(self, start: Config, end: Config) -> Config:
        """The offset from `start` to `end`, in the frame of `start`."""
        x, y, z, qw, qx, qy, qz = start
        u, v, w, *turn = end
        back = (qw, -qx, -qy, -qz)
        return (*rotated(back, (u - x, v - y, w - z)), *_product(back, turn))

    def in_axes(self, offset: Config, turn: Config) -> Config:
        """Convert an offset from the axes of a frame to those of a tool that is turned in it."""
        return self.offset(turn, self.composed(offset, turn))


#: what interpolation, limits and states use; each group of a displacement is limited by its length
Space: TypeAlias = JointSpace | PoseSpace

JOINT_SPACE = JointSpace()
POSE_SPACE = PoseSpace()


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


def _quaternion(rx: float, ry: float, rz: float) -> Quaternion:
    """The unit quaternion of Rz(rz)·Ry(ry)·Rx(rx)."""
    cx, sx = cos(rx / 2), sin(rx / 2)
    cy, sy = cos(ry / 2), sin(ry / 2)
    cz, sz = cos(rz / 2), sin(rz / 2)
    return (
        cz * cy * cx + sz * sy * sx,
        cz * cy * sx - sz * sy * cx,
        cz * sy * cx + sz * cy * sx,
        sz * cy * cx - cz * sy * sx,
    )


def _angles(w: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a unit quaternion; at a pitch of ±90° roll is set to zero."""
    # Columns of the rotation matrix: hypot keeps the pitch exact near ±90°; asin would not.
    r00, r10, r20 = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)
    level = hypot(r00, r10)
    pitch = atan2(-r20, level)
    if level < 1e-9:
        return 0.0, copysign(pi / 2, pitch), atan2(-2 * (x * y - w * z), 1 - 2 * (x * x + z * z))
    roll = atan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
    return roll, pitch, atan2(r10, r00)


def rotated(q: Sequence[float], vector: Sequence[float]) -> tuple[float, float, float]:
    """A vector, rotated by a unit quaternion."""
    w, x, y, z = q
    a, b, c = vector
    # twice the cross product of the vector part and the vector; crossed once more below
    u, v, t = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return (
        a + w * u + y * t - z * v,
        b + w * v + z * u - x * t,
        c + w * t + x * v - y * u,
    )


def _product(a: Sequence[float], b: Sequence[float]) -> Quaternion:
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    w = aw * bw - ax * bx - ay * by - az * bz
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    # Normalised each time: a stream multiplies a million quaternions.
    norm = sqrt(w * w + x * x + y * y + z * z)
    return w / norm, x / norm, y / norm, z / norm


def _rotation_vector(q: Quaternion) -> tuple[float, float, float]:
    w, x, y, z = q if q[0] >= 0 else (-q[0], -q[1], -q[2], -q[3])
    length = sqrt(x * x + y * y + z * z)
    factor = 2 * atan2(length, w) / length if length > 1e-12 else 2.0
    return factor * x, factor * y, factor * z


def _exponential(vector: Sequence[float]) -> Quaternion:
    x, y, z = vector
    angle = sqrt(x * x + y * y + z * z)
    factor = sin(angle / 2) / angle if angle > 1e-12 else 0.5
    return cos(angle / 2), factor * x, factor * y, factor * z
