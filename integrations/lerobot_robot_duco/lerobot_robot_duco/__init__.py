"""DUCO arms for LeRobot. Importing this registers robot, teleoperators and environments by name."""

from __future__ import annotations

from lerobot_robot_duco.config_duco import (
    DucoConfig,
    DucoEnvConfig,
    DucoGamepadConfig,
    DucoKeyboardConfig,
    DucoLeaderConfig,
    DucoSpaceMouseConfig,
)
from lerobot_robot_duco.duco import Duco
from lerobot_robot_duco.environment import LeRobotObservations, register_environments
from lerobot_robot_duco.teleoperators import (
    DucoGamepad,
    DucoKeyboard,
    DucoLeader,
    DucoSpaceMouse,
)

__all__ = [
    "Duco",
    "DucoConfig",
    "DucoEnvConfig",
    "DucoGamepad",
    "DucoGamepadConfig",
    "DucoKeyboard",
    "DucoKeyboardConfig",
    "DucoLeader",
    "DucoLeaderConfig",
    "DucoSpaceMouse",
    "DucoSpaceMouseConfig",
    "LeRobotObservations",
]

register_environments()
