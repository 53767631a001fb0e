"""The schedule and the sleep, on a clock of their own."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aioduco.streaming.worker.clock import Schedule, sleep_until

PERIOD = 1000


@given(st.lists(st.integers(0, 5 * PERIOD), min_size=1, max_size=100))
def test_ticks_lie_on_the_grid_and_each_is_served_or_missed(works: list[int]) -> None:
    schedule = Schedule(PERIOD, start=100)
    now = 0
    for served, work in enumerate(works):
        assert (schedule.due - 100) % PERIOD == 0
        assert schedule.due == 100 + (served + schedule.missed) * PERIOD
        now = max(now, schedule.due) + work
        schedule.advance(now)
        # Late by less than one period, or not late at all: there is never a burst.
        assert schedule.due > now - PERIOD


def test_a_tick_on_time_is_never_skipped() -> None:
    schedule = Schedule(PERIOD, start=0)
    for number in range(1000):
        assert schedule.due == number * PERIOD
        assert schedule.advance(schedule.due + PERIOD - 1) == 0
    assert schedule.missed == 0


def test_a_long_stall_is_skipped_at_once() -> None:
    schedule = Schedule(PERIOD, start=0)
    assert schedule.advance(10 * PERIOD + 5) == 9
    assert schedule.due == 10 * PERIOD
    assert schedule.missed == 9


@pytest.mark.parametrize("period", [0, -1])
def test_a_period_must_be_above_zero(period: int) -> None:
    with pytest.raises(ValueError, match="above zero"):
        Schedule(period, 0)


class Clock:
    """A clock that moves when it is slept on, or looked at."""

    def __init__(self, early: int) -> None:
        self.now = 0
        self.early = early
        self.slept: list[int] = []
        self.looks = 0

    def time(self) -> int:
        self.looks += 1
        self.now += 1
        return self.now

    def sleep(self, seconds: float) -> None:
        nanoseconds = round(seconds * 1e9)
        self.slept.append(nanoseconds)
        self.now += max(1, nanoseconds - self.early)


@given(due=st.integers(-10, 10**6), early=st.integers(0, 500), spin=st.integers(0, 1000))
def test_a_sleep_never_ends_early(due: int, early: int, spin: int) -> None:
    clock = Clock(early)
    assert sleep_until(due, spin, clock=clock.time, sleep=clock.sleep) >= due


def test_a_sleep_into_the_past_does_not_sleep() -> None:
    clock = Clock(0)
    sleep_until(0, clock=clock.time, sleep=clock.sleep)
    assert clock.slept == []


def test_spinning_begins_so_long_before() -> None:
    clock = Clock(0)
    sleep_until(10_000, 300, clock=clock.time, sleep=clock.sleep)
    assert sum(clock.slept) <= 9_700
    assert clock.looks >= 300
