"""The page of a report, as a browser shows it."""

from __future__ import annotations

import runpy
import shutil
from pathlib import Path

import pytest

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
