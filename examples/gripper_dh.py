"""Grip something with a DH gripper at the tool's RS-485 port, and let it go.

    python gripper_dh.py 192.168.1.10     the gripper moves: keep fingers out of it

The tool's port must be set to the gripper's bit rate, 115200 from the factory.
"""

from __future__ import annotations

import argparse

import anyio

import aioduco
from aioduco.devices.grippers import DhGripper


async def main(host: str, port: int) -> None:
    async with (
        aioduco.connect(host, port) as robot,
        DhGripper.at_tool(robot, "dh_ag95") as gripper,
    ):
        await gripper.activate()  # once after power on: the fingers go through all of their stroke
        await gripper.open()
        gripped = await gripper.close(force=60.0)
        print("holds something:", gripped.holding)
        print(f"the fingers are {(gripped.width or 0.0) * 1e3:.1f} mm apart")
        await gripper.open()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    anyio.run(main, given.host, given.port)
