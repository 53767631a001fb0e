"""What the quick run takes of the tests."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import pytest
from quick import CASES, divided, examples, part, slow_first, spread, spread_cases

if TYPE_CHECKING:
    from collections.abc import Sequence


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


@pytest.mark.parametrize(
    ("slow", "quick", "processes"), [(7, 30, 3), (9, 2, 4), (0, 5, 2), (3, 8, 1)]
)
def test_each_process_begins_with_tests_that_take_long(
    slow: int, quick: int, processes: int
) -> None:
    long = items("tests/sim/t.py::long", slow, slow=True)
    given = [*items("tests/sim/t.py::t", quick), *long]
    ordered = slow_first(given, processes)
    assert sorted(ids(ordered)) == sorted(ids(given))
    begin, began = 0, 0
    for process in range(processes):
        part = ordered[begin : begin + (len(given) - begin) // (processes - process)]
        firsts = [item in long for item in part]
        # those that take long come first, and each process has a like number of them
        assert firsts == sorted(firsts, reverse=True)
        began += sum(firsts)
        begin += len(part)
        assert abs(sum(firsts) - slow / processes) < 1
    assert began == slow


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


@pytest.mark.parametrize(("files", "processes"), [(10, 4), (8, 2), (3, 5), (7, 1)])
def test_each_file_is_collected_by_one_process(files: int, processes: int) -> None:
    sizes = {file: 1000 + 7 * file % 5 for file in range(files)}
    parts = [part(sizes, process, processes) for process in range(processes)]
    assert sorted(number for each in parts for number in each) == list(range(files))
    assert part(sizes, processes, processes) == parts[0]
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


def test_a_large_file_is_dealt_as_many_small_ones() -> None:
    assert part({"a": 1, "b": 2, "large": 6, "c": 3}, 0, 2) == ["large"]
    assert part({"a": 1, "b": 2, "large": 6, "c": 3}, 1, 2) == ["a", "b", "c"]


def test_properties_are_tried_with_all_or_a_few_of_their_examples(thorough: bool) -> None:
    assert examples(300) == (300 if thorough else 30)
    assert examples(10) == (10 if thorough else 5)
    assert examples(2) == 2
