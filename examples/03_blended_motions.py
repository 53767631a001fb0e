"""Go round a square without stopping at its corners.

    python 03_blended_motions.py                  on a simulated arm
    python 03_blended_motions.py 192.168.1.10     on a real one: keep clear of it

A motion with a blend radius passes into the one after it, if that one is there in time: so
`run` sends some ahead. The same square with stops at the corners takes longer.
"""

from __future__ import annotations

import argparse
import time

import anyio

import aioduco
from aioduco import Joints, Pose, mm

HOME = Joints.deg(30, -15, 105, 0, -90, 0)
SIDE, RADIUS = mm(100), mm(20)


def square(robot: aioduco.Robot, at: Pose, r: float) -> list[aioduco.MotionCommand]:
    corners = [at.shifted(y=SIDE), at.shifted(y=SIDE, z=-SIDE), at.shifted(z=-SIDE), at]
    radii = [r, r, r, 0.0]  # the last one ends with a stop
    return [
        robot.motion.movel(corner, v=0.3, a=1.0, r=radius)
        for corner, radius in zip(corners, radii, strict=True)
    ]


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        await robot.motion.movej2(HOME, v=0.8, a=1.5)
        here = await robot.state.get_tcp_pose()
        for r in (0.0, RADIUS):
            begin = time.monotonic()
            outcomes = await robot.motion.run(*square(robot, here, r))
            took = time.monotonic() - begin
            ends = ", ".join(outcome.value for outcome in outcomes)
            print(f"blend radius {r * 1000:.0f} mm: {took:.2f} s ({ends})")


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
