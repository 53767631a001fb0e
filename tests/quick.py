"""The quick run: every kind of test, with a few cases.

A test that takes more than a twentieth of a second of a processor, or waits for more than a second,
is left to the thorough run by `pytest.mark.slow`, if a quicker one tests what is like it. Of the
others, what a case costs decides how many are taken. A test says so itself by
`pytest.mark.cases(n)`; otherwise the table below does, by the longest beginning of its file's path.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterable, Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any, TypeVar

import pytest
from hypothesis import settings

T = TypeVar("T")

#: cases of a test, by the beginning of its path: few where programs are started, where simulators
#: run or where something is waited for
CASES = {
    "": 2,
    "adversity/": 1,
    "api/": 1,
    "client/": 1,
    "client/test_examples": 2,
    "descriptions/": 1,
    "envelope/": 1,
    "hostile/": 1,
    "sim/": 1,
    "sim/test_message": 8,
    "streaming/": 1,
    "supervision/": 1,
    "sync/": 1,
    "test_cli": 1,
}
#: how long the tests of a file take for its size, which more or less says what they compute: more
#: where an arm, an answer or a time-out is waited for
WAITS = {
    "": 1,
    "adversity/": 2,
    "api/": 6,
    "client/": 3,
    "devices/grippers/": 4,
    "explore/": 15,
    "hostile/": 3,
    "planning/": 2,
    "programs/": 3,
    "shipped/": 16,
    "sim/": 2,
    "sim/planner/": 1,
    "streaming/": 2,
    "supervision/": 5,
    "sync/": 4,
    "wire/": 2,
}
#: beginnings of the paths of tests that take long, mostly since they start programs
LONG = (
    *("client/test_examples", "devices/grippers/test_simulated", "hostile/test_cable"),
    *("hostile/test_fork", "hostile/test_frozen", "hostile/test_imports", "integrations/fleet/"),
    *("integrations/panel/", "pages/", "planning/", "recording/playback/"),
    *("streaming/test_examples", "test_cli", "testing/preflight/"),
)
#: of the examples of a property, at least so many are tried
LEAST_EXAMPLES = 5


def divided(items: Iterable[pytest.Item]) -> tuple[list[pytest.Item], list[pytest.Item]]:
    """The items of the quick run, and those that are left to the thorough one, in order."""
    families: dict[str, list[pytest.Item]] = {}
    for item in items:
        families.setdefault(item.nodeid.partition("[")[0], []).append(item)
    chosen = {
        item.nodeid for family in families.values() for item in spread(family, _cases_of(family[0]))
    }
    kept: list[pytest.Item] = []
    left: list[pytest.Item] = []
    for item in items:
        (kept if item.nodeid in chosen else left).append(item)
    return kept, left


def slow_first(items: Iterable[pytest.Item], processes: int = 1) -> list[pytest.Item]:
    """The same items, ordered so that each process begins with tests that take long.

    A long test that begins last keeps one process busy while the others are idle. Neighbours stay
    together, since they share fixtures.

    Args:
        items: of a run.
        processes: how many run them. Each is given an equal part of the list, in order.
    """
    order: list[pytest.Item] = []
    quick: list[pytest.Item] = []
    slow: list[pytest.Item] = []
    for item in items:
        (quick if _is_quick(item) else slow).append(item)
    number, taken = len(quick) + len(slow), 0
    for process in range(processes):
        part = (number - len(order)) // (processes - process)
        long = slow[len(slow) * process // processes : len(slow) * (process + 1) // processes]
        after = taken + max(part - len(long), 0)
        order += [*long, *quick[taken:after]]
        taken = after
    return [*order, *quick[taken:]]


def _is_quick(item: pytest.Item) -> bool:
    path = item.nodeid.removeprefix("tests/")
    return item.get_closest_marker("slow") is None and not path.startswith(LONG)


def spread_cases(metafunc: pytest.Metafunc) -> None:
    """Let each table of cases of a test give no more cases than the quick run takes of the test."""
    # A table without a case would be a test that is skipped.
    limit = max(_cases_of(metafunc.definition), 1)
    parametrize = metafunc.parametrize

    def spread_out(
        names: str | Sequence[str], values: Iterable[Any], *rest: Any, **options: Any
    ) -> None:
        # By this pytest keeps the ids that the first test made of a mark which several tests share;
        # another test may take more of its cases.
        options.pop("_param_mark", None)
        ids = options.get("ids")
        if ids is not None and not callable(ids):
            options["ids"] = spread(list(ids), limit)
        parametrize(names, spread(list(values), limit), *rest, **options)

    # of this one test, before pytest makes its cases of it
    vars(metafunc)["parametrize"] = spread_out


def spread(cases: Sequence[T], number: int) -> list[T]:
    """So many of the cases, evenly: the first, the last and some between, always the same."""
    if len(cases) <= number:
        return list(cases)
    if number < 2:
        return list(cases[:number])
    return [cases[round(n * (len(cases) - 1) / (number - 1))] for n in range(number)]


def part(times: Mapping[Path, int], process: int, processes: int) -> list[Path]:
    """What one of several processes takes of some files: each is taken once, in order.

    The files of a folder import the same: they stay together, unless a process alone would take too
    long with them. What takes longest of what is left goes to the process with the least until now.

    Args:
        times: how long each file takes, by any measure.
        process: its number; one that takes the place of another has a higher one than all.
        processes: how many there are.
    """
    folders: dict[Path, list[Path]] = {}
    for file in times:
        folders.setdefault(file.parent, []).append(file)
    most = sum(times.values()) / processes
    together: list[tuple[int, list[Path]]] = []
    for files in folders.values():
        time = sum(map(times.__getitem__, files))
        together += [(time, files)] if time <= most else [(times[file], [file]) for file in files]
    taken: list[set[Path]] = [set() for _ in range(processes)]
    load = [0] * processes
    for time, files in sorted(together, key=itemgetter(0), reverse=True):
        least = load.index(min(load))
        taken[least].update(files)
        load[least] += time
    return [file for file in times if file in taken[process % processes]]


def share(text: str) -> tuple[int, int]:
    """Read `3/8`, the third of eight shares of the cases."""
    number, shares = (int(part) for part in text.split("/"))
    if not 1 <= number <= shares:
        raise ValueError(text)
    return number, shares


def in_share(nodeid: str, number: int, shares: int) -> bool:
    """Whether a case is in this share, from 1, of all cases: each is in one, always the same."""
    return zlib.crc32(nodeid.encode()) % shares == number - 1


def _cases_of(item: pytest.Item) -> int:
    if item.get_closest_marker("slow") is not None:
        return 0
    marker = item.get_closest_marker("cases")
    if marker is not None:
        return int(marker.args[0])
    return _of_path(CASES, item.nodeid.partition("::")[0].removeprefix("tests/"))


def wait(path: str) -> int:
    """How long the tests of a file take for its size, from `WAITS`."""
    return _of_path(WAITS, path)


def _of_path(table: Mapping[str, int], path: str) -> int:
    return table[max((begin for begin in table if path.startswith(begin)), key=len)]


def examples(number: int) -> int:
    """How many examples a property is tried with, of those that the thorough run takes."""
    return max(min(number, LEAST_EXAMPLES), number * settings().max_examples // 100)


def processors() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
