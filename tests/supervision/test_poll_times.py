"""When tasks are polled: functions of times."""

from __future__ import annotations

import random
import statistics

import hypothesis.strategies as st
import pytest
from hypothesis import example, given

from aioduco.supervision.concurrency import GRID, on_grid
from aioduco.supervision.task_follower import (
    EARLY,
    FAST,
    PROMPT,
    SLOW,
    STEADY,
    interval,
    next_poll,
)

AGES = st.floats(0, 1e6)
REMAINING = st.one_of(st.none(), st.floats(-1e6, 1e6))


@given(AGES, REMAINING)
def test_every_interval_is_within_its_bounds(age: float, remaining: float | None) -> None:
    assert FAST <= interval(age, remaining) <= SLOW


@given(st.floats(0, FAST), REMAINING)
def test_a_fresh_task_is_asked_about_soon(age: float, remaining: float | None) -> None:
    assert interval(age, remaining) <= EARLY
    assert interval(age) == interval(age, 0.004) == FAST


@given(AGES, st.floats(0, 1e6))
def test_an_end_of_which_nobody_knew_is_seen_before_the_task_is_twice_as_old(
    age: float, remaining: float
) -> None:
    """A failure, for instance; what ends within hundredths of a second is asked about sooner."""
    assert interval(age, remaining) <= max(age, EARLY)


@given(AGES, st.floats(0, 1e6))
def test_an_expected_end_is_never_slept_through(age: float, remaining: float) -> None:
    assert interval(age, remaining) <= max(remaining, FAST)


def test_far_from_an_expected_end_it_is_slow_and_near_it_fast() -> None:
    assert interval(1.0, 2.0) == SLOW
    assert interval(1.0, 0.004) == FAST
    assert interval(1.0, -0.05) == FAST
    assert interval(1.0, -1.0) == STEADY
    assert interval(1.0) == STEADY
    assert interval(2.5) == STEADY
    assert interval(10.0) == 10.0 * PROMPT  # a long motion is told at the same part of its time
    assert interval(3600.0) == SLOW


def lateness(duration: float, expected: float | None, late: float) -> float:
    """How late the end of a task is seen if each poll happens `late` after its due time."""
    due = 0.0
    while (now := due + late) < duration:
        due = next_poll(due, now, interval(now, None if expected is None else expected - now))
    return now - duration


def test_the_end_is_seen_within_five_milliseconds_at_the_median() -> None:
    rng = random.Random(1)
    durations = [rng.uniform(0.01, 5.0) for _ in range(400)]
    late = 0.0012  # what an event loop and a round trip cost on top of the schedule
    unexpected = [lateness(d, None, late) for d in durations]
    expected = [lateness(d, d * rng.uniform(0.98, 1.02), late) for d in durations]
    assert statistics.median(unexpected) < 0.005
    assert statistics.median(expected) < 0.005
    # An end that comes much before the one expected is still seen within one slow interval.
    early = [lateness(d, d * 3, late) for d in durations]
    assert max(early) <= SLOW + late + 1e-9


def test_a_known_end_costs_fewer_polls_than_an_unknown_one() -> None:
    def polls(expected: float | None) -> int:
        now, count = 0.0, 0
        while now < 3.0:
            now += interval(now, None if expected is None else expected - now)
            count += 1
        return count

    assert polls(3.0) < polls(None) / 2


def test_due_times_are_absolute() -> None:
    assert next_poll(10.0, 10.003, 0.005) == 10.005  # late, but within the interval: no drift
    assert next_poll(10.005, 10.5, 0.005) == 10.505  # far behind: the missed ones are left out


@given(st.floats(0.0, 1e5), st.floats(0.0, 0.01), st.floats(FAST, SLOW))
@example(0.0, 0.008376283891193671, 0.009765625)  # the last of the grid is past already
def test_long_intervals_end_on_the_grid_and_never_later(
    begin: float, late: float, every: float
) -> None:
    due = next_poll(begin, begin + late, every)
    asked = begin + every if begin + every > begin + late else begin + late + every
    assert begin + late < due <= asked
    if every >= 4 * GRID and on_grid(asked) > begin + late:
        assert asked - due <= GRID * 1.0001
        assert due / GRID == pytest.approx(round(due / GRID), abs=1e-4)
    else:
        assert due == asked


def test_more_tasks_than_time_are_asked_in_turn() -> None:
    """The earliest due time is that of the task that was not polled for longest."""
    due = dict.fromkeys(range(50), 0.0)
    asked: list[int] = []
    now = 0.0
    for _ in range(200):
        now += 0.001  # one poll takes longer than 50 of them may
        key = min(due, key=due.__getitem__)
        asked.append(key)
        due[key] = next_poll(due[key], now, 0.005)
    assert {asked.count(key) for key in range(50)} == {4}
