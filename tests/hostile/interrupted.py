"""A program that is interrupted at one line of some modules while it leaves its robot.

    python interrupted.py HOST PORT WHERE

WHERE is the beginning of the names of their files.
For each number that it reads it runs once, in a fork of itself, which has not to load the package;
on a system without forks itself, for the first one alone.
The motion is cancelled, as a first interrupt does it. From then on the lines and the returns of
functions are counted that the main thread runs there; at that number a second interrupt arrives.
What the program writes is where that was, and how it ended.
"""

from __future__ import annotations

import asyncio
import faulthandler
import gc
import os
import sys
from types import FrameType
from typing import Any

import aioduco
from aioduco.robot import _load_needed


class Interruption:
    """Counts lines and returns, and interrupts at one of them."""

    def __init__(self, where: str, number: int) -> None:
        self._where = where
        self._left = number

    def begin(self) -> None:
        """Count from now on, also in what the event loop's tasks are in the middle of."""
        for task in asyncio.all_tasks():
            part: Any = task.get_coro()
            while part is not None:
                frame = getattr(part, "cr_frame", None) or getattr(part, "gi_frame", None)
                if frame is not None:
                    frame.f_trace = self.trace
                part = getattr(part, "cr_await", None) or getattr(part, "gi_yieldfrom", None)
        sys.settrace(self.trace)

    def trace(self, frame: FrameType, event: str, _arg: object) -> Any:
        """Count a line; a trace function."""
        if not frame.f_code.co_filename.startswith(self._where):
            return None
        if event in ("line", "return"):
            self._left -= 1
            if self._left == 0:
                sys.settrace(None)
                sys.stdout.write(f"{frame.f_code.co_filename}:{frame.f_lineno}")
                sys.stdout.flush()
                raise KeyboardInterrupt
        return self.trace


async def main(host: str, port: int, where: str, number: int) -> None:
    interruption = Interruption(where, number)
    async with aioduco.connect(host, port, heartbeat=20.0, loop_stall_limit=15.0) as robot:
        task = await robot.motion.movej2([0, 0, 1.5, 0, -1.5, 0], v=1.0, a=1.0).start()
        here = asyncio.current_task()
        assert here is not None

        def interrupt() -> None:
            interruption.begin()
            here.cancel()

        asyncio.get_running_loop().call_soon(interrupt)
        await task


if __name__ == "__main__":
    # whoever waits in vain for this program ends it by SIGABRT, and reads where it was
    faulthandler.enable()
    _, given_host, given_port, files = sys.argv
    _load_needed()
    gc.freeze()  # or each fork looks through, and copies, all of it
    for line in sys.stdin:
        child = os.fork() if hasattr(os, "fork") else 0
        if not child:
            asyncio.run(main(given_host, int(given_port), files, int(line)))
            sys.exit()
        sys.stdout.write(f" {os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])}\n")
        sys.stdout.flush()
