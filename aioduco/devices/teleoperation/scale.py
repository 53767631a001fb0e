"""Conversion of a device's readings to speeds."""

from __future__ import annotations

from dataclasses import dataclass

from aioduco.devices.teleoperation.reading import FLAG, STANDING, Axes, Reading
from aioduco.models import ranges


@dataclass(frozen=True, slots=True, kw_only=True)
class TeleopScale:
    """Speeds at the full deflection of a device.

    Attributes:
        speed: speed along x, y and z, up to 5 [m/s].
        turn_speed: turning speed about x, y and z, up to 3.926 [rad/s].
        joint_speed: speed of each joint, up to 3.926 [rad/s].
    """

    speed: float = 0.05
    turn_speed: float = 0.2
    joint_speed: float = 0.1

    def __post_init__(self) -> None:
        ranges.FINE_SPEED("speed", self.speed)
        ranges.JOINT_SPEED("turn_speed", self.turn_speed)
        ranges.JOINT_SPEED("joint_speed", self.joint_speed)

    def twist(self, reading: Reading) -> Axes:
        """Speed of the tool [m/s, rad/s]; zero while the dead-man switch is not held.

        Raises:
            ParameterError: `held` is neither True nor False.
        """
        if not FLAG("the reading's held", reading.held):
            return STANDING
        x, y, z, rx, ry, rz = reading.axes
        v, w = self.speed, self.turn_speed
        return (x * v, y * v, z * v, rx * w, ry * w, rz * w)

    def joints(self, reading: Reading) -> Axes:
        """Speeds of the joints [rad/s]; zero while the dead-man switch is not held.

        Raises:
            ParameterError: `held` is neither True nor False.
        """
        if not FLAG("the reading's held", reading.held):
            return STANDING
        a, b, c, d, e, f = reading.axes
        v = self.joint_speed
        return (a * v, b * v, c * v, d * v, e * v, f * v)
