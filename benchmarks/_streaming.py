"""What the cases of the benchmark of streams share: set-points, workers, load, noise."""

from __future__ import annotations

import contextlib
import json
import math
import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio

from aioduco._wire.connection import Connection
from aioduco.streaming.shared.histogram import Histogram
from aioduco.streaming.shared.options import WorkerOptions

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator
    from types import TracebackType

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


def sine(count: int, rate: float) -> list[list[float]]:
    """Set-points of a slow sine on all joints, from rest."""
    turn = 2 * math.pi * 0.2 / rate
    return [[0.1 * (1 - math.cos(turn * n))] * 6 for n in range(count)]


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


class Lateness:
    """How late one alternative was in all of its slices."""

    def __init__(self) -> None:
        self.buckets: dict[int, int] = {}
        self.ticks = self.missed = 0

    def add(self, lateness: list[tuple[int, int, int]], ticks: int, missed: int) -> None:
        for low, high, count in lateness:
            self.buckets[(low + high) // 2] = self.buckets.get((low + high) // 2, 0) + count
        self.ticks += ticks
        self.missed += missed

    def percentile(self, fraction: float) -> float:
        """In seconds."""
        left = fraction * sum(self.buckets.values())
        for value in sorted(self.buckets):
            left -= self.buckets[value]
            if left <= 0:
                return value * 1e-9
        return 0.0

    def beyond(self, limit: float) -> int:
        return sum(count for value, count in self.buckets.items() if value > limit * 1e9)

    def figures(self) -> dict[str, Any]:
        return {
            "ticks": self.ticks,
            "missed": self.missed,
            "late_p50_us": round(self.percentile(0.5) * 1e6, 1),
            "late_p99_us": round(self.percentile(0.99) * 1e6, 1),
            "late_p99.9_us": round(self.percentile(0.999) * 1e6, 1),
            "late_max_us": round(max(self.buckets, default=0) * 1e-3, 1),
            "beyond_2ms": self.beyond(0.002),
        }


#: a loop that only sleeps to each tick: what the machine does to anybody's schedule
C = r"""
#include <stdio.h>
#include <stdint.h>
#include <stdlib.h>
#include <poll.h>
#include <sys/prctl.h>
#include <time.h>

static int64_t now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

int main(int argc, char **argv) {
    int64_t period = atoll(argv[1]), due = now() + period, missed = 0;
    struct pollfd in = {0, POLLIN, 0};
    prctl(PR_SET_TIMERSLACK, 1);
    printf("[");
    for (int64_t tick = 0;; tick++) {
        struct timespec t = {due / 1000000000LL, due % 1000000000LL};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
        int64_t late = now() - due;
        printf("%lld,", (long long)late);
        for (due += period; now() - due >= period; due += period, missed++)
            printf("%lld,", (long long)(now() - due));
        if (tick % 64 == 0 && poll(&in, 1, 0) > 0) break;
    }
    printf("%lld]\n", (long long)missed);
    return 0;
}
"""


class BareLoop:
    """The loop, in a process of its own on one processor, or any for None, while the block runs."""

    def __init__(self, rate: float, core: int | None) -> None:
        self._core = core
        self._period = round(1e9 / rate)
        self._late: list[int] = []
        self.missed = 0

    def __enter__(self) -> BareLoop:
        self._folder = tempfile.TemporaryDirectory()
        self._output = (Path(self._folder.name) / "late").open("w+")
        self._process = subprocess.Popen(
            [self._command(), str(self._period)], stdin=subprocess.PIPE, stdout=self._output
        )
        if self._core is not None:
            os.sched_setaffinity(self._process.pid, {self._core})
        return self

    def _command(self) -> str:
        source, program = Path(self._folder.name) / "bare.c", Path(self._folder.name) / "bare"
        source.write_text(C)
        subprocess.run(["cc", "-O2", "-o", str(program), str(source)], check=True)
        return str(program)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.communicate(timeout=10)
        self._output.seek(0)
        *self._late, self.missed = json.load(self._output)
        self._output.close()
        self._folder.cleanup()

    @property
    def ticks(self) -> int:
        return len(self._late) - self.missed

    def buckets(self) -> list[tuple[int, int, int]]:
        """Lateness as histograms give it [ns]."""
        histogram = Histogram()
        for late in self._late:
            histogram.record(late)
        found: Any = histogram.buckets()
        return list(found)


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
            self.lateness.add(bare.buckets(), bare.ticks, bare.missed)
