"""What the cases of the benchmark of streams share: set-points, workers, load, noise."""

from __future__ import annotations

import contextlib
import json
import math
import os
import time
from typing import TYPE_CHECKING, Any

import anyio
import numpy as np
from _common import CORES, HERE, spread
from _processes import Program

from aioduco.streaming.shared.options import WorkerOptions

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator, Sequence

    from aioduco.streaming.report import StreamStatistics

RATE = 1000
BURST = 0.015
WORKERS = {
    "process": WorkerOptions(run_in="process"),
    "without priority": WorkerOptions(run_in="process", priority=0),
    "urgent": WorkerOptions(run_in="process", priority=50),
    "thread": WorkerOptions(run_in="thread", timeout=2.0),
}
SERVOJ = (1.0, 5.0, False, 200.0, 25.0, 10.0, 1.0)


def sine(count: int, rate: float, start: Sequence[float] = (0.0,) * 6) -> list[list[float]]:
    """Set-points of a slow sine on all joints, from rest."""
    turn = 2 * math.pi * 0.2 / rate
    ways = (0.1 * (1 - math.cos(turn * n)) for n in range(count))
    return [[angle + way for angle in start] for way in ways]


def work_for(seconds: float) -> None:
    """Python's own work, which gives its lock away no more often than it must."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        sum(range(200))


@contextlib.asynccontextmanager
async def load(busy: bool) -> AsyncIterator[None]:
    """The program's other work: bursts of plain Python in the event loop, or none."""

    async def work() -> None:
        while True:
            work_for(BURST)
            await anyio.sleep(BURST)

    async with anyio.create_task_group() as tasks:
        if busy:
            tasks.start_soon(work)
        yield
        tasks.cancel_scope.cancel()


def urgent_allowed() -> bool:
    """Whether the system allows SCHED_FIFO."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except OSError:
        return False
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    return True


class Lateness:
    """How late one alternative was in all of its slices."""

    def __init__(self) -> None:
        self.seconds = np.zeros(0)
        self.ticks = self.missed = 0

    def add(self, buckets: Sequence[Sequence[int]], ticks: int, missed: int) -> None:
        """Add a slice, by its histogram."""
        low, high, count = np.reshape(np.array(buckets, int), (-1, 3)).T
        self.seconds = np.append(self.seconds, np.repeat((low + high) // 2 * 1e-9, count))
        self.ticks += ticks
        self.missed += missed

    def add_stream(self, found: StreamStatistics) -> None:
        """Add a slice of a stream."""
        self.add(found.buckets["lateness"], found.ticks, found.missed)

    def figures(self) -> dict[str, Any]:
        late = {f"late_{name}": value for name, value in spread(self.seconds).items()}
        beyond = int(np.count_nonzero(self.seconds > 0.002))
        return {"ticks": self.ticks, "missed": self.missed, **late, "beyond_2ms": beyond}


@contextlib.contextmanager
def bare_loop(found: Lateness, rate: float, core: int | None) -> Iterator[None]:
    """A loop that only sleeps to its ticks: what the machine does to anybody's schedule.

    In a process of its own on one processor, or any for None, while the block runs.
    """
    with Program(str(HERE / "ticks.py"), str(rate)) as program:
        if core is not None:
            os.sched_setaffinity(program.process.pid, {core})
        program.line()  # what its start takes is over
        yield
        found.add(*json.loads(program.end()))


@contextlib.contextmanager
def bare_loops(found: Lateness) -> Iterator[None]:
    """One on each processor: the machine's own noise, beside what is measured.

    The worker may run on any of them, so the worst of them is what it is held against.
    """
    with contextlib.ExitStack() as stack:
        for core in CORES:
            stack.enter_context(bare_loop(found, RATE, core))
        yield
