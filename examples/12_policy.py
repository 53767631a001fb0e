"""Follow a policy that thinks 30 times a second, with a set-point every 2 ms and without jerks.

    python 12_policy.py                  on a simulated arm
    python 12_policy.py 192.168.1.10     on a real one: keep clear; joint 6 turns by 25 degrees

A learned policy, a camera or a headset gives targets at a low rate, and some of them late. The
worker brings them up to 500 Hz within limits of speed, acceleration and jerk, in a process that no
inference can hold up.
"""

from __future__ import annotations

import argparse
import math
import random
import time

import anyio

import aioduco
from aioduco import Joints


class Policy:
    """Stands for a network: it looks at the arm, thinks for 5 to 20 ms, and says where to go."""

    def __init__(self, start: Joints) -> None:
        self._start = start
        self._random = random.Random(1)

    def act(self, moment: float, seen: Joints) -> Joints:
        busy = time.monotonic() + self._random.uniform(0.005, 0.020)
        while time.monotonic() < busy:
            math.sqrt(sum(angle * angle for angle in seen))
        turned = self._start.j6 + 0.22 * (1 - math.cos(1.5 * moment))
        return Joints.of([*self._start[:5], turned])


async def main(host: str, port: int, seconds: float) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        policy = Policy(await robot.state.get_actual_joints_position())

        async with robot.servo.joints(
            v=1.5, a=8.0, jerk=150.0, rate=500, latest=True, upsample="ruckig", hold=0.3
        ) as stream:
            async for tick in stream.ticks(30):
                seen = await robot.state.get_actual_joints_position()
                await stream.send(policy.act(tick.time, seen))
                if tick.time >= seconds:
                    break

        print(stream.statistics())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("--port", type=int, default=7003)
    parser.add_argument("--seconds", type=float, default=4.0)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port, given.seconds)
    else:
        from aioduco.sim import Simulator

        with Simulator.spawn() as sim:
            anyio.run(main, sim.host, sim.port, given.seconds)
