"""A simulated controller that speaks the arm's wire, with the arm in MuJoCo behind it.

`Simulator` is loaded when it is first asked for: its planner and its tasks are used without MuJoCo.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aioduco.sim.process import SimulatorProcess
    from aioduco.sim.simulator import Simulator

__all__ = ["Simulator", "SimulatorProcess"]


def __getattr__(name: str) -> object:
    if name == "Simulator":
        from aioduco.sim.simulator import Simulator  # noqa: PLC0415 - it brings MuJoCo

        return Simulator
    if name == "SimulatorProcess":
        from aioduco.sim.process import SimulatorProcess  # noqa: PLC0415

        return SimulatorProcess
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
