"""Whether the arm stands: it comes to rest after its set-points, and may tremble."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from aioduco.sim.cycle import Sensed

__all__ = ["Standstill"]

#: joint speed above which an arm counts as moving [rad/s]
_SPEED = 2e-3
#: and above which it does more than swing out at the end of a motion [rad/s]
_TURNING = 0.1
#: time below it that counts as standing: a joint that swings is slow at its turning points [s]
_REST = 0.02
#: time after the set-points stand, after which an arm counts as standing in any case [s]
_PATIENCE = 0.5


class Standstill:
    """Tells cycle by cycle whether the arm stands.

    Attributes:
        turning: whether a joint is faster than one that swings out.
    """

    def __init__(self) -> None:
        self._commanded = 0.0
        self._last_motion = -math.inf
        self.turning: bool = False

    def tick(self, sensed: Sensed, *, commanded: bool) -> bool:
        """Whether the arm stands, or will not stand more than it does, as one that trembles.

        Args:
            sensed: what is known of the arm.
            commanded: whether its set-points move.
        """
        if commanded:
            self._commanded = sensed.time
        fastest = float(np.abs(sensed.qd).max())
        self.turning = fastest > _TURNING
        if fastest > _SPEED:
            self._last_motion = sensed.time
        # Less than a cycle earlier: whether it is the same cycle must not hang on a rounding.
        if sensed.time - self._last_motion >= _REST - 1e-9:
            return True
        return sensed.time - self._commanded > _PATIENCE
