"""Runs all combinations, or a part of them, several at a time, and prints the results.

python -m hostile.cable.matrix [--kind dropped] [--scene sent] [--outage 3.2] ...
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import anyio

from .network import why_not
from .trial import KINDS, OUTAGES, SCENES, Cell, Result, cells, trial


async def trials(
    chosen: Sequence[Cell], jobs: int, report: Callable[[Result], object] = lambda _: None
) -> list[Result]:
    """Try all of these."""
    results: list[Result] = []
    limit = anyio.Semaphore(jobs)

    async def one(cell: Cell) -> None:
        async with limit:
            result = await trial(cell)
        results.append(result)
        report(result)

    async with anyio.create_task_group() as group:
        for cell in chosen:
            group.start_soon(one, cell)
    return results


def table(results: Iterable[Result]) -> str:
    """How often the arm began to move, by kind, scene, heartbeat and guard."""
    rows: dict[tuple[str, str, str, str], list[Result]] = {}
    for result in results:
        cell = result.cell
        beat = "none" if cell.heartbeat is None else f"{cell.heartbeat:g} s"
        key = (cell.kind, cell.scene, beat, "guard" if cell.guard else "none")
        rows.setdefault(key, []).append(result)
    shape = "{:8} {:8} {:9} {:6} {:>5} {:>17} {:>8} {:>13}  {}"
    heads = ("kind", "scene", "heartbeat", "guard", "runs", "begun after told", "trouble")
    said = [shape.format(*heads, "slowest told", "told")]
    for key, row in rows.items():
        slowest = max(result.told - result.begin for result in row)
        told = Counter(result.what.partition(":")[0] for result in row)
        whats = ", ".join(f"{count} {what}" for what, count in told.most_common())
        counts = (len(row), sum(bool(r.begun) for r in row), sum(bool(r.trouble) for r in row))
        said.append(shape.format(*key, *counts, f"{slowest:.1f} s", whats))
    return "\n".join(said)


def main() -> int:
    """Try what the command line says; the exit status."""
    parser = argparse.ArgumentParser(prog="cables", description=__doc__.partition("\n")[0])
    parser.add_argument("--kind", action="append", choices=KINDS)
    parser.add_argument("--scene", action="append", choices=SCENES)
    parser.add_argument("--outage", action="append", type=float, metavar="SECONDS")
    parser.add_argument("--heartbeat", action="append", metavar="SECONDS|none")
    parser.add_argument("--guard", action="append", choices=("guard", "none"))
    parser.add_argument("--jobs", type=int, default=10, help="runs at a time (%(default)s)")
    parser.add_argument("--repeat", type=int, default=1, help="times that each is tried")
    parser.add_argument("--list", action="store_true", help="name the runs, and end")
    given = parser.parse_args()
    if unknown := set(given.outage or ()) - set(OUTAGES):
        parser.error(f"outages of {unknown} s are none of {OUTAGES}")
    beats = given.heartbeat and [
        None if text == "none" else float(text) for text in given.heartbeat
    ]
    chosen = [
        cell
        for cell in cells()
        if (not given.kind or cell.kind in given.kind)
        and (not given.scene or cell.scene in given.scene)
        and (not given.outage or cell.outage in given.outage)
        and (not beats or cell.heartbeat in beats)
        and (not given.guard or ("guard" if cell.guard else "none") in given.guard)
    ]
    chosen = list(itertools.chain.from_iterable([chosen] * given.repeat))
    if given.list:
        _print("\n".join(map(str, chosen)))
        return 0
    if reason := why_not():
        _print(f"no network namespaces: {reason}")
        return 2
    began = time.monotonic()
    results = anyio.run(trials, chosen, given.jobs, _print)
    failed = sum(not result.passed for result in results)
    _print(f"\n{table(results)}\n")
    outages = sorted({cell.outage for cell in chosen})
    _print(f"outages of {', '.join(f'{outage:g}' for outage in outages)} s")
    _print(f"the runs took {time.monotonic() - began:.0f} s")
    _print(f"{len(results) - failed} passed, {failed} failed")
    return 1 if failed or not results else 0


def _print(text: object) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
