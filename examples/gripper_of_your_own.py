"""A driver of one's own: a gripper that takes its width over Modbus, in tenths of a millimetre.

python gripper_of_your_own.py 192.168.1.10     the gripper moves: keep fingers out of it
"""

import argparse
import time

import anyio

import aioduco
from aioduco.devices.bus import ModbusRtu, Port
from aioduco.devices.grippers import GripperModel, GripperState, PolledGripper

MINE = GripperModel("mine", "my gripper", stroke=0.06, force=(5.0, 60.0), speed=None, fastest=0.1,
                    mass=0.5, length=0.12, source="its data sheet")  # fmt: skip


class MyGripper(PolledGripper):
    def __init__(self, modbus: ModbusRtu) -> None:
        super().__init__(MINE)
        self._modbus = modbus

    async def _read(self) -> GripperState:
        width, flags = await self._modbus.read_registers(0x10, 2)
        return GripperState(width * 1e-4, bool(flags & 2), bool(flags & 1), time.monotonic())

    async def _go(self, width: float, speed: float, force: float) -> None:
        words = [round(width * 1e4), round(speed * 1e3), round(force)]
        await self._modbus.write_registers(0x00, words)

    async def _halt(self) -> None:
        await self._modbus.write_register(0x02, 1)


async def main(host: str, port: int) -> None:
    async with (
        aioduco.connect(host, port) as robot,
        MyGripper(ModbusRtu(Port.tool(robot.bus), unit=1)) as gripper,
    ):
        print("holds something:", (await gripper.close(force=20.0)).holding)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    anyio.run(main, given.host, given.port)
