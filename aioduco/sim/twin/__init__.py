"""The twin beside the arm: a simulated arm that gets the same commands, and says where they part.

    async with aioduco.connect("192.168.1.10") as robot:
        limits = aioduco.sim.twin.TwinLimits.load("limits.json")
        async with robot.twin(limits, action="pause"):
            ...

`rehearsal` carries the program's commands out on the simulator's controller, `predictor` says how
far each sample is from what it should be, `patterns` which cause explains external torques,
`monitor` where arm and twin have parted, and `limits` what is normal: none of them has I/O or a
clock. `worker` runs them in a process of its own for a `Twin`, which observes a robot; `recorded`
for a recording.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aioduco.sim.twin.data import Cause, Divergence, Quantity, TwinCommand, TwinSample
    from aioduco.sim.twin.limits import TwinLimits
    from aioduco.sim.twin.monitor import TwinFigures, TwinMonitor
    from aioduco.sim.twin.recorded import judge, learn
    from aioduco.sim.twin.twin import Twin, TwinAction, TwinStatistics

__all__ = [
    "Cause",
    "Divergence",
    "Quantity",
    "Twin",
    "TwinAction",
    "TwinCommand",
    "TwinFigures",
    "TwinLimits",
    "TwinMonitor",
    "TwinSample",
    "TwinStatistics",
    "judge",
    "learn",
]

_HOMES = {
    "data": ("Cause", "Divergence", "Quantity", "TwinCommand", "TwinSample"),
    "limits": ("TwinLimits",),
    "monitor": ("TwinFigures", "TwinMonitor"),
    "recorded": ("judge", "learn"),
    "twin": ("Twin", "TwinAction", "TwinStatistics"),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Load a name on first use: the twin's process does not load the client."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
