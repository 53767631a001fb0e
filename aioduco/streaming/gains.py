"""How closely the controller follows a servo's set-points."""

from __future__ import annotations

from dataclasses import dataclass

from aioduco.models import ranges

__all__ = ["ServoGains"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoGains:
    """How closely the controller follows a servo's set-points (manual 1.3.5, servoj).

    Attributes:
        kp: proportional gain, from 0; the manual advises its default.
        kd: derivative gain, from 0; the manual advises its default.
        smooth_vel: smoothing of the velocity, 1 to 100; larger is smoother and lags more.
        smooth_acc: smoothing of the acceleration, 0 to 1; larger is smoother and lags more.
    """

    kp: float = 200.0
    kd: float = 25.0
    smooth_vel: float = 10.0
    smooth_acc: float = 1.0

    def wire(self) -> list[float]:
        """Check the four gains and return them in the order of a servo call's last arguments.

        Raises:
            ParameterError: a gain is out of range.
        """
        return [
            ranges.SERVO_KP("kp", self.kp),
            ranges.SERVO_KD("kd", self.kd),
            ranges.SERVO_SMOOTH_VELOCITY("smooth_vel", self.smooth_vel),
            ranges.SERVO_SMOOTH_ACCELERATION("smooth_acc", self.smooth_acc),
        ]
