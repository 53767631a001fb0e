"""Who waits for the cycles that are due goes on as soon as they have run."""

from __future__ import annotations

import threading
from typing import Any, cast

from aioduco.sim.batches import Batches


class Pace:
    """A schedule that says what it is told to."""

    cycle = period = 0.001

    def __init__(self, delays: list[float], due: int) -> None:
        self.delays = delays
        self.count = due

    def delay(self, now: float) -> float:
        return self.delays.pop(0)

    def due(self, now: float) -> int:
        return self.count


def woken(delays: list[float], due: int) -> Batches:
    """Batches whose thread was woken at once."""
    wake = threading.Event()
    wake.set()
    batches = Batches(cast("Any", Pace(delays, due)), wake, lambda: False)
    assert batches.await_cycle(100.0) is None
    assert batches.asleep
    return batches


def test_when_all_that_were_due_have_run() -> None:
    batches = woken([0.001, -0.002, -0.001], 2)
    for left in (True, False):
        assert batches.await_cycle(100.0) == 100.0
        batches.ran()
        assert batches.asleep is left


def test_with_the_next_cycle_when_none_was_due() -> None:
    """It came to be due since: on a busy machine the thread may be late for long."""
    batches = woken([0.001, -0.0001], 0)
    assert batches.await_cycle(100.0) == 100.0
    batches.ran()
    assert not batches.asleep


def test_at_once_when_nothing_is_due() -> None:
    batches = woken([0.001, 0.0005], 0)
    batches._asked_at = 100.0
    batches.await_cycle(100.0)
    assert not batches.asleep
