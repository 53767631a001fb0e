"""Requests to the system's scheduler."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st
from moments import on_another_thread

from aioduco import WorkerOptions
from aioduco._process.platform import set_realtime_priority
from aioduco._process.scheduling import shorten_slice
from aioduco.streaming.worker.clock import ProcessorShare, Schedule, sleep_until
from aioduco.testing import eventually_async

from .conftest import HERE, Controller


@pytest.mark.linux("policies of the scheduler")
@pytest.mark.parametrize(
    ("policy", "priority", "taken"),
    [("SCHED_BATCH", 0, False), ("SCHED_RR", 1, True), ("SCHED_FIFO", 1, True)],
)
def test_a_short_slice_leaves_another_policy_as_it_is(
    policy: str, priority: int, taken: bool
) -> None:
    """A worker of a program that runs in real time is not put behind everything else."""
    found: list[object] = []

    def run() -> None:
        try:
            os.sched_setscheduler(0, getattr(os, policy), os.sched_param(priority))
        except PermissionError:
            return
        found.append(shorten_slice(1_000_000))
        found.append(os.sched_getscheduler(0) == getattr(os, policy))

    on_another_thread(run)
    if not found:
        pytest.skip("no permission for a policy of real time")
    assert found == [taken, True]


def allowed() -> bool:
    """Whether a thread of this program may go before all others."""
    found: list[bool] = []
    on_another_thread(lambda: found.append(set_realtime_priority(1)))
    return found[0]


_HOG = """
import os, time
from aioduco._process.platform import boost_main_thread, realtime_priority

told = []
assert boost_main_thread(0.02, lambda: told.append(os.sched_getscheduler(0)))
assert realtime_priority() == 1
while not told and time.process_time() < 30.0:
    pass
assert told == [os.SCHED_OTHER], told
assert realtime_priority() == 0
"""


def test_who_goes_first_and_does_not_wait_goes_like_all_others_again() -> None:
    if not allowed():
        pytest.skip("no permission for a policy of real time")
    done = subprocess.run([sys.executable, "-c", _HOG], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
async def test_a_worker_that_is_woken_late_goes_first_by_itself(controller: Controller) -> None:
    """By 125 µs, at this rate: each system wakes somebody so late, sooner or later.

    At a higher rate a worker on a busy machine takes so much of a processor that it gives the
    priority back, perhaps before anybody looks.
    """
    if not allowed():
        pytest.skip("no permission for a policy of real time")
    async with controller.servo.joints(v=1.0, a=5.0, rate=2_000.0) as stream:
        await stream.send(HERE)
        pid = stream.pid
        assert pid is not None
        await eventually_async(
            lambda: (stream.statistics().priority, os.sched_getscheduler(pid)) == (1, os.SCHED_FIFO)
        )
    assert not stream.statistics().unmet


@pytest.mark.slow
@pytest.mark.linux("policies of the scheduler")
async def test_a_worker_that_hardly_waits_leaves_the_processor_to_the_program(
    controller: Controller,
) -> None:
    """It waits, if only for moments: the system does not find that it works without a wait."""
    before = os.sched_getaffinity(0)
    async with controller.servo.joints(v=1.0, a=5.0, rate=50_000.0) as stream:
        assert stream.pid is not None
        # on one processor, as in a small container: the loop runs, and the stream goes on
        one = {min(before)}
        os.sched_setaffinity(stream.pid, one)
        os.sched_setaffinity(0, one)
        try:
            # Before the first set-point it asks nobody, and works nearly all the time.
            await eventually_async(lambda: stream.statistics().ticks > 15_000)
        finally:
            os.sched_setaffinity(0, before)
    assert stream.statistics().priority == 0


def test_a_share_of_a_processor_is_judged_over_a_while() -> None:
    share = ProcessorShare(0, 0)
    assert not share.exceeded(99_999_999, lambda: 99_999_999)
    assert not share.exceeded(100_000_000, lambda: 50_000_000)
    assert not share.exceeded(150_000_000, lambda: 100_000_000)
    assert share.exceeded(200_000_000, lambda: 100_000_001)
    assert not share.exceeded(300_000_000, lambda: 100_000_002)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "priority"),
    [
        (WorkerOptions(priority=0), 0),
        (WorkerOptions(priority=3), 3),
        (WorkerOptions(run_in="thread"), 0),
    ],
)
async def test_a_worker_that_was_told_how_to_go_goes_so(
    controller: Controller, options: WorkerOptions, priority: int
) -> None:
    if not allowed():
        pytest.skip("no permission for a policy of real time")
    async with controller.servo.joints(v=1.0, a=5.0, rate=10_000.0, options=options) as stream:
        await stream.play([HERE] * 300)
    assert stream.statistics().priority == priority


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


@for_each("period", [0, -1])
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
