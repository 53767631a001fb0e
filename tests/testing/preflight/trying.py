"""How tests have a program tried."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from aioduco.testing.preflight import PreflightReport, PreflightSettings, preflight


def tried(folder: Path, text: str, **settings: Any) -> PreflightReport:
    """The report about a program of this text."""
    path = folder / "program.py"
    path.write_text(text, encoding="utf-8")
    return preflight(path, (), PreflightSettings(**{"timeout": 110, **settings}), quiet=True)
