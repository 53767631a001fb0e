"""What a function of a section costs over the generated client's call with the same arguments.

    python benchmarks/wrapping.py [--quick] [--save]

Nothing is sent: both go to a lane that answers at once, so that what is left is the checking and
converting of arguments and answers, and the way from the section to the lane. The functions and
their arguments are those of the tests, each argument given. The two take turns, call by call.

    client      the generated client, with arguments as they stand on the wire
    wrapped     the section's function, with arguments as programs have them

Motions are made as values; what becomes of one that is started, and of a task that is followed
to its end, is the work of the supervision and not of the wrapping.
"""

from __future__ import annotations

import asyncio
import importlib
import statistics
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from _common import arguments, percentile, print_table, scheduling, write_results

from aioduco._wire.rpc import AsyncRpc
from aioduco.supervision.command import MotionCommand

if TYPE_CHECKING:
    from collections.abc import Callable

    import aioduco

# the sample call of each function is the tests' own
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
cases: Callable[[], tuple[Any, ...]] = importlib.import_module("api.cases").cases
robot_on: Callable[[Any], aioduco.Robot] = importlib.import_module("api.nowhere").robot_on

#: most microseconds for functions of up to so many arguments
LIMIT_US = 15.0
ARGUMENTS = 8

#: rows of the table of the worst
WORST = 20


async def measure(case: Any, times: int) -> dict[str, Any]:
    """The figures of one function, on a robot of its own: some remember what they were told."""
    answers = {case.name: case.answer, "robotmoving": False} | case.also

    async def answer(name: str, _args: tuple[Any, ...]) -> Any:
        return answers[name]

    client = getattr(AsyncRpc(answer), case.name)
    wrapped: Callable[..., Any] = case.method(robot_on(answer))
    direct, ours = [], []
    clock = time.perf_counter_ns
    for _ in range(times):
        begin = clock()
        await client(*case.wire)
        between = clock()
        made = wrapped(**case.args)
        if not isinstance(made, MotionCommand):
            await made
        end = clock()
        if isinstance(made, MotionCommand):
            made.hand_over()  # or it would warn that it was never started
        direct.append(between - begin)
        ours.append(end - between)
    client_us = percentile(sorted(direct), 50) / 1e3
    wrapped_us = percentile(sorted(ours), 50) / 1e3
    return {
        "function": f"{case.section}.{case.name}",
        "arguments": len(case.wire),
        "client_p50_us": round(client_us, 2),
        "wrapped_p50_us": round(wrapped_us, 2),
        "difference_us": round(wrapped_us - client_us, 2),
        "ratio": round(wrapped_us / client_us, 1),
    }


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """How the differences of several functions lie."""
    differences = sorted(row["difference_us"] for row in rows)
    return {
        "functions": len(rows),
        "median_us": round(statistics.median(differences), 2),
        "p90_us": round(percentile(differences, 90), 2),
        "worst_us": differences[-1],
        f"over {LIMIT_US:g} µs": sum(value > LIMIT_US for value in differences),
    }


async def run(times: int) -> list[dict[str, Any]]:
    """All functions but stop, pause, resume, abort, which are supervision from end to end."""
    return [await measure(case, times) for case in cases() if case.section]


def main() -> None:
    options = arguments(__doc__, "wrapping")
    rows = asyncio.run(run(200 if options.quick else 5000))
    rows.sort(key=lambda row: -row["difference_us"])
    few = [row for row in rows if row["arguments"] <= ARGUMENTS]
    more = [row for row in rows if row["arguments"] > ARGUMENTS]
    groups = {
        f"up to {ARGUMENTS} arguments": summary(few),
        f"more than {ARGUMENTS} arguments": summary(more),
    }
    for title, shown in (("the worst", few[:WORST]), ("with more arguments", more)):
        print_table(title, list(shown[0]), [list(row.values()) for row in shown])
    print_table(
        "wrapping over the generated client",
        ["", *next(iter(groups.values()))],
        [[name, *row.values()] for name, row in groups.items()],
    )
    if options.save:
        results = {"scheduling": scheduling(), "summary": groups, "the worst": few[:WORST]}
        print(f"written: {write_results('wrapping', results)}")


if __name__ == "__main__":
    main()
