"""Open and close a Robotiq 2F gripper over Modbus RTU at the tool's RS-485 port.

    python gripper_robotiq.py 192.168.1.10     the gripper moves: keep fingers out of it

The tool's port must be set to the gripper's bit rate, 115200 from the factory. Registers are
those of the instruction manual of the 2F-85 and 2F-140.
"""

from __future__ import annotations

import sys
from enum import IntEnum
from typing import NamedTuple

import anyio

import aioduco
from aioduco.bus import ModbusRtu, Port

COMMAND, STATUS = 0x03E8, 0x07D0
ACTIVATE, GO = 0x0100, 0x0900  # rACT; rACT and rGTO


class Grip(IntEnum):
    """What the gripper says of its last motion (gOBJ)."""

    MOVING = 0
    CAUGHT_OPENING = 1
    CAUGHT_CLOSING = 2
    REACHED = 3


class Status(NamedTuple):
    """What the gripper says of itself."""

    active: bool
    grip: Grip
    fault: int
    requested: int
    position: int


class Robotiq2F:
    """A Robotiq 2F gripper; positions from 0, open, to 255, closed."""

    def __init__(self, modbus: ModbusRtu, *, poll: float = 0.05) -> None:
        self._modbus = modbus
        self._poll = poll

    async def status(self) -> Status:
        """Read what the gripper does."""
        state, echo, now = await self._modbus.read_registers(STATUS, 3)
        bits = state >> 8
        return Status(bits >> 4 & 3 == 3, Grip(bits >> 6), echo >> 8, echo & 0xFF, now >> 8)

    async def activate(self, *, timeout: float = 10.0) -> None:
        """Clear faults and find the ends of the stroke: the gripper moves through all of it."""
        if (await self.status()).active:
            return
        await self._modbus.write_registers(COMMAND, [0, 0, 0])
        await self._modbus.write_registers(COMMAND, [ACTIVATE, 0, 0])
        due = anyio.current_time()
        with anyio.fail_after(timeout):
            while not (await self.status()).active:  # noqa: ASYNC110  # only asking tells
                await anyio.sleep_until(due := due + self._poll)

    async def move(
        self, position: int, *, speed: int = 128, force: int = 64, timeout: float = 5.0
    ) -> Grip:
        """Move the fingers, and say how that ended; each argument is 0 to 255."""
        if not all(0 <= value <= 255 for value in (position, speed, force)):
            raise ValueError("position, speed or force is out of range; nothing was sent")
        await self._modbus.write_registers(COMMAND, [GO, position, speed << 8 | force])
        due = anyio.current_time()
        with anyio.fail_after(timeout):
            while True:
                status = await self.status()
                if status.fault:
                    raise RuntimeError(f"the gripper has fault {status.fault:#04x}")
                # The echo tells that the gripper has taken this request, not the one before.
                if status.requested == position and status.grip is not Grip.MOVING:
                    return status.grip
                await anyio.sleep_until(due := due + self._poll)


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot:
        gripper = Robotiq2F(ModbusRtu(Port.tool(robot.bus), unit=9))
        await gripper.activate()
        print("close:", (await gripper.move(255)).name)
        print("open:", (await gripper.move(0)).name)


if __name__ == "__main__":
    anyio.run(main, sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 7003)
