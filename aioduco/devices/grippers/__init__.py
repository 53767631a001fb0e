"""Grippers: one interface; drivers for Robotiq, DH, digital outputs and suction.

    async with Robotiq.at_tool(robot, "robotiq_2f85") as gripper:
        await gripper.activate()
        await gripper.close(force=40.0)
        async with gripper.carrying():  # stops the arm if the part is lost
            await robot.motion.movel(there, v=0.2, a=0.5)
        await gripper.open()

`robotiq_registers` and `dh_registers` are the manufacturers' register maps, without I/O. The
drivers use only a robot's public interface, and never the lane of its motions. `sync` and `cli`
may import this package.
"""

from __future__ import annotations

from aioduco.devices.grippers.dh import DhGripper
from aioduco.devices.grippers.digital import DigitalGripper
from aioduco.devices.grippers.gripper import GripperState, PolledGripper
from aioduco.devices.grippers.modbus_gripper import ModbusGripper
from aioduco.devices.grippers.robotiq import Robotiq
from aioduco.devices.grippers.vacuum import VacuumGripper
from aioduco.models.gripper_models import GRIPPERS, GripperModel, gripper_model

__all__ = [
    "GRIPPERS",
    "DhGripper",
    "DigitalGripper",
    "GripperModel",
    "GripperState",
    "ModbusGripper",
    "PolledGripper",
    "Robotiq",
    "VacuumGripper",
    "gripper_model",
]
