"""Unit quaternions (w, x, y, z) as plain floats: for one or a few, arrays take ten times as long.

Roll, pitch and yaw are the controller's: R = Rz(rz)·Ry(ry)·Rx(rx).
"""

from __future__ import annotations

from math import atan2, copysign, cos, hypot, pi, sin, sqrt
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Sequence


Quaternion: TypeAlias = tuple[float, float, float, float]


def from_rpy(rx: float, ry: float, rz: float) -> Quaternion:
    """The quaternion of Rz(rz)·Ry(ry)·Rx(rx)."""
    cx, sx = cos(rx / 2), sin(rx / 2)
    cy, sy = cos(ry / 2), sin(ry / 2)
    cz, sz = cos(rz / 2), sin(rz / 2)
    return (
        cz * cy * cx + sz * sy * sx,
        cz * cy * sx - sz * sy * cx,
        cz * sy * cx + sz * cy * sx,
        sz * cy * cx - cz * sy * sx,
    )


def rpy(w: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a quaternion; at a pitch of ±90° roll is set to zero."""
    # Columns of the rotation matrix: hypot keeps the pitch exact near ±90°; asin would not.
    r00, r10, r20 = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)
    level = hypot(r00, r10)
    pitch = atan2(-r20, level)
    if level < 1e-9:
        return 0.0, copysign(pi / 2, pitch), atan2(-2 * (x * y - w * z), 1 - 2 * (x * x + z * z))
    roll = atan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
    return roll, pitch, atan2(r10, r00)


def rotated(q: Sequence[float], vector: Sequence[float]) -> tuple[float, float, float]:
    """A vector, rotated by a quaternion."""
    w, x, y, z = q
    a, b, c = vector
    # twice the cross product of the vector part and the vector; crossed once more below
    u, v, t = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return (
        a + w * u + y * t - z * v,
        b + w * v + z * u - x * t,
        c + w * t + x * v - y * u,
    )


def product(a: Sequence[float], b: Sequence[float]) -> Quaternion:
    """The rotation `b`, and then `a`."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    w = aw * bw - ax * bx - ay * by - az * bz
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    # Normalised each time: a stream multiplies a million quaternions.
    norm = sqrt(w * w + x * x + y * y + z * z)
    return w / norm, x / norm, y / norm, z / norm


def inverse(q: Sequence[float]) -> Quaternion:
    """The rotation back."""
    w, x, y, z = q
    return w, -x, -y, -z


def rotvec(q: Sequence[float]) -> tuple[float, float, float]:
    """The rotation vector, axis times angle, the angle in [0, π] [rad]."""
    w, x, y, z = q if q[0] >= 0 else (-q[0], -q[1], -q[2], -q[3])
    length = sqrt(x * x + y * y + z * z)
    factor = 2 * atan2(length, w) / length if length > 1e-12 else 2.0
    return factor * x, factor * y, factor * z


def from_rotvec(vector: Sequence[float]) -> Quaternion:
    """The quaternion of a rotation vector [rad]."""
    x, y, z = vector
    angle = sqrt(x * x + y * y + z * z)
    factor = sin(angle / 2) / angle if angle > 1e-12 else 0.5
    return cos(angle / 2), factor * x, factor * y, factor * z
