"""Ticks at a rate, and how late each of them is; as a program, a loop that only sleeps to them.

    python ticks.py RATE

It says by a line that it begins, and ends when its standard input does, with its figures as JSON.
"""

from __future__ import annotations

import json
import select
import sys
import threading
import time

from aioduco.streaming.shared.histogram import Histogram
from aioduco.streaming.worker.clock import Schedule, sharpen_sleep, sleep_until


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

    def begin(self) -> None:
        """The present tick begins."""
        self._histogram.record(time.monotonic_ns() - self.due)

    def end(self) -> None:
        """Its work has ended; those that are over by now are missed."""
        self.ticks += 1
        due, now = self.due, time.monotonic_ns()
        for number in range(self._schedule.advance(now)):
            self._histogram.record(now - due - (number + 1) * self._period)

    def figures(self) -> tuple[list[tuple[int, int, int]], int, int]:
        """The histogram of how late they were, and how many there were, and were missed."""
        return self._histogram.buckets(), self.ticks, self._schedule.missed


def main() -> None:
    """Sleep to each tick, and do nothing else, until the standard input ends."""
    sharpen_sleep(threading.get_native_id())
    print("begins", flush=True)
    ticks = Ticks(float(sys.argv[1]))
    while ticks.ticks % 64 or not select.select([sys.stdin], [], [], 0)[0]:
        sleep_until(ticks.due)
        ticks.begin()
        ticks.end()
    print(json.dumps(ticks.figures()))


if __name__ == "__main__":
    main()
