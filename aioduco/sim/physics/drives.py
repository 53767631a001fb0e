"""The drives: how far the joints trail their set-points, and how warm they get.

Each joint has a position loop with a gain and a share of velocity feed-forward:
speed = gain·(set-point - joint) + share·(speed of the set-point). In steady motion the joint then
trails its set-point by a constant time, the lag = (1 - share)/gain; the gain shows while the speed
changes. Without feed-forward the gain is 1/lag.

Joints and drive boards get warm with the load, slowly (manual 1.2). The vendor publishes no thermal
data. The figures are typical of a machine of this size: at its largest torque a joint settles 40 °C
above the room, with a time constant of ten minutes.
"""

from __future__ import annotations

import math
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


#: temperature of the room [°C]
AMBIENT = 25.0
#: rise of a joint's and its board's temperature at the joint's largest torque [°C]
_JOINT_RISE, _BOARD_RISE = 40.0, 20.0
#: rise of a board's temperature when it has power [°C]
_POWERED_RISE = 5.0
#: time constants [s]
_JOINT_TIME, _BOARD_TIME = 600.0, 120.0


class Temperatures:
    """Temperatures of six joints and of their drive boards, without a clock.

    The heat is proportional to the square of the torque, like a motor's heat to the square of its
    current.

    Args:
        effort: largest torques of the joints [N m].

    Attributes:
        joints: temperatures of the joints [°C]. Shape (6,).
        boards: temperatures of the drive boards [°C]. Shape (6,).
    """

    def __init__(self, effort: Sequence[float]) -> None:
        self._effort = np.array(effort)
        self.joints: Array = np.full(6, AMBIENT)
        self.boards: Array = np.full(6, AMBIENT)

    def tick(self, passed: float, torque: Array, *, powered: bool) -> None:
        """Advance by some time; the arrays are replaced, not changed.

        Args:
            passed: time that has passed [s].
            torque: torques of the joints' drives in this time [N m]. Shape (6,).
            powered: whether the drives have power.
        """
        load = np.square(torque / self._effort)
        joint = AMBIENT + _JOINT_RISE * load
        board = AMBIENT + _BOARD_RISE * load + (_POWERED_RISE if powered else 0.0)
        self.joints = joint + (self.joints - joint) * math.exp(-passed / _JOINT_TIME)
        self.boards = board + (self.boards - board) * math.exp(-passed / _BOARD_TIME)
