"""What the cases of the benchmark of streams share: set-points, workers, load, noise."""

from __future__ import annotations

import contextlib
import json
import math
import os
import select
import sys
import threading
import time
from typing import TYPE_CHECKING, Any

import anyio
import numpy as np
from _common import Program, spread

from aioduco._wire.connection import Connection
from aioduco.streaming.shared.histogram import Histogram
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.worker.clock import Schedule, sharpen_sleep, sleep_until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator, Sequence
    from typing import Self

HOST = "127.0.0.1"
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


def ask(port: int, account: str) -> list[float]:
    """What the server has kept account of, since it was last asked."""
    connection = Connection(HOST, port)
    connection.open()
    try:
        found: list[float] = connection.call("get_system_value_list", (account,), 20.0)
    finally:
        connection.close()
    return found


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


class Ticks:
    """An absolute schedule, and how late each of its ticks was.

    Args:
        rate: ticks a second.
    """

    def __init__(self, rate: float) -> None:
        self._period = round(1e9 / rate)
        self._schedule = Schedule(self._period, time.monotonic_ns() + self._period)
        self._histogram = Histogram()
        self.ticks = 0

    @property
    def due(self) -> int:
        """When the present tick is due [ns]."""
        return self._schedule.due

    @property
    def missed(self) -> int:
        return self._schedule.missed

    def begin(self) -> None:
        """The present tick begins."""
        self._histogram.record(time.monotonic_ns() - self.due)

    def end(self) -> None:
        """Its work has ended; those that are over by now are missed."""
        self.ticks += 1
        due, now = self.due, time.monotonic_ns()
        for number in range(self._schedule.advance(now)):
            self._histogram.record(now - due - (number + 1) * self._period)

    def buckets(self) -> list[tuple[int, int, int]]:
        return self._histogram.buckets()


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

    def figures(self) -> dict[str, Any]:
        late = {f"late_{name}": value for name, value in spread(self.seconds).items()}
        beyond = int(np.count_nonzero(self.seconds > 0.002))
        return {"ticks": self.ticks, "missed": self.missed, **late, "beyond_2ms": beyond}


class BareLoop:
    """A loop that only sleeps to its ticks: what the machine does to anybody's schedule.

    In a process of its own on one processor, or any for None, while the block runs.
    """

    def __init__(self, rate: float, core: int | None) -> None:
        self._rate, self._core = rate, core
        self.buckets: list[list[int]] = []
        self.ticks = self.missed = 0

    def __enter__(self) -> Self:
        self._program = Program(__file__, str(self._rate))
        if self._core is not None:
            os.sched_setaffinity(self._program.process.pid, {self._core})
        self._program.line()  # what its start takes is over
        return self

    def __exit__(self, *_: object) -> None:
        self.buckets, self.ticks, self.missed = json.loads(self._program.end())


class Noise:
    """A bare loop on each processor, beside what is measured: the machine's own noise.

    The worker may run on any of them, so the worst of them is what it is held against.
    """

    def __init__(self) -> None:
        self.lateness = Lateness()

    @contextlib.contextmanager
    def beside(self) -> Iterator[None]:
        """Run them while the block runs, and add what they found."""
        with contextlib.ExitStack() as stack:
            cores = sorted(os.sched_getaffinity(0))
            loops = [stack.enter_context(BareLoop(RATE, core)) for core in cores]
            yield
        for bare in loops:
            self.lateness.add(bare.buckets, bare.ticks, bare.missed)


def main() -> None:
    """Sleep to each tick, and do nothing else, until the standard input ends."""
    sharpen_sleep(threading.get_native_id())
    print("begins", flush=True)
    ticks = Ticks(float(sys.argv[1]))
    while ticks.ticks % 64 or not select.select([sys.stdin], [], [], 0)[0]:
        sleep_until(ticks.due)
        ticks.begin()
        ticks.end()
    print(json.dumps([ticks.buckets(), ticks.ticks, ticks.missed]))


if __name__ == "__main__":
    main()
