"""Programs of their own, as a test sees them from outside."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import aioduco
from aioduco.supervision.guard.guarded import GuardClient

#: a program that opens a robot with a guard, does what stands in its place, says the guard's
#: process id, and waits
PROGRAM = """
import sys, anyio, aioduco
async def main():
    robot = aioduco.connect(
        {host!r}, {port}, guard="process", heartbeat={heartbeat}, loop_stall_limit=15.0
    )
    async with robot:
        {deed}
        print(robot._supervisor.guard.pid, flush=True)
        await anyio.sleep_forever()
anyio.run(main)
"""


def guard_of(robot: aioduco.Robot) -> tuple[GuardClient, int]:
    """The guard of a robot, and its process id."""
    guard = robot._supervisor.guard
    assert guard is not None
    assert guard.pid is not None
    return guard, guard.pid


def running(pid: int) -> bool:
    """Whether a process does anything: a zombie does not."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def frozen(pid: int) -> bool:
    """Whether a process was stopped by SIGSTOP."""
    return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "T"


class Started:
    """A program that runs."""

    def __init__(self, process: subprocess.Popen[str], guard: int) -> None:
        self.process = process
        self.guard = guard

    def end(self, number: int) -> None:
        """Send it a signal, and see it end."""
        os.kill(self.process.pid, number)
        self.process.wait(30.0)


@contextmanager
def started(
    host: str, port: int, deed: str = "pass", heartbeat: float | None = 1.0
) -> Iterator[Started]:
    """A program that has a guard and has done its deed; it is killed at the end."""
    code = PROGRAM.format(host=host, port=port, deed=deed, heartbeat=heartbeat)
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as child:
        try:
            assert child.stdout is not None
            yield Started(child, int(child.stdout.readline()))
        finally:
            child.kill()
