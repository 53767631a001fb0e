"""Move one joint along a sine, with a set-point every 2 ms.

    python 10_sine.py                  on a simulated arm
    python 10_sine.py 192.168.1.10     on a real one: keep clear of it; joint 6 turns by ±6 degrees

The loop decides what to send; a small process of its own sends it, at 500 Hz. If this program hangs
or dies, the arm comes to rest and stands.
"""

from __future__ import annotations

import argparse
import math

import anyio

import aioduco

AMPLITUDE, FREQUENCY = 0.1, 0.5  # rad, Hz


async def main(host: str, port: int, seconds: float) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        *others, last = await robot.state.get_actual_joints_position()

        async with robot.servo.joints(v=1.0, a=5.0, rate=500) as stream:
            async for tick in stream.ticks():
                # (1 - cos)/2 begins at rest, where the arm is.
                swing = (1 - math.cos(2 * math.pi * FREQUENCY * tick.time)) / 2
                await stream.send([*others, last + AMPLITUDE * swing])
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
