"""The page of a report, as a browser shows it."""

from __future__ import annotations

import runpy
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from aioduco.kinematics import arm
from aioduco.testing.preflight.html import _speeds

SCRIPT = Path(__file__).resolve().parents[3] / "docs/preflight_page.py"


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium")
def test_the_page_loads_nothing_and_fits_a_narrow_window() -> None:
    pytest.importorskip("PIL")
    script = runpy.run_path(str(SCRIPT))
    text = script["report"]()
    assert not [each for each in ("http:", "https:", "<script", "<link") if each in text]
    script["check"](text)


@pytest.mark.parametrize("at", [0, 5_000, 5_001, 9_999])
def test_a_short_motion_of_a_long_program_is_in_the_picture_of_the_speeds(at: int) -> None:
    """Only every sixteenth sample of it was."""
    speeds = np.zeros((10_000, 6))
    speeds[at, 2] = arm("gcr5_910").velocity[2]
    report: Any = SimpleNamespace(
        samples={"time": np.arange(10_000.0), "qd": speeds},
        cell={"model": "gcr5_910"},
        duration=1e4,
    )
    still, moved = ",134.0", ",6.0"
    lines = _speeds(report).split("<polyline")[1:]
    assert [moved in line for line in lines] == [False, False, True, False, False, False]
    assert all(still in line for line in lines)
