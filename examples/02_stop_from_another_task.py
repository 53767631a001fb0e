"""Stop a motion: by another task, by a time limit, by leaving.

    python 02_stop_from_another_task.py                  on a simulated arm
    python 02_stop_from_another_task.py 192.168.1.10     on a real one: keep clear of it

Whatever ends the wait for a motion also ends the motion: the arm stands before the wait returns.
Ctrl-C at any time does the same.
"""

from __future__ import annotations

import argparse

import anyio

import aioduco
from aioduco import Joints

LEFT, RIGHT = Joints.deg(30, 0, 90, 0, -90, 0), Joints.deg(-30, 0, 90, 0, -90, 0)


async def watch(robot: aioduco.Robot) -> None:
    """Stop the arm as soon as its first joint has passed zero: a sensor would do the same."""
    joints = await robot.state.get_actual_joints_position()
    while joints.j1 > 0:
        await anyio.sleep(0.01)
        joints = await robot.state.get_actual_joints_position()
    await robot.stop()


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        await robot.motion.movej2(LEFT, v=1.0, a=2.0)

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(watch, robot)
            try:
                await robot.motion.movej2(RIGHT, v=0.5, a=1.0)
            except aioduco.TaskStopped as stopped:
                print("stopped by the other task:", stopped)

        with anyio.move_on_after(0.4):
            await robot.motion.movej2(LEFT, v=0.3, a=1.0)
        print("stopped by the time limit; moving:", await robot.state.robotmoving())

        await robot.motion.movej2(RIGHT, v=0.3, a=1.0).start()
        print("leaving while the arm moves: it is stopped first")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port)
    else:
        from aioduco.sim import Simulator

        with Simulator() as sim:
            anyio.run(main, sim.host, sim.port)
