"""A program that moves the arm until it is ended.

    python program.py HOST PORT HEARTBEAT GUARD

It writes a line when the arm moves: the process id of its guard, 0 without one. HEARTBEAT is in
seconds, and 0 is none. GUARD is "process" or "".
"""

from __future__ import annotations

import sys

import anyio

import aioduco
from aioduco.supervision.settings import GuardKind

#: joints between which the arm moves; far from every singularity and limit [rad]
LEFT = (0.4, 0.0, 1.57, 0.0, -1.57, 0.0)
RIGHT = (-0.4, 0.1, 1.4, 0.0, -1.57, 0.2)


async def main(host: str, port: int, heartbeat: float | None, guard: GuardKind | None) -> None:
    async with aioduco.connect(
        host, port, heartbeat=heartbeat, loop_stall_limit=30.0, guard=guard
    ) as robot:
        await robot.bring_up()
        motion = robot.motion
        task = await motion.movej2(LEFT, v=0.1, a=4.0).start()
        seat = robot._supervisor.guard
        sys.stdout.write(f"{seat.pid if seat else 0}\n")
        sys.stdout.flush()
        await task
        # two motions on their way, so that there is a queue to drop
        while True:
            await motion.run(
                motion.movej2(RIGHT, v=0.1, a=4.0, r=0.1), motion.movej2(LEFT, v=0.1, a=4.0)
            )


if __name__ == "__main__":
    _, given_host, given_port, beat, kind = sys.argv
    given_guard: GuardKind | None = "process" if kind == "process" else None
    anyio.run(main, given_host, int(given_port), float(beat) or None, given_guard)
