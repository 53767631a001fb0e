"""`every` and `Alarm`: turns on an absolute schedule, on a clock of the test."""

from __future__ import annotations

import time

import anyio
import anyio.lowlevel
import pytest

from aioduco.supervision import concurrency
from aioduco.supervision.concurrency import Alarm, every


class Clock:
    """A clock on which sleeping takes exactly as long as it says."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now

    async def sleep(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.now += seconds
        await anyio.lowlevel.checkpoint()


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(concurrency, "time", clock)
    monkeypatch.setattr(anyio, "sleep", clock.sleep)
    return clock


async def test_the_first_turn_comes_at_once_and_the_others_a_period_apart(clock: Clock) -> None:
    ticker = every(0.5)
    turns = []
    for work in (0.0, 0.25, 0.375):
        turns.append((await anext(ticker), clock.now))
        clock.now += work  # what a turn does is no part of the period
    turns.append((await anext(ticker), clock.now))
    assert turns == [(1000.0 + 0.5 * turn, 1000.0 + 0.5 * turn) for turn in range(4)]


async def test_a_late_turn_does_not_move_the_later_ones(clock: Clock) -> None:
    ticker = every(0.5)
    await anext(ticker)
    await anext(ticker)  # due at 1000.5
    clock.now = 1000.75
    assert await anext(ticker) == 1001.0
    assert await anext(ticker) == 1001.5


async def test_turns_that_were_missed_are_left_out(clock: Clock) -> None:
    ticker = every(0.5)
    await anext(ticker)
    clock.now = 1007.25
    assert await anext(ticker) == 1007.25
    assert clock.now == 1007.25
    assert await anext(ticker) == 1007.75


async def test_the_period_may_change_between_two_turns(clock: Clock) -> None:
    ticker = every(0.5)
    await anext(ticker)
    ticker.period = 2.0
    assert await anext(ticker) == clock.now == 1002.0


async def test_a_turn_can_be_postponed_or_asked_for_at_once(clock: Clock) -> None:
    ticker = every(0.5)
    await anext(ticker)
    ticker.postpone(1.0)
    assert await anext(ticker) == clock.now == 1001.5
    clock.now += 0.125
    ticker.restart()
    assert await anext(ticker) == clock.now == 1001.625
    assert await anext(ticker) == 1002.125


async def test_a_schedule_that_began_earlier_tells_how_late_its_first_turn_is(clock: Clock) -> None:
    ticker = every(0.5, first=999.75)
    assert await anext(ticker) == 999.75
    assert clock.now == 1000.0
    assert await anext(ticker) == 1000.25


async def test_an_alarm_wakes_when_its_time_has_come() -> None:
    due = time.monotonic() + 0.02
    await Alarm().wait(due)
    assert time.monotonic() >= due - 0.001  # the loop's clock is that coarse on some systems


async def test_an_alarm_wakes_at_once_when_it_is_rung() -> None:
    alarm = Alarm()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(alarm.wait, time.monotonic() + 3600.0)
        await anyio.lowlevel.checkpoint()
        alarm.ring()
        alarm.ring()
    # that was all for who waited: the next one waits again
    with anyio.move_on_after(0.01) as scope:
        await alarm.wait()
    assert scope.cancelled_caught


async def test_an_alarm_that_was_rung_before_anybody_waited_wakes_the_first_one() -> None:
    alarm = Alarm()
    alarm.ring()
    await alarm.wait()
    with anyio.move_on_after(0.01) as scope:
        await alarm.wait()
    assert scope.cancelled_caught


async def test_an_alarm_whose_wait_was_cancelled_serves_the_next_one() -> None:
    alarm = Alarm()
    with anyio.move_on_after(0.0):
        await alarm.wait(time.monotonic() + 3600.0)
    alarm.ring()
    await alarm.wait()


async def test_an_alarm_that_was_postponed_wakes_later() -> None:
    alarm = Alarm()
    alarm.postpone(0.0)  # nobody waits
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(alarm.wait, time.monotonic() + 0.01)
        await anyio.lowlevel.checkpoint()
        alarm.postpone(time.monotonic() + 3600.0)
        await Alarm().wait(time.monotonic() + 0.02)
        assert alarm.awaited
        alarm.postpone(time.monotonic())
