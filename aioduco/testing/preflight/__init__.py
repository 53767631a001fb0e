"""Try a program against its cell before the arm moves, and under many variations of the cell.

It uses the simulator and the package's public functions. In the process that runs the program, this
package asks it by `aioduco._process.trial` and `aioduco.sim.trial` (`tried_program`,
`tried_controller`), and functions of the standard library are replaced (`patches`).
"""

from __future__ import annotations

from aioduco.errors import MissingExtra
from aioduco.testing.preflight.findings import PreflightFinding

with MissingExtra.named("a preflight", "sim"):
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
