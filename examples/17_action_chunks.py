"""Follow a policy that takes 0.2 s to give a second of actions: chunks that overlap, without jerks.

    python 17_action_chunks.py                  on a simulated arm
    python 17_action_chunks.py 192.168.1.10     on a real one: keep clear; joint 6 turns by 25°

Policies with action chunks look, think for long, and then know the next second. Each chunk says of
which moment it is; when it comes, its first actions are late already. The stream's worker leaves
them out, and goes over to the newer chunk within limits of speed, acceleration and jerk.
"""

from __future__ import annotations

import argparse
import math
import random
import time

import anyio

import aioduco
from aioduco import Joints

RATE = 30.0  # actions a second
AHEAD = 30  # actions in a chunk


class Policy:
    """Stands for a network: it sees where the arm is, and thinks where it should be from now on."""

    def __init__(self, start: Joints) -> None:
        self._start = start
        self._random = random.Random(1)

    async def act(self, moment: float) -> list[Joints]:
        await anyio.sleep(self._random.uniform(0.15, 0.25))
        noise = self._random.uniform(-0.01, 0.01)  # no two chunks agree
        times = [moment + number / RATE for number in range(AHEAD)]
        turns = [0.22 * (1 - math.cos(1.5 * each)) + noise for each in times]
        return [Joints.of([*self._start[:5], self._start.j6 + turn]) for turn in turns]


async def main(host: str, port: int, seconds: float) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        policy = Policy(await robot.state.get_actual_joints_position())

        async with robot.servo.joints(
            v=1.5, a=8.0, jerk=150.0, source_rate=RATE, upsample="ruckig", chunks=True
        ) as stream:
            begin = time.monotonic()
            while (seen_at := time.monotonic()) - begin < seconds:
                actions = await policy.act(seen_at - begin)
                await stream.send_chunk(actions, at=seen_at)

        found = stream.statistics()
        print(f"{found.chunks} chunks, {found.actions_late} of their actions came too late")
        print(found)


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
