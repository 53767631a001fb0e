"""A simulated controller with the arm's wire protocol; MuJoCo simulates the arm."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from aioduco.errors import MissingExtra

if TYPE_CHECKING:
    from aioduco.sim.process import SimulatorProcess
    from aioduco.sim.profile import ArmProfile, Estimate
    from aioduco.sim.simulator import Simulator

__all__ = ["ArmProfile", "Estimate", "Simulator", "SimulatorProcess"]

_HOMES = {
    "ArmProfile": "aioduco.sim.profile",
    "Estimate": "aioduco.sim.profile",
    "Simulator": "aioduco.sim.simulator",
    "SimulatorProcess": "aioduco.sim.process",
}


def __getattr__(name: str) -> Any:
    """Import a class that needs MuJoCo on access; planner and task table work without MuJoCo."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    with MissingExtra.named("the simulator", "sim"):
        return getattr(importlib.import_module(_HOMES[name]), name)
