"""No test, file or case is lost where a run takes a few of them, or is divided."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from quick import CASES, divided, in_share, part, spread


def items(name: str, count: int, limit: int | None = None) -> list[pytest.Item]:
    marks = {} if limit is None else {"cases": pytest.mark.cases(limit).mark}
    made: list[Any] = [
        SimpleNamespace(nodeid=f"{name}[{n}]", get_closest_marker=marks.get) for n in range(count)
    ]
    return cast("list[pytest.Item]", made)


def test_each_test_is_there_with_a_few_of_its_cases_and_in_order() -> None:
    cheap, dear = items("tests/models/test_a.py::test_a", 50), items("tests/streaming/t.py::t", 50)
    marked = items("tests/streaming/t.py::marked", 50, limit=3)
    alone = items("tests/streaming/t.py::alone", 1)
    kept, left = divided([*dear, *alone, *cheap, *marked])
    first = spread(dear, CASES["streaming/"])
    assert kept == [*first, *alone, *spread(cheap, CASES[""]), marked[0], marked[24], marked[49]]
    assert len(kept) + len(left) == 151


@pytest.mark.parametrize(("files", "processes"), [(10, 4), (3, 5)])
def test_each_file_is_collected_by_one_process(files: int, processes: int) -> None:
    sizes = {Path(f"{file % 3}/{file}"): 1000 + 7 * file % 5 for file in range(files)}
    parts = [part(sizes, process, processes) for process in range(processes)]
    assert sorted(file for each in parts for file in each) == sorted(sizes)
    assert part(sizes, processes, processes) == parts[0]


def test_each_case_is_in_one_share() -> None:
    names = [f"tests/models/test_a.py::test_a[{n}]" for n in range(400)]
    shares = [[name for name in names if in_share(name, number, 8)] for number in range(1, 9)]
    assert sorted(name for each in shares for name in each) == sorted(names)
    assert all(shares)
