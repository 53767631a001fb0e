"""The figures of the pages: a percentile is shown only if enough was measured."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """docs/figures.py, with results of this test."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    module = importlib.import_module("figures")
    row = {"p50_us": 10.0, "p99_us": 20.0, "p99.9_us": 30.0}
    rows: dict[str, Any] = {str(n): row | {"stops": n} for n in (99, 100, 999, 1000)}
    machine = {"date": "2026-01-02", "processor": "CPU", "cores": 2, "system": "S", "python": "3"}
    told = machine | {"commit": "abc1234", "wake_up_us": {"p50": 8.1, "p99": 40.0, "max": 90.0}}
    result = {"machine": told, "stop": rows, "unknown": {"of how many": row}}
    (tmp_path / "made.json").write_text(json.dumps(result), "utf-8")
    monkeypatch.setattr(module, "RESULTS", tmp_path)
    return module


def test_a_percentile_needs_samples(figures: Any) -> None:
    text = "<!-- table: made / stop / * :: p50_us; p99_us; p99.9_us = last -->\n| old |\n"
    marker, *table = figures.page(text).splitlines()
    assert marker.startswith("<!-- table")
    assert table == [
        "| | p50 [µs] | p99 [µs] | last |",
        "|---|---:|---:|---:|",
        "| 99 | 10 | – | – |",
        "| 100 | 10 | 20 | – |",
        "| 999 | 10 | 20 | – |",
        "| 1000 | 10 | 20 | 30 |",
    ]


def test_a_percentile_of_an_unknown_number_is_not_shown(figures: Any) -> None:
    text = "<!-- table: made / unknown / * :: p50_us; p99_us -->\n"
    assert figures.page(text).splitlines()[-1] == "| of how many | 10 | – |"


def test_nor_in_the_text_of_a_page(figures: Any) -> None:
    assert figures.page("0 µs<!-- figure: made / stop / 100 / p99_us -->") == (
        "20 µs<!-- figure: made / stop / 100 / p99_us -->"
    )
    with pytest.raises(ValueError, match="too few samples: 99"):
        figures.page("0 µs<!-- figure: made / stop / 99 / p99_us -->")


def test_commit_and_machine_are_told(figures: Any) -> None:
    assert figures.page("old <!-- measured: made -->") == (
        "Measured 2026-01-02, commit abc1234: CPU; 2 cores; S; Python 3; a bare process wakes up "
        "in 8.1 µs, p99 40.0. <!-- measured: made -->"
    )
