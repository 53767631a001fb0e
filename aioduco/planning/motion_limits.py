"""Limits of speed, acceleration and jerk that a plan keeps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.rules import Number, ordered

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm


_JERKS = Number(0.0, unit="rad/s³", open_low=True, source="this package")
_JERK = 10.0  # jerk over acceleration, as for streams [1/s]


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Largest speeds, accelerations and jerks of the joints, six of each.

    Attributes:
        velocity: [rad/s].
        acceleration: [rad/s²].
        jerk: [rad/s³].
    """

    velocity: tuple[float, ...]
    acceleration: tuple[float, ...]
    jerk: tuple[float, ...]

    @classmethod
    def of(
        cls,
        arm: Arm,
        v: float | Sequence[float],
        a: float | Sequence[float],
        jerk: float | Sequence[float] | None,
    ) -> MotionLimits:
        """Make limits from one number for all joints, or from one number for each.

        Args:
            arm: arm whose own limits of speed apply, too: higher speeds are cut to them.
            v: largest joint speed, 0.000175 to 3.926 [rad/s].
            a: largest joint acceleration, from 0.000175 [rad/s²].
            jerk: largest jerk, above 0 [rad/s³]; None: 10 times the acceleration, per second.

        Raises:
            ParameterError: a number is out of range, or there are not six of them.
        """
        speeds = _six("v", v, ranges.JOINT_SPEED)
        accelerations = _six("a", a, ranges.JOINT_ACCELERATION)
        jerks = [_JERK * each for each in accelerations]
        if jerk is not None:
            jerks = _six("jerk", jerk, _JERKS)
        own = [min(one, other) for one, other in zip(speeds, arm.velocity, strict=True)]
        return cls(tuple(own), tuple(accelerations), tuple(jerks))

    @property
    def arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Velocity, acceleration, jerk as arrays. Shape (6,) each."""
        return np.array(self.velocity), np.array(self.acceleration), np.array(self.jerk)


def _six(name: str, value: float | Sequence[float], rule: Number) -> list[float]:
    try:
        found = ordered(name, value, "a number, or six")
    except ParameterError:  # no list
        return [rule(name, cast("float", value))] * 6
    if len(found) != 6:
        raise ParameterError(name, value, "a number, or six")
    return [rule(name, each) for each in found]
