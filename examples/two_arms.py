"""Two arms at once: they take turns in a place that both reach, and stop together.

    python two_arms.py                                  two simulated arms
    python two_arms.py 192.168.1.10 192.168.1.11        two real ones: keep clear of both

What one arm does wrong ends the other's motion too: leaving the task group stops both.
"""

from __future__ import annotations

import argparse
from contextlib import AsyncExitStack

import anyio

import aioduco
from aioduco import Joints

AWAY = Joints.deg(90, -10, 100, 0, -90, 0)
SHARED = Joints.deg(0, -10, 100, 0, -90, 0)
ROUNDS = 3


async def work(name: str, robot: aioduco.Robot, place: anyio.Lock) -> None:
    """Go into the shared place and out of it, never while the other arm is there."""
    async with place:  # it may stand there
        await robot.motion.movej2(AWAY, v=1.0, a=2.0)
    for number in range(1, ROUNDS + 1):
        async with place:
            await robot.motion.movej2(SHARED, v=1.0, a=2.0)
            print(f"{name}: in the shared place, {number}")
            # The place is free when the arm is out of it, not when it begins to leave.
            await robot.motion.movej2(AWAY, v=1.0, a=2.0)


async def main(*addresses: tuple[str, int]) -> None:
    async with AsyncExitStack() as stack:
        robots = [
            await stack.enter_async_context(aioduco.connect(host, port)) for host, port in addresses
        ]
        async with anyio.create_task_group() as tasks:
            for robot in robots:
                tasks.start_soon(robot.bring_up)
        place = anyio.Lock()
        async with anyio.create_task_group() as tasks:
            for name, robot in zip(("left", "right"), robots, strict=True):
                tasks.start_soon(work, name, robot, place)
    print("both are done")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("hosts", nargs="*", metavar="host")
    hosts = parser.parse_args().hosts
    if len(hosts) not in (0, 2):
        parser.error("give the addresses of two arms, or none for simulated ones")
    if hosts:
        anyio.run(main, *((host, 7003) for host in hosts))
    else:
        from aioduco.sim import Simulator

        with Simulator() as left, Simulator(model="gcr10_1300") as right:
            anyio.run(main, (left.host, left.port), (right.host, right.port))
