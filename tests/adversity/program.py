"""A program that moves the arm, and ends, or is ended, in one way or another.

    python program.py HOST PORT HEARTBEAT STALL GUARD END

It writes a line when the arm moves: the process id of its guard, 0 without one. HEARTBEAT and
STALL, the stall limit, are in seconds, and a HEARTBEAT of 0 is none. GUARD is "process" or "". END
is what it does then: one of the methods of `Ends`.
"""

from __future__ import annotations

import os
import sys
import time

import anyio

import aioduco
from aioduco.supervision.settings import GuardKind

#: joints between which the arm moves; far from every singularity and limit [rad]
LEFT = (0.4, 0.0, 1.57, 0.0, -1.57, 0.0)
RIGHT = (-0.4, 0.1, 1.4, 0.0, -1.57, 0.2)

#: s for which it hangs
HANG = 3.0


class Ends:
    """What the program does while the arm moves."""

    def __init__(self, robot: aioduco.Robot, task: aioduco.Task) -> None:
        self.robot = robot
        self.task = task

    async def never(self) -> None:
        """Move on for ever, with two motions on their way, so that there is a queue to drop."""
        motion = self.robot.motion
        await self.task
        while True:
            await motion.run(
                motion.movej2(RIGHT, v=0.1, a=4.0, r=0.1), motion.movej2(LEFT, v=0.1, a=4.0)
            )

    async def hang(self) -> None:
        """Block the event loop, then move on."""
        time.sleep(HANG)  # noqa: ASYNC251 - a hung loop is what is tested; it has no condition
        await self.never()

    async def error(self) -> None:
        """A defect."""
        raise KeyError("no such part")

    async def leave(self) -> None:
        """sys.exit in the middle."""
        sys.exit(3)

    async def vanish(self) -> None:
        """End the process without a word."""
        os._exit(3)

    async def forget(self) -> None:
        """End the program without closing the robot."""


async def main(
    host: str, port: int, heartbeat: float | None, stall: float, guard: GuardKind | None, end: str
) -> None:
    robot = aioduco.connect(host, port, heartbeat=heartbeat, loop_stall_limit=stall, guard=guard)
    await robot.open()
    try:
        await robot.bring_up()
        task = await robot.motion.movej2(LEFT, v=0.1, a=4.0).start()
        seat = robot._supervisor.guard
        sys.stdout.write(f"{seat.pid if seat else 0}\n")
        sys.stdout.flush()
        await getattr(Ends(robot, task), end)()
    finally:
        if end != "forget":
            await robot.aclose()


if __name__ == "__main__":
    _, given_host, given_port, beat, limit, kind, given_end = sys.argv
    given_guard: GuardKind | None = "process" if kind == "process" else None
    beat_every = float(beat) or None
    anyio.run(main, given_host, int(given_port), beat_every, float(limit), given_guard, given_end)
