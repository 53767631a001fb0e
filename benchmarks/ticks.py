"""A loop that only sleeps to its ticks: what the machine does to anybody's schedule.

    python ticks.py RATE

It says by a line that it begins, and ends when its standard input does. Then it says as JSON how
late each tick was [ns], and how many there were, and were missed.
"""

from __future__ import annotations

import json
import select
import sys
import threading
import time

from aioduco.streaming.worker.clock import Schedule, sharpen_sleep, sleep_until


def main() -> None:
    sharpen_sleep(threading.get_native_id())
    print("begins", flush=True)
    period = round(1e9 / float(sys.argv[1]))
    schedule = Schedule(period, time.monotonic_ns() + period)
    late: list[int] = []
    ticks = 0
    while ticks % 64 or not select.select([sys.stdin], [], [], 0)[0]:
        due = schedule.due
        late.append(sleep_until(due) - due)
        now = time.monotonic_ns()
        late += [now - due - place * period for place in range(1, schedule.advance(now) + 1)]
        ticks += 1
    print(json.dumps([late, ticks, schedule.missed]))


if __name__ == "__main__":
    main()
