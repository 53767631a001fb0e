"""Sweeps: how much faster two local workers try variations of the demo than one does.

    python benchmarks/sweep.py [--runs 200] [--quick] [--save]

`aioduco preflight --runs N --vary start,latency,faults,payload -m aioduco.cli -- demo --no-plot`,
on a local cluster of one worker and of two. Asked for: at least 1.7 times as fast with 200 runs, on
a machine with nothing else to do. "cores" is the processor time of all processes over the wall:
where one worker uses more than one core, as its program, simulator and client are threads beside
each other, two workers on two cores cannot be twice as fast. "start" is from the beginning to the
first result. If the processor time of a run is the same for both, the cores alone limit them.
"""

from __future__ import annotations

import resource
import time
from typing import Any

from _common import parser, print_table, write_results

from aioduco.testing.preflight import PreflightSettings
from aioduco.testing.preflight.sweep import sweep

VARY = ("start", "latency", "faults", "payload")


def spent() -> float:
    """Processor time of this process and of those of its children that have ended [s]."""
    uses = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(use.ru_utime + use.ru_stime for use in uses)


def swept(runs: int, workers: int) -> dict[str, float]:
    """The figures of one sweep."""
    settings = PreflightSettings(module=True, vary=VARY, timeout=300.0)
    begin, before = time.perf_counter(), spent()
    first: list[float] = []

    def done(_: Any) -> None:
        if not first:
            first.append(time.perf_counter() - begin)

    report = sweep("aioduco.cli", ["demo", "--no-plot"], settings, runs, workers=workers, done=done)
    wall, processor = time.perf_counter() - begin, spent() - before
    not_run = [one.error for one in report.results if one.error]
    assert not not_run, not_run[0]
    return {
        "wall_s": round(wall, 1),
        "start_s": round(first[0], 1),
        "processor time of a run_s": round(processor / runs, 2),
        "cores": round(processor / wall, 2),
    }


def main() -> None:
    made = parser(__doc__, "sweep")
    made.add_argument("--runs", type=int, default=200, help="variations (default: %(default)s)")
    options = made.parse_args()
    runs = 6 if options.quick else options.runs
    table = {f"{workers} of a local cluster": swept(runs, workers) for workers in (1, 2)}
    one, two = table.values()
    ratio = round(one["wall_s"] / two["wall_s"], 2)
    print_table(
        f"{runs} variations of the demo",
        ["workers", "wall [s]", "until the first [s]", "processor time of a run [s]", "cores"],
        [[name, *row.values()] for name, row in table.items()],
    )
    print(f"two workers are {ratio} times as fast as one")
    if options.save:
        results = {"runs": runs, "times as fast with two workers": ratio, "workers": table}
        print(f"written: {write_results('sweep', results)}")


if __name__ == "__main__":
    main()
