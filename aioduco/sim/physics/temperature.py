"""Temperatures of joints and drive boards, which follow the load slowly (manual 1.2).

The vendor publishes no thermal data. The figures are typical of a machine of this size: at its
largest torque a joint settles 40 °C above the room, with a time constant of ten minutes.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array


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
