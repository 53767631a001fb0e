"""When a beat may be sent: the state machine, without a thread."""

from __future__ import annotations

import math

import hypothesis.strategies as st
import pytest
from hypothesis import given

from aioduco.supervision.heartbeat import HeartbeatMachine, HeartbeatState


def pulse() -> HeartbeatMachine:
    return HeartbeatMachine(time=1.0, stall_limit=0.5, now=0.0)


def state(heart: HeartbeatMachine) -> HeartbeatState:
    return heart.state


def test_beats_while_the_loop_lives() -> None:
    heart = pulse()
    assert state(heart) is HeartbeatState.STARTING
    for now in (0.0, 0.3, 0.6):
        assert heart.may_beat(now, alive=now - 0.1)
        heart.beaten(now)
    assert state(heart) is HeartbeatState.BEATING
    assert (heart.beats, heart.missed, heart.longest_gap) == (3, 0, 0.3)


def test_a_loop_that_hangs_is_latched_until_rearmed() -> None:
    heart = pulse()
    heart.beaten(0.0)
    assert heart.may_beat(0.5, alive=0.0)
    assert not heart.may_beat(0.51, alive=0.0)
    assert state(heart) is HeartbeatState.STALLED
    # The loop runs again, but the arm was stopped meanwhile: the program has to say so.
    assert not heart.may_beat(1.0, alive=1.0)
    heart.beaten(1.0)  # an answer that was on its way
    assert state(heart) is HeartbeatState.STALLED
    heart.rearm()
    assert heart.may_beat(1.1, alive=1.0)
    heart.beaten(1.1)
    assert state(heart) is HeartbeatState.BEATING
    assert heart.stalls == 1


def test_lost_only_when_the_heartbeat_time_has_passed() -> None:
    heart = pulse()
    heart.beaten(0.0)
    heart.missed_beat(0.4)
    heart.missed_beat(0.8)
    assert state(heart) is HeartbeatState.BEATING
    heart.missed_beat(1.1)
    heart.missed_beat(1.5)
    assert state(heart) is HeartbeatState.LOST
    assert heart.losses == 1
    heart.beaten(1.6)
    assert state(heart) is HeartbeatState.BEATING
    assert (heart.missed, heart.longest_gap) == (4, 1.6)


def test_rearming_what_is_not_stalled_does_nothing() -> None:
    heart = pulse()
    heart.beaten(0.0)
    heart.rearm()
    assert state(heart) is HeartbeatState.BEATING


def test_beats_are_due_on_an_absolute_schedule() -> None:
    heart = HeartbeatMachine(time=0.9, stall_limit=60.0, now=10.0)
    woken, sent = 10.0, []
    for late in (0.0, 0.1, 0.0, 0.7, 0.0, 0.0):
        woken = heart.wakes_at(alive=woken) + late
        sent.append(woken)
        heart.plan_next(woken)
        heart.beaten(woken)
    # The one that was late by 0.7 s is followed by one at once, and not by two.
    assert sent == pytest.approx([10.0, 10.4, 10.6, 11.6, 11.6, 11.9])


def test_a_beat_without_an_answer_is_repeated_before_the_next_is_due() -> None:
    heart = HeartbeatMachine(time=1.2, stall_limit=60.0, now=10.0)
    heart.plan_next(10.0)
    heart.missed_beat(10.1)
    assert heart.wakes_at(alive=10.0) == pytest.approx(10.2)
    heart.missed_beat(10.19)  # a quarter later would be after the next one
    assert heart.wakes_at(alive=10.0) == pytest.approx(10.2)


def test_an_overdue_keep_alive_is_noticed_between_two_beats() -> None:
    heart = HeartbeatMachine(time=30.0, stall_limit=2.0, now=100.0)
    heart.plan_next(100.0)
    heart.beaten(100.0)
    heart.suspended(100.5)
    woken = heart.wakes_at(alive=100.3)
    assert woken == pytest.approx(102.5, abs=0.01)
    assert not heart.may_beat(woken, alive=100.3)
    assert state(heart) is HeartbeatState.STALLED
    assert heart.wakes_at(alive=100.3) == 110.0  # nothing more to notice


@pytest.mark.parametrize(("late", "suspended"), [(0.99, False), (1.01, True)])
def test_who_wakes_up_late_by_the_heartbeat_time_was_suspended(
    late: float, suspended: bool
) -> None:
    heart = pulse()
    heart.woken(50.0 + late, planned=50.0)
    assert heart.suspended_at == (50.0 + late if suspended else -math.inf)


def test_the_controller_has_stopped_the_arm_when_no_beat_was_given_for_twice_its_time() -> None:
    heart = HeartbeatMachine(time=3.0, stall_limit=60.0, now=10.0)
    assert not heart.lapsed(1000.0)  # it knows of no heartbeat yet
    heart.given = 12.0
    heart.beaten(12.1)
    assert not heart.lapsed(18.0)
    assert heart.lapsed(18.01)
    assert heart.lapsed(24.1)


@given(st.lists(st.tuples(st.floats(0, 3), st.booleans(), st.floats(0, 2)), max_size=50))
def test_no_beat_is_allowed_after_a_stall(steps: list[tuple[float, bool, float]]) -> None:
    heart = pulse()
    now, stalled = 0.0, False
    for passed, heard, silent in steps:
        now += passed
        stalled = stalled or silent > 0.5
        # A nanosecond on both sides of the limit: sums of floats are not exact.
        allowed = heart.may_beat(now, alive=now - silent)
        if abs(silent - 0.5) > 1e-9:
            assert allowed is not stalled
        stalled = not allowed
        if allowed:
            (heart.beaten if heard else heart.missed_beat)(now)
