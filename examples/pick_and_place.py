"""Pick parts from a row and put them down in another, with a gripper on digital outputs.

    python pick_and_place.py                      on a simulated arm with a simulated gripper
    python pick_and_place.py 192.168.1.10         on a real one: check all poses and signals first

Output 1 closes the gripper. Input 1 says that it is closed on a part, input 2 that it is open. A
gripper that closes and feels no part is said, and the part is left out.
"""

from __future__ import annotations

import argparse

import anyio

import aioduco
from aioduco import Joints, Pose, mm

CLOSE, HOLDS, IS_OPEN = 1, 1, 2
READY = Joints.deg(20, -10, 100, 0, -90, 0)
ABOVE = mm(80)
FROM = [(0.45 + mm(60) * n, 0.15, 0.35) for n in range(3)]  # of the flange; its fingers are on y
TO = [(0.45 + mm(60) * n, -0.15, 0.35) for n in range(3)]


class NoPart(Exception):
    """The gripper closed and holds nothing."""


async def grip(robot: aioduco.Robot, *, closed: bool) -> None:
    """Close or open the gripper, and wait until its sensor says so."""
    await robot.io.set_standard_digital_out(CLOSE, closed)
    sensor = HOLDS if closed else IS_OPEN
    try:
        await robot.wait_for(lambda sample: sample.io.digital_inputs[sensor - 1], timeout=2.0)
    except TimeoutError:
        if closed:
            await grip(robot, closed=False)
            raise NoPart from None
        raise


async def reach(robot: aioduco.Robot, place: tuple[float, float, float], *, closed: bool) -> None:
    """Go to a place from above, grip or let go, and up again."""
    down = Pose(*place, 3.14159265, 0.0, 0.0)
    above = down.shifted(z=ABOVE)
    async with robot.motion.path() as path:  # blends into the way down
        await path.add(robot.motion.movej_pose2(above, v=1.0, a=2.0, r=mm(20), q_near=READY))
        await path.add(robot.motion.movel(down, v=0.1, a=0.5))
    try:
        await grip(robot, closed=closed)
    except NoPart:  # only then: after Ctrl-C, or when a sensor fails, the arm stays where it is
        await robot.motion.movel(above, v=0.2, a=0.8)
        raise
    await robot.motion.movel(above, v=0.2, a=0.8)


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port, state_rate=50) as robot:
        await robot.bring_up()
        await robot.motion.movej2(READY, v=1.0, a=2.0)
        await grip(robot, closed=False)
        placed = 0
        for number, (here, there) in enumerate(zip(FROM, TO, strict=True), 1):
            try:
                await reach(robot, here, closed=True)
            except NoPart:
                print(f"part {number}: nothing there")
                continue
            await reach(robot, there, closed=False)
            placed += 1
            print(f"part {number}: placed")
        await robot.motion.movej2(READY, v=1.0, a=2.0)
        print(f"{placed} of {len(FROM)} placed")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port)
    else:
        from aioduco.devices.grippers import gripper_model
        from aioduco.sim import Simulator
        from aioduco.sim.scene import Box, Table

        size = (mm(30), mm(40), mm(60))
        below = gripper_model("parallel").length
        parts = [Box(at=(x, y, z - below), size=size, mass=0.2) for x, y, z in FROM]
        table = Table(at=(0.51, 0.0, 0.35 - below - size[2] / 2), size=(0.3, 0.5))
        with Simulator.spawn(gripper="parallel", scene=[table, *parts]) as sim:
            anyio.run(main, sim.host, sim.port)
