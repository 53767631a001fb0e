"""The program's clock, with a simulator."""

from __future__ import annotations

import logging
import math
from functools import partial

import pytest

from aioduco.sim import Simulator, runtime
from aioduco.testing import eventually
from aioduco.testing.preflight.program_clock import ProgramClock


def _given_up(log: pytest.LogCaptureFixture, times: int) -> bool:
    return log.text.count("and goes on") == times


def test_a_program_that_is_held_up_for_long_finds_its_time_where_it_was(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Where all threads stop for seconds, the simulator may go on before any of them."""
    caplog.set_level(logging.WARNING)
    monkeypatch.setattr(runtime, "_HOLD", 0.01)
    clock = ProgramClock()  # not started: its thread comes too late
    with Simulator() as simulator:
        clock.attach(simulator)
        simulator.speed = 1e5
        at = math.nan
        for number in range(1, 6):
            simulator.clock.hold(-math.inf)
            eventually(partial(_given_up, caplog, number), 30.0)
            if number == 1:
                at = clock.passed
        assert clock.passed == at
        clock.detach()


def test_time_stands_while_a_loop_with_a_timer_due_does_not_get_to_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a busy machine the arm would be far beyond the end of its motion at the next poll."""
    looks: list[float] = []
    look = ProgramClock._look

    def counted(self: ProgramClock) -> None:
        looks.append(self.passed)
        look(self)

    monkeypatch.setattr(ProgramClock, "_look", counted)
    clock = ProgramClock()
    with Simulator() as simulator:
        clock.start()
        clock.attach(simulator)
        try:
            with clock.waiting(-1.0):  # it was due a second ago
                begin, number = simulator.time, len(looks)
                eventually(lambda: len(looks) > number + 5)
                assert simulator.time < begin + 0.01  # a cycle may be under way
            with clock.waiting(60.0):
                eventually(lambda: simulator.time > begin + 1.0)
        finally:
            clock.close()
