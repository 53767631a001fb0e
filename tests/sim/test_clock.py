"""The clock of a simulator."""

from __future__ import annotations

import math
import threading
from typing import Any, cast

import pytest
from for_each import for_each

from aioduco.sim.batches import Batches
from aioduco.sim.clock import CycleSchedule, LoopTimes


def test_cycles_are_due_on_an_absolute_schedule() -> None:
    pace = CycleSchedule(0.001, 1.0)
    pace.begin(100.0)
    # Each cycle is 0.3 ms late; the next one is due as if it had not been.
    for n in range(1, 50):
        delay = pace.delay(100.0 + (n - 1) * 0.001 + 0.0003)
        assert delay == pytest.approx(0.0007)
        pace.ran()


def test_another_speed_begins_the_schedule_anew() -> None:
    pace = CycleSchedule(0.001, math.inf)
    pace.begin(0.0)
    pace.change(math.inf, 5.0, idle=False)
    assert pace.delay(5.0) == 0.0
    pace.change(0.5, 7.0, idle=False)
    assert pace.delay(7.0) == pytest.approx(0.002)
    pace.change(0.5, 7.001, idle=False)
    assert pace.delay(7.0) == pytest.approx(0.002)


def test_as_fast_as_possible_never_waits_but_idles_in_real_time() -> None:
    pace = CycleSchedule(0.001, math.inf)
    pace.begin(0.0)
    assert pace.delay(0.0) == 0.0
    pace.begin(0.0, idle=True)
    assert pace.due(0.0205) == 20
    pace.ran(20)
    assert pace.due(0.0205) == 0


def test_what_cannot_be_caught_up_is_given_up_and_counted() -> None:
    pace = CycleSchedule(0.001, 1.0)
    pace.begin(0.0)
    assert pace.delay(0.05) < 0.0
    assert pace.slipped == 0.0
    assert pace.delay(1.0) == 0.0
    assert pace.slipped == pytest.approx(0.999)
    pace.ran()
    assert pace.delay(1.0) == pytest.approx(0.001)


@for_each("speed", [0.0, -1.0, math.nan])
def test_a_speed_is_above_zero(speed: float) -> None:
    with pytest.raises(ValueError, match="above 0"):
        CycleSchedule(0.001, speed)


def test_statistics_of_no_cycle_are_zero_and_of_a_thousand_are_percentiles() -> None:
    times = LoopTimes()
    assert times.statistics(0.0)[2:] == (0.0,) * 6
    for n in range(1000):
        times.add(n / 1000, n / 100)
    found = times.statistics(0.5)
    assert found.cycles == 1000
    assert found.slipped == 0.5
    assert (found.late_p50, found.late_p99, found.late_max) == (0.5, 0.99, 0.999)
    assert (found.work_p50, found.work_p99, found.work_max) == (5.0, 9.9, 9.99)


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
