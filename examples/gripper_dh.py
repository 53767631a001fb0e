"""Open and close a DH gripper over Modbus RTU at the tool's RS-485 port.

    python gripper_dh.py 192.168.1.10     the gripper moves: keep fingers out of it

The tool's port must be set to the gripper's bit rate, 115200 from the factory. Registers are
those of DH's AG and PG series.
"""

from __future__ import annotations

import sys
from enum import IntEnum

import anyio

import aioduco
from aioduco.bus import ModbusRtu, Port

INITIALIZE, FORCE, POSITION, SPEED = 0x0100, 0x0101, 0x0103, 0x0104
INITIALIZED, GRIP, POSITION_NOW = 0x0200, 0x0201, 0x0202
#: seconds after which what the gripper says is of this motion, even if it was not seen moving
SETTLED = 0.3


class Grip(IntEnum):
    """What the gripper says of its last motion."""

    MOVING = 0
    REACHED = 1
    CAUGHT = 2
    DROPPED = 3


class DhGripper:
    """A DH gripper; positions from 0.0, closed, to 1.0, open."""

    def __init__(self, modbus: ModbusRtu, *, poll: float = 0.05) -> None:
        self._modbus = modbus
        self._poll = poll

    async def initialize(self, *, timeout: float = 10.0) -> None:
        """Find the ends of the stroke: the gripper moves through all of it, once after power on."""
        if await self._read(INITIALIZED) != 1:
            await self._modbus.write_register(INITIALIZE, 1)
            due = anyio.current_time()
            with anyio.fail_after(timeout):
                while await self._read(INITIALIZED) != 1:  # noqa: ASYNC110  # only asking tells
                    await anyio.sleep_until(due := due + self._poll)

    async def move(
        self, position: float, *, force: float = 0.3, speed: float = 0.5, timeout: float = 5.0
    ) -> Grip:
        """Move the fingers, and say how that ended.

        Args:
            position: where to, 0.0 to 1.0.
            force: part of the largest force, 0.2 to 1.0.
            speed: part of the largest speed, 0.01 to 1.0.
            timeout: seconds in which they must have come to rest.
        """
        if not (0.0 <= position <= 1.0 and 0.2 <= force <= 1.0 and 0.01 <= speed <= 1.0):
            raise ValueError("position, force or speed is out of range; nothing was sent")
        await self._modbus.write_register(FORCE, round(force * 100))
        await self._modbus.write_register(SPEED, round(speed * 100))
        await self._modbus.write_register(POSITION, round(position * 1000))
        begun = due = anyio.current_time()
        moved = False
        with anyio.fail_after(timeout):
            while True:
                grip = Grip(await self._read(GRIP))
                # At first it may still tell of the motion before.
                moved = moved or grip is Grip.MOVING or due > begun + SETTLED
                if moved and grip is not Grip.MOVING:
                    return grip
                await anyio.sleep_until(due := due + self._poll)

    async def position(self) -> float:
        """Where the fingers are, 0.0 to 1.0."""
        return await self._read(POSITION_NOW) / 1000

    async def _read(self, address: int) -> int:
        (value,) = await self._modbus.read_registers(address)
        return value


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot:
        gripper = DhGripper(ModbusRtu(Port.tool(robot.bus), unit=1))
        await gripper.initialize()
        print("open:", (await gripper.move(1.0)).name)
        print("close:", (await gripper.move(0.0)).name)
        print(f"the fingers are at {await gripper.position():.3f}")


if __name__ == "__main__":
    anyio.run(main, sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 7003)
