"""The fidelity ledger names tests that there are."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

HERE = Path(__file__).parent
LEDGER = HERE.parents[1] / "docs" / "fidelity.md"
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in LEDGER.read_text(encoding="utf-8").splitlines()
    if line.startswith("|") and not line.startswith(("| behaviour", "|---"))
]


@pytest.mark.parametrize("row", ROWS, ids=[row[0][:60] for row in ROWS])
def test_each_row_has_a_source_and_a_test(row: list[str]) -> None:
    behaviour, source, test = row
    assert behaviour
    assert re.match(r"manual|wire|seen|assumption|own decision|IEC", source)
    found = re.fullmatch(r"`([\w/]+\.py)::(\w+)`", test)
    assert found is not None
    module = (HERE / found[1]).read_text(encoding="utf-8")
    assert re.search(rf"^(async )?def {found[2]}\(", module, re.MULTILINE)


def test_there_is_a_ledger() -> None:
    assert len(ROWS) > 50
