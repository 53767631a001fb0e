"""Pose, speed and acceleration of a point that the flange carries.

It uses plain floats instead of arrays: for one configuration they are several times as fast, and
clients request the robot's status a thousand times a second.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from aioduco.kinematics.forward import frames
from aioduco.models.rotation import Array, rpy_from_matrix

if TYPE_CHECKING:
    from aioduco.kinematics import Geometry

    Triple = tuple[float, float, float]


class TipMotion(NamedTuple):
    """A tool's tip in the base frame, six numbers each, linear before angular.

    Attributes:
        pose: [m, rad].
        speed: [m/s, rad/s].
        acceleration: [m/s², rad/s²].
    """

    pose: list[float]
    speed: list[float]
    acceleration: list[float]


def tip_motion(geometry: Geometry, q: Array, qd: Array, qdd: Array, offset: Array) -> TipMotion:
    """Compute the motion of a point along the chain of joints.

    Args:
        geometry: the arm's lengths [m].
        q: joints [rad]. Shape (6,).
        qd: joint speeds [rad/s]. Shape (6,).
        qdd: joint accelerations [rad/s²]. Shape (6,).
        offset: the tip in the flange's frame. Shape (4, 4).
    """
    chain = frames(geometry, q)
    end = chain[6] @ offset
    points = [*chain[:6, :3, 3].tolist(), end[:3, 3].tolist()]
    axes = chain[:6, :3, 2].tolist()
    rates, drives = qd.tolist(), qdd.tolist()
    omega = alpha = linear = acceleration = (0.0, 0.0, 0.0)
    for i in range(6):
        z, rate = axes[i], rates[i]
        turn = (z[0] * rate, z[1] * rate, z[2] * rate)
        drive, swing = drives[i], _cross(omega, turn)
        alpha = (
            alpha[0] + z[0] * drive + swing[0],
            alpha[1] + z[1] * drive + swing[1],
            alpha[2] + z[2] * drive + swing[2],
        )
        omega = _add(omega, turn)
        here, there = points[i], points[i + 1]
        arm = (there[0] - here[0], there[1] - here[1], there[2] - here[2])
        across = _cross(omega, arm)
        linear = _add(linear, across)
        acceleration = _add(_add(acceleration, _cross(alpha, arm)), _cross(omega, across))
    pose = [*points[6], *rpy_from_matrix(end[:3, :3]).tolist()]
    return TipMotion(pose, [*linear, *omega], [*acceleration, *alpha])


def _cross(a: Triple, b: Triple) -> Triple:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _add(a: Triple, b: Triple) -> Triple:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
