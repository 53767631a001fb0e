"""The times of simulators whose test names none."""

from __future__ import annotations

import dataclasses
from typing import Any

from aioduco.sim import Simulator
from aioduco.sim.controller.power import CHANGES
from aioduco.sim.process import SimulatorProcess
from aioduco.sim.simulator import CYCLE

#: What is not about the simulator needs no finer cycle, and it takes less of the computer [s].
COARSE = 0.004
#: that of a user [s]
FINE = CYCLE
#: What is not about the simulator need not wait for its power: how long these last [s].
SHORT = {"power_on": 0.05, "enable": 0.03}
#: how long they last for a user [s]; both have one step
USUAL = {name: CHANGES[name].steps[0][0] for name in SHORT}

#: beginnings of the paths of tests that have a user's cycle in the thorough run: those of the
#: simulator itself, of what the pages show, and of points that are followed closely
REAL = ("manual/test_examples", "pages/", "recording/playback/test_player", "sim/")


def set_cycle(seconds: float) -> float:
    """Make this the cycle [s] of simulators that are given none; what it was."""
    defaults = _defaults()
    before: float = defaults["cycle"]
    defaults["cycle"] = seconds
    return before


def spare_processor(speed: float) -> None:
    """Let simulators that are not told otherwise take little of the computer."""
    _defaults().update({"cycle": COARSE, "speed": speed})


def _defaults() -> dict[str, Any]:
    defaults = Simulator.__init__.__kwdefaults__
    assert defaults is not None
    return defaults


def _spawn_with_defaults() -> None:
    """Let simulators in processes of their own have what those in this one have by default."""
    make = SimulatorProcess.__init__

    def make_alike(self: SimulatorProcess, options: dict[str, Any]) -> None:
        make(self, {name: _defaults()[name] for name in ("cycle", "speed")} | options)

    SimulatorProcess.__init__ = make_alike  # type: ignore[method-assign]


_spawn_with_defaults()


def set_power_times(times: dict[str, float]) -> dict[str, float]:
    """Let changes of power last so long [s] in this process; how long they did."""
    before = {name: CHANGES[name].steps[0][0] for name in times}
    for name, seconds in times.items():
        ((_, state),) = CHANGES[name].steps
        CHANGES[name] = dataclasses.replace(CHANGES[name], steps=((seconds, state),))
    return before
