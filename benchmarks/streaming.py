"""Streams: what rate they reach, how late they are, and what becomes of the arm.

    python benchmarks/streaming.py [--quick] [--save]

All alternatives stream to the same server process and take turns in slices, so that whatever
else the machine does meets them all.

    process     a worker in a process of its own, the default
    without priority  the same, but that it never goes first, as `process` does once it wakes late
    urgent      the same under SCHED_FIFO from the start, where the system allows it
    thread      the same worker in a thread of the program
    loop        no worker: a task of the program sleeps to each tick and awaits the call
    bare        no stream at all: a loop in C (in Python without a compiler) on each processor
                that only sleeps to each tick, beside `process`, for the machine's own noise
    busy        the program's event loop works in bursts of 15 ms, with pauses of 15 ms

A stream whose set-points are further apart than 20 ms lets a controller trip. The last cases are
against the simulated arm, in a process of its own, with the program's loop busy.

The table at the end says what is asked for, what was found, and whether that is enough.
"""

from __future__ import annotations

import os
from typing import Any

import anyio
from _common import ServerProcess, arguments, print_table, write_results
from streaming_arm import killed, memory, upsampling
from streaming_judge import judged
from streaming_pace import greatest_rate, pacing
from streaming_queue import starvation
from streaming_simulator import simulated


def show(results: dict[str, Any]) -> None:
    print_table(
        "greatest servoj rate, closed loop",
        ("", "calls/s", "/ thriftpy2", "/ Apache"),
        [(name, *row.values()) for name, row in results["greatest_rate"].items()],
    )
    for title in ("idle", "busy"):
        figures = results["pacing"][title]
        columns = (
            "",
            "p50",
            "p99",
            "p99.9",
            "max",
            "> 2 ms",
            "missed",
            "starved",
            "gap ms",
            "trips",
        )
        keys = ("late_p50_us", "late_p99_us", "late_p99.9_us", "late_max_us", "beyond_2ms")
        rows = [
            (name, *(row[key] for key in (*keys, "missed", "starved", "longest_gap_ms", "trips")))
            for name, row in figures.items()
        ]
        print_table(f"servoj at 1 kHz, the program's loop {title}: lateness in µs", columns, rows)
    for title, figures in results["realtime_queue"].items():
        accounts = ("points", "starved_cycles", "longest_ms")
        rows = [(name, *(row.get(key, "") for key in accounts)) for name, row in figures.items()]
        heads = ("", "points", "starved cycles", "longest ms")
        print_table(f"realtime queue at 1 kHz, {title}", heads, rows)
    print_table(
        "30 Hz targets at 500 Hz",
        ("", "velocity", "acceleration", "jerk", "limit", "acceleration / bare steps"),
        [(way, *row.values()) for way, row in results["upsampling"].items()],
    )
    for name, row in results["simulator"].items():
        print_table(f"simulated arm: {name}", ("", ""), list(row.items()))
    print_table("the program killed at 0.4 rad/s", ("", ""), list(results["killed"].items()))
    print_table("memory of a worker's process", ("", "MB"), list(results["memory"].items()))
    rows = [
        (name, row["asked"], row["found"], "yes" if row["reached"] else "NO")
        for name, row in results["asked_for"].items()
    ]
    print_table("asked for", ("", "asked", "found", "reached"), rows)


async def measure(port: int, quick: bool) -> dict[str, Any]:
    results: dict[str, Any] = {"greatest_rate": await greatest_rate(port, quick)}
    # The rest needs no server on a core of its own: a paced worker leaves the machine idle.
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    results["pacing"] = {
        "idle": await pacing(port, False, quick),
        "busy": await pacing(port, True, quick),
    }
    results["realtime_queue"] = {
        "busy loop": await starvation(port, True, False, quick),
        "busy loop, one stall of 300 ms": await starvation(port, True, True, quick),
    }
    results["upsampling"] = await upsampling(port)
    results["killed"] = killed(port)
    results["memory"] = await memory(port)
    results["simulator"] = await simulated(quick)
    # The verdicts come first on the page.
    return {"asked_for": judged(results)} | results


def main() -> None:
    options = arguments(__doc__, "streaming")
    with ServerProcess("streaming_server.py") as server:
        results = anyio.run(measure, server.endpoints["thrift"], options.quick)
    show(results)
    if options.save:
        path = write_results("streaming", results)
        print(f"written to {path.relative_to(path.parents[2])}")


if __name__ == "__main__":
    main()
