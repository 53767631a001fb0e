"""Teleoperation: a keyboard, a gamepad or a SpaceMouse leads the arm, at a speed.

    with KeyboardDevice() as device:
        await teleoperate(robot, device, TeleopScale(speed=0.05), frame="base")

`reading`, `keyboard`, `gamepad` and `spacemouse` say what the bytes of a device mean, and when its
dead-man is held: without a device and without a clock. `devices` opens devices by plain files of
Linux, so that nothing has to be installed. `scale` makes speeds of readings, `teleop_loop` leads an
arm by them. `joint_target` makes joint angles of speeds, for those who record positions.
"""

from __future__ import annotations

from aioduco.teleoperation.devices import (
    GamepadDevice,
    InputDevice,
    KeyboardDevice,
    SpaceMouseDevice,
    open_device,
)
from aioduco.teleoperation.joint_target import JointTarget
from aioduco.teleoperation.reading import Reading
from aioduco.teleoperation.scale import TeleopScale
from aioduco.teleoperation.teleop_loop import TeleopReport, teleoperate

__all__ = [
    "GamepadDevice",
    "InputDevice",
    "JointTarget",
    "KeyboardDevice",
    "Reading",
    "SpaceMouseDevice",
    "TeleopReport",
    "TeleopScale",
    "open_device",
    "teleoperate",
]
