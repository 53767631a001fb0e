"""The drives' position loops: how far the joints trail their set-points.

Each joint has a position loop with a gain and a share of velocity feed-forward:
speed = gain·(set-point - joint) + share·(speed of the set-point). In steady motion the joint then
trails its set-point by a constant time, the lag = (1 - share)/gain; the gain shows while the speed
changes. Without feed-forward the gain is 1/lag.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.planner.path import JointSetPoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array


class TrailingDrives:
    """Turns set-points into those that the joints reach, cycle by cycle.

    Args:
        lag: time by which each joint trails in steady motion [s]. Six.
        gain: gain of each position loop [1/s]; infinite for a joint without lag. Six.
        cycle: time between two set-points [s].
    """

    def __init__(self, lag: Sequence[float], gain: Sequence[float], cycle: float) -> None:
        self._lag = np.array(lag)
        gains = np.array(gain)
        self._gain = np.where(np.isfinite(gains), gains, 0.0)
        self._decay: Array = np.exp(-gains * cycle)
        self._cycle = cycle
        self._error = np.zeros(6)
        self._last: Array | None = None

    def reset(self) -> None:
        """Begin again with every joint at its set-point, as after the brakes."""
        self._error = np.zeros(6)
        self._last = None

    def follow(self, setpoint: JointSetPoint) -> JointSetPoint:
        """Return where the joints are at the end of the cycle."""
        last, self._last = self._last, setpoint.q
        if last is None:
            return setpoint
        rate = (setpoint.q - last) / self._cycle
        self._error = self._error * self._decay + self._lag * (1.0 - self._decay) * rate
        slip = self._gain * (self._lag * setpoint.qd - self._error)
        turn = self._gain * (self._lag * setpoint.qdd - slip)
        return JointSetPoint(setpoint.q - self._error, setpoint.qd - slip, setpoint.qdd - turn)
