"""Try a program against its cell before the arm moves, and under many variations of the cell.

It uses the simulator and the package's public functions. Only `patches`, in the process that runs
the program, uses their internals.
"""

from __future__ import annotations

from aioduco.testing.preflight.findings import PreflightFinding
from aioduco.testing.preflight.margins import Margin
from aioduco.testing.preflight.runner import (
    PreflightError,
    PreflightReport,
    PreflightSettings,
    preflight,
)

__all__ = [
    "Margin",
    "PreflightError",
    "PreflightFinding",
    "PreflightReport",
    "PreflightSettings",
    "preflight",
]
