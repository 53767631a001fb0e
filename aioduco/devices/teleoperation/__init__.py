"""Teleoperation: a person moves the arm at a speed by a keyboard, a gamepad or a SpaceMouse.

    with KeyboardDevice() as device:
        await teleoperate(robot, device, TeleopScale(speed=0.05), frame="base")

`reading`, `keyboard`, `gamepad` and `spacemouse` interpret the bytes of a device and whether its
dead-man switch is held, without a device and without a clock. `devices` opens devices as plain
files of Linux, so that nothing must be installed. `scale` converts readings to speeds, and
`teleop_loop` moves an arm with them. `joint_target` converts speeds to joint angles, for programs
that record positions.
"""

from __future__ import annotations

from aioduco.devices.teleoperation.devices import (
    GamepadDevice,
    InputDevice,
    KeyboardDevice,
    SpaceMouseDevice,
    open_device,
)
from aioduco.devices.teleoperation.joint_target import JointTarget
from aioduco.devices.teleoperation.reading import Reading, ReadingSource
from aioduco.devices.teleoperation.scale import TeleopScale
from aioduco.devices.teleoperation.teleop_loop import TeleopReport, teleoperate

__all__ = [
    "GamepadDevice",
    "InputDevice",
    "JointTarget",
    "KeyboardDevice",
    "Reading",
    "ReadingSource",
    "SpaceMouseDevice",
    "TeleopReport",
    "TeleopScale",
    "open_device",
    "teleoperate",
]
