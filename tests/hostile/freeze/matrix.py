"""Runs all combinations, or a part of them, several at a time, and prints the results.

The command line is that of `.ci/freeze-matrix`, which states the rule.
"""

from __future__ import annotations

import argparse
import json
import signal
import sys
from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from queue import SimpleQueue

from . import clock
from .arm import Arm
from .cells import GUARDS, HOWS, SCENES, SETS, Cell, cells
from .clock import now
from .judge import BREAKS, ERROR, GOES_ON, HOLDS
from .trial import Patience, Result, Tools, trial

_WORDS = (SCENES, SETS, HOWS, GUARDS)


def trials(runs: Sequence[tuple[Cell, int]], jobs: int, patience: Patience) -> Generator[Result]:
    """Try all of these; the results come in the same order."""
    with ExitStack() as stack:
        tools = Tools(
            plans=any(cell.scene == "plan" for cell, _ in runs),
            suspends=any(cell.how == "suspended" for cell, _ in runs),
        )
        stack.callback(tools.close)
        arms: SimpleQueue[Arm] = SimpleQueue()
        for _ in range(min(jobs, len(runs))):
            arms.put(stack.enter_context(Arm()))

        def one(run: tuple[Cell, int]) -> Result:
            arm = arms.get()
            try:
                return trial(*run, arm, tools, patience)
            finally:
                arms.put(arm)

        pool = stack.enter_context(ThreadPoolExecutor(jobs))
        stack.callback(pool.shutdown, cancel_futures=True)
        # before the pool is waited for: those that run end at once
        stack.callback(tools.ended.set)
        yield from pool.map(one, runs)


def chosen(words: Sequence[str]) -> list[Cell]:
    """The cells that have all of these words; of words for the same dimension, one of them."""
    known = {word for dimension in _WORDS for word in dimension}
    if unknown := [word for word in words if word not in known]:
        raise ValueError(f"{', '.join(unknown)}: none of {', '.join(sorted(known))}")
    wanted = [{word for word in words if word in dimension} for dimension in _WORDS]
    return [
        cell
        for cell in cells()
        if all(not want or word in want for want, word in zip(wanted, cell.words, strict=True))
    ]


def table(results: Sequence[Result]) -> str:
    """How often each verdict was given, by scene, frozen processes, how and guard."""
    rows: dict[Cell, list[Result]] = {}
    for result in results:
        rows.setdefault(result.cell, []).append(result)
    shape = "{:9} {:14} {:10} {:8} {:>5} {:>6} {:>8} {:>7} {:>6} {:>9}  {}"
    heads = ("scene", "frozen", "how", "guard", "runs", "holds", "goes on", "BREAKS", "errors")
    said = [shape.format(*heads, "not told", "largest break")]
    for cell, row in rows.items():
        counts = Counter(result.verdict.kind for result in row)
        untold = sum(not result.told and result.cell.how != "killed" for result in row)
        worst = max((r.verdict.moved for r in row if r.verdict.kind == BREAKS), default=0.0)
        numbers = [counts[kind] or "" for kind in (HOLDS, GOES_ON, BREAKS, ERROR)]
        largest = f"{1e3 * worst:.0f} mrad" if worst else ""
        said.append(shape.format(*cell.words, len(row), *numbers, untold or "", largest))
    return "\n".join(said)


def summary(results: Sequence[Result], seconds: float) -> str:
    """What came of all runs, in a line."""
    counts = Counter(result.verdict.kind for result in results)
    retries = [why for result in results for why in result.retries]
    late = sum("late" in why or "frozen for" in why for why in retries)
    return (
        f"{len(results)} runs in {seconds:.0f} s: {counts[HOLDS]} hold, {counts[GOES_ON]} go on by "
        f"design, {counts[BREAKS]} BREAKS, {counts[ERROR]} errors; {len(retries)} attempts were "
        f"repeated, {late} of them since the simulator or this script was late"
    )


def _json(result: Result) -> dict[str, object]:
    cell, verdict = result.cell, result.verdict
    return {
        **dict(zip(("scene", "frozen", "how", "guard"), cell.words, strict=True)),
        "seed": result.seed,
        "verdict": verdict.kind,
        "text": verdict.text,
        "stood": verdict.stood,
        "moved": verdict.moved,
        "told": result.told,
        "retries": result.retries,
        "seconds": round(result.seconds, 2),
        "said": [tuple(line) for line in result.said],
    }


def _seeds(text: str) -> list[int]:
    found: list[int] = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        found += range(int(first), int(last or first) + 1)
    return found


@contextmanager
def _ends_by_signals() -> Iterator[None]:
    def end(number: int, _frame: object) -> None:
        raise SystemExit(128 + number)

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def main(description: str) -> int:
    """Try what the command line says; the exit status."""
    parser = argparse.ArgumentParser(
        prog="freeze-matrix",
        description=description,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", default="", metavar="WORDS", help="such as servo,speed,all,3")
    parser.add_argument("--seeds", default="1-2", metavar="SEEDS", help="such as 1,4-6 (1-2)")
    parser.add_argument("--jobs", type=int, default=6, help="runs at a time (%(default)s)")
    parser.add_argument("--json", metavar="FILE", help="where all results are written")
    parser.add_argument("--list", action="store_true", help="name the runs, and end")
    given = parser.parse_args()
    try:
        found, seeds = chosen(list(filter(None, given.only.split(",")))), _seeds(given.seeds)
    except ValueError as exc:
        parser.error(str(exc))
    runs = [(cell, seed) for cell in found for seed in seeds]
    if given.list:
        _print("\n".join(f"{cell}, seed {seed}" for cell, seed in runs))
        return 0
    if any(cell.how == "suspended" for cell in found) and (reason := clock.why_not()):
        _print(f"no computer can be suspended: {reason}")
        return 2
    begin, results = now(), []
    try:
        with _ends_by_signals(), closing(trials(runs, given.jobs, Patience())) as came:
            for result in came:
                results.append(result)
                _print(result)
    except KeyboardInterrupt:
        return 130
    finally:
        if given.json:
            text = json.dumps([_json(result) for result in results], indent=1)
            Path(given.json).write_text(text, encoding="utf-8")
    _print(f"\n{table(results)}\n\n{summary(results, now() - begin)}")
    return 1 if not results or {r.verdict.kind for r in results} & {BREAKS, ERROR} else 0


def _print(text: object) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()
