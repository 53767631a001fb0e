"""Temperatures of joints and drive boards, which follow the load slowly (manual 1.2).

The vendor publishes no thermal data. The figures are those of a machine of this size: at its
largest torque a joint ends 40 °C above the room, with a time constant of ten minutes.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

__all__ = ["AMBIENT", "Temperatures"]

#: temperature of the room [°C]
AMBIENT = 25.0
#: how much warmer a joint and its board become at the joint's largest torque [°C]
_JOINT_RISE, _BOARD_RISE = 40.0, 20.0
#: how much warmer a board becomes that has power [°C]
_POWERED_RISE = 5.0
#: time constants [s]
_JOINT_TIME, _BOARD_TIME = 600.0, 120.0


class Temperatures:
    """Temperatures of six joints and of their drive boards, without a clock.

    The heat is in proportion to the square of the torque, as that of a motor's current is.

    Args:
        effort: largest torques of the joints [N m].

    Attributes:
        joints: temperatures of the joints [°C]. Shape (6,).
        boards: temperatures of the drive boards [°C]. Shape (6,).
    """

    def __init__(self, effort: Sequence[float]) -> None:
        self._effort = np.array(effort)
        self.joints: Vector = np.full(6, AMBIENT)
        self.boards: Vector = np.full(6, AMBIENT)

    def tick(self, passed: float, torque: Vector, *, powered: bool) -> None:
        """Go on by some time; the arrays are new ones.

        Args:
            passed: time [s].
            torque: of the joints' drives in it [N m]. Shape (6,).
            powered: whether the drives have power.
        """
        load = np.square(torque / self._effort)
        joint = AMBIENT + _JOINT_RISE * load
        board = AMBIENT + _BOARD_RISE * load + (_POWERED_RISE if powered else 0.0)
        self.joints = joint + (self.joints - joint) * math.exp(-passed / _JOINT_TIME)
        self.boards = board + (self.boards - board) * math.exp(-passed / _BOARD_TIME)
