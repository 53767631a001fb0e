"""What the quick run takes of the tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from quick import CASES, divided, in_share, part, slow_first, spread, spread_cases


def items(
    name: str, count: int, limit: int | None = None, *, slow: bool = False
) -> list[pytest.Item]:
    marks = {} if limit is None else {"cases": pytest.mark.cases(limit).mark}
    if slow:
        marks["slow"] = pytest.mark.slow.mark
    return [
        cast(
            "pytest.Item",
            SimpleNamespace(nodeid=f"{name}[{n}]", get_closest_marker=marks.get),
        )
        for n in range(count)
    ]


def ids(found: Sequence[Any]) -> list[str]:
    return [item.nodeid for item in found]


def families(found: Sequence[Any]) -> set[str]:
    return {nodeid.partition("[")[0] for nodeid in ids(found)}


@pytest.mark.parametrize(
    ("count", "number", "expected"),
    [(3, 8, [0, 1, 2]), (5, 1, [0]), (101, 3, [0, 50, 100]), (10, 2, [0, 9]), (0, 2, [])],
)
def test_cases_are_spread_from_the_first_to_the_last(
    count: int, number: int, expected: list[int]
) -> None:
    assert spread(range(count), number) == expected


def test_each_test_is_there_with_a_few_of_its_cases_and_in_order() -> None:
    cheap, dear = items("tests/models/test_a.py::test_a", 50), items("tests/streaming/t.py::t", 50)
    marked = items("tests/streaming/t.py::marked", 50, limit=3)
    alone = items("tests/streaming/t.py::alone", 1)
    kept, left = divided([*dear, *alone, *cheap, *marked])
    assert len(kept) == CASES["streaming/"] + 1 + CASES[""] + 3
    assert families(kept) == families([*dear, *alone, *cheap, *marked])
    first = ids(spread(dear, CASES["streaming/"]))
    assert ids(kept)[: len(first) + 1] == [*first, alone[0].nodeid]
    assert sorted(ids(kept) + ids(left)) == sorted(ids([*dear, *alone, *cheap, *marked]))


def test_each_process_begins_with_tests_that_take_long() -> None:
    long = items("tests/sim/t.py::long", 7, slow=True)
    given = [*items("tests/sim/t.py::t", 30), *long]
    ordered = slow_first(given, 3)
    assert sorted(ids(ordered)) == sorted(ids(given))
    shares = [[item in long for item in ordered[at : at + 13]] for at in (0, 12, 24)]
    assert [firsts.index(False) for firsts in shares] == [2, 2, 3]


def test_a_slow_test_is_left_out_and_has_a_case_all_the_same() -> None:
    slow = items("tests/streaming/t.py::slow", 5, limit=3, slow=True)
    assert divided(slow) == ([], slow)
    made: list[Any] = []
    metafunc = SimpleNamespace(
        definition=slow[0], parametrize=lambda names, values, **_: made.append(values)
    )
    spread_cases(cast("pytest.Metafunc", metafunc))
    metafunc.parametrize("name", range(8))
    assert made == [[0]]


@pytest.mark.parametrize("ids", [None, str, list("abcdefgh"), dict.fromkeys("abcdefgh")])
def test_a_table_gives_no_more_cases_than_are_taken(ids: Any) -> None:
    made: list[tuple[Any, ...]] = []
    metafunc = SimpleNamespace(
        definition=items("tests/streaming/t.py::t", 1, limit=3)[0],
        parametrize=lambda *args, **options: made.append((*args, options)),
    )
    spread_cases(cast("pytest.Metafunc", metafunc))
    metafunc.parametrize("name", iter(range(8)), ids=ids)
    named = ids if ids is None or callable(ids) else ["a", "e", "h"]
    assert made == [("name", [0, 4, 7], {"ids": named})]


@pytest.mark.parametrize(("files", "processes"), [(10, 4), (3, 5)])
def test_each_file_is_collected_by_one_process(files: int, processes: int) -> None:
    sizes = {Path(f"{file % 3}/{file}"): 1000 + 7 * file % 5 for file in range(files)}
    parts = [part(sizes, process, processes) for process in range(processes)]
    assert sorted(file for each in parts for file in each) == sorted(sizes)
    assert part(sizes, processes, processes) == parts[0]


def test_each_case_is_in_one_share() -> None:
    names = ids(items("tests/models/test_a.py::test_a", 400))
    shares = [[name for name in names if in_share(name, number, 8)] for number in range(1, 9)]
    assert sorted(name for each in shares for name in each) == sorted(names)
    assert all(shares)
