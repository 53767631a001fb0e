"""Connect, bring the arm up, move it, look where it is.

    python 01_connect_and_move.py                  on a simulated arm
    python 01_connect_and_move.py 192.168.1.10     on a real one: keep clear of it

The arm goes to its home, flange down, then its tool 5 cm down along a line and back.
"""

from __future__ import annotations

import argparse

import anyio

import aioduco
from aioduco import Joints, mm

HOME = Joints.deg(30, -15, 105, 0, -90, 0)


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot:
        report = await robot.bring_up()
        print("ready:", report)

        outcome = await robot.motion.movej2(HOME, v=0.8, a=1.5)
        print("at home:", outcome.value)

        here = await robot.state.get_tcp_pose()
        print("the tool is at", here)
        await robot.motion.movel(here.shifted(z=-mm(50)), v=0.1, a=0.5)
        await robot.motion.movel(here, v=0.1, a=0.5)

        apart, turned = here.distance(await robot.state.get_tcp_pose())
        print(f"back, within {apart * 1000:.2f} mm and {turned:.5f} rad")


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
