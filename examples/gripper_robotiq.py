"""Grip something with a Robotiq gripper at the tool's RS-485 port, and carry it.

    python gripper_robotiq.py                     on a simulated arm, which picks up a box
    python gripper_robotiq.py 192.168.1.10        on a real one: arm and gripper move

The tool's port must be set to the gripper's bit rate, 115200 from the factory.
"""

from __future__ import annotations

import argparse

import anyio

import aioduco
from aioduco import Joints, mm
from aioduco.devices.grippers import Robotiq

READY = Joints.deg(0, 0, 90, 0, -90, 0)  # the part is expected 200 mm below, between the fingers


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot, Robotiq.at_tool(robot) as gripper:
        await robot.bring_up()
        await gripper.activate()  # once after power on: the fingers go through all of their stroke
        await gripper.open()
        await robot.motion.movej2(READY, v=1.0, a=2.0)
        above = await robot.state.get_tcp_pose()
        await robot.motion.movel(above.shifted(z=-mm(200)), v=0.2, a=0.5)
        gripped = await gripper.close(force=60.0)
        print("holds something:", gripped.holding)
        async with gripper.carrying():  # stops the arm, and raises, if the part is lost
            await robot.motion.movel(above, v=0.2, a=0.5)
        print(f"lifted, with the fingers {(gripped.width or 0.0) * 1e3:.0f} mm apart")
        await robot.motion.movel(above.shifted(z=-mm(195)), v=0.2, a=0.5)
        await gripper.open()
        await robot.motion.movel(above, v=0.2, a=0.5)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port)
    else:
        from aioduco.devices.grippers import gripper_model
        from aioduco.kinematics import arm
        from aioduco.sim import Simulator
        from aioduco.sim.scene import Box, Table

        x, y, z = arm("gcr5_910").fkine(READY)[:3, 3]
        z -= mm(200) + gripper_model("robotiq_2f85").length
        part = Box(at=(x, y, z), size=(0.04, 0.04, 0.06), mass=0.3, colour=(0.8, 0.3, 0.2))
        table = Table(at=(x, y, z - 0.03), size=(0.3, 0.3))
        with Simulator(gripper="robotiq_2f85", scene=[table, part]) as sim:
            anyio.run(main, sim.host, sim.port)
