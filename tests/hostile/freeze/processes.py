"""The processes of one run: found by a mark in their environment, frozen, thawed and killed."""

from __future__ import annotations

import os
import select
import signal
import time
from collections.abc import Sequence
from pathlib import Path

#: variable of the environment that each process of a run inherits
MARK = "FREEZE_RUN"
#: by what is in their command lines
_ROLES = {b"aioduco.supervision.guard.process": "guard", b"aioduco.streaming.worker.main": "worker"}
#: until all threads of a process have stopped [s]
_STOPPED = 5.0


def of_run(mark: str) -> list[int]:
    """Ids of the processes with this mark; a zombie has none any more."""
    found = []
    wanted = f"{MARK}={mark}".encode()
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            marked = wanted in (entry / "environ").read_bytes().split(b"\0")
        except OSError:
            continue  # it has ended, or is another user's
        if marked:
            found.append(int(entry.name))
    return sorted(found)


def roles_of(mark: str, program: int) -> dict[int, str]:
    """The role of each process of a run: "program", "worker", "guard" or "other"."""
    return {pid: "program" if pid == program else _role(pid) for pid in of_run(mark)}


def freeze(pids: Sequence[int]) -> None:
    """Stop processes, in this order, and wait until none of their threads runs.

    A thread in an uninterruptible wait ("D") executes nothing before it stops: one that starts a
    program waits so until its child is that program, which a child that was stopped first never is.
    """
    for pid in pids:
        _signal(pid, signal.SIGSTOP)
    until = time.monotonic() + _STOPPED
    while any(states_of(pid) - {"T", "D", "Z", "X"} for pid in pids):
        if time.monotonic() > until:
            raise TimeoutError(f"processes {pids} did not stop")
        # A poll: the system tells nobody that a process that is no child stopped.
        time.sleep(0.0005)


def thaw(pids: Sequence[int]) -> None:
    """Let processes go on, in this order."""
    for pid in pids:
        _signal(pid, signal.SIGCONT)


def kill(mark: str) -> None:
    """Kill all that is left of a run, and what it starts meanwhile."""
    while left := of_run(mark):
        for pid in left:
            try:
                process = os.pidfd_open(pid)
            except ProcessLookupError:
                continue  # it has ended meanwhile
            try:
                signal.pidfd_send_signal(process, signal.SIGKILL)
                select.select([process], [], [])  # readable once it has ended
            except ProcessLookupError:
                continue
            finally:
                os.close(process)


def _signal(pid: int, number: int) -> None:
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        return  # it has ended meanwhile


def _role(pid: int) -> str:
    try:
        line = Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return "other"
    return next((role for name, role in _ROLES.items() if name in line), "other")


def states_of(pid: int) -> set[str]:
    """States of the threads of a process; none if it has ended."""
    states = set()
    for stat in Path(f"/proc/{pid}/task").glob("*/stat"):
        try:
            states.add(stat.read_text().rpartition(")")[2].split()[0])
        except OSError:
            continue
    return states
