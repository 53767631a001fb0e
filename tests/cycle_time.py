"""The cycle of simulators whose test names none."""

from __future__ import annotations

from aioduco.sim import Simulator

#: What is not about the simulator itself needs no finer one, and it takes less of the computer [s].
COARSE = 0.004


def set_cycle(seconds: float) -> float:
    """Make this the cycle [s] of simulators in this process that are given none; what it was."""
    defaults = Simulator.__init__.__kwdefaults__
    assert defaults is not None
    before: float = defaults["cycle"]
    defaults["cycle"] = seconds
    return before
