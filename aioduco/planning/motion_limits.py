"""Limits of speed, acceleration and jerk that a plan keeps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from aioduco.errors import ParameterError
from aioduco.models import ranges

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm

__all__ = ["MotionLimits"]

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
            v: largest joint speed, 0.000175 to 3.93 [rad/s].
            a: largest joint acceleration, from 0.000175 [rad/s²].
            jerk: largest jerk, above 0 [rad/s³]; None: 10 times the acceleration, per second.

        Raises:
            ParameterError: a number is out of range, or there are not six of them.
        """
        speeds = [ranges.JOINT_SPEED("v", each) for each in _six("v", v)]
        accelerations = [ranges.JOINT_ACCELERATION("a", each) for each in _six("a", a)]
        jerks = _six("jerk", jerk) if jerk is not None else [_JERK * a_ for a_ in accelerations]
        if not all(0.0 < each < np.inf for each in jerks):
            raise ParameterError("jerk", jerk, "above 0 rad/s³")
        own = [min(one, other) for one, other in zip(speeds, arm.velocity, strict=True)]
        return cls(tuple(own), tuple(accelerations), tuple(jerks))

    @property
    def arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Velocity, acceleration, jerk as arrays. Shape (6,) each."""
        return np.array(self.velocity), np.array(self.acceleration), np.array(self.jerk)


def _six(name: str, value: float | Sequence[float]) -> list[float]:
    found = (
        [float(each) for each in np.broadcast_to(value, (6,))] if np.size(value) in (1, 6) else []
    )
    if not found:
        raise ParameterError(name, value, "a number, or six")
    return found
