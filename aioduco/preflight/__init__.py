"""A program tried against its cell before the arm moves, and under many variations of it.

Stands on the simulator and the package's public functions; only `patches`, in the process that runs
the program, knows what lies inside them.
"""

from __future__ import annotations

from aioduco.preflight.findings import PreflightFinding
from aioduco.preflight.margins import Margin
from aioduco.preflight.runner import (
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
