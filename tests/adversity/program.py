"""A program that moves the arm until it is ended: to be killed, frozen, interrupted.

    python program.py HOST PORT HEARTBEAT HANG

It writes a line when the arm moves. HEARTBEAT is in seconds, 0 for none. HANG is the number of
seconds after that line for which it blocks its event loop.
"""

from __future__ import annotations

import sys
import time

import anyio

import aioduco

#: joints between which the arm moves; far from every singularity and limit [rad]
LEFT = (0.4, 0.0, 1.57, 0.0, -1.57, 0.0)
RIGHT = (-0.4, 0.1, 1.4, 0.0, -1.57, 0.2)


async def main(host: str, port: int, heartbeat: float | None, hang: float) -> None:
    async with aioduco.connect(
        host, port, heartbeat=heartbeat, loop_stall_limit=heartbeat or 1.0
    ) as robot:
        await robot.bring_up()
        task = await robot.motion.movej2(LEFT, v=0.5, a=4.0).start()
        sys.stdout.write("moving\n")
        sys.stdout.flush()
        time.sleep(hang)  # noqa: ASYNC251 - a program that hangs
        await task
        while True:
            # two on their way at all times, so that there is always a queue to be dropped
            await robot.motion.run(
                robot.motion.movej2(RIGHT, v=0.5, a=4.0, r=0.1),
                robot.motion.movej2(LEFT, v=0.5, a=4.0),
            )


if __name__ == "__main__":
    _, given_host, given_port, beat, block = sys.argv
    anyio.run(main, given_host, int(given_port), float(beat) or None, float(block))
