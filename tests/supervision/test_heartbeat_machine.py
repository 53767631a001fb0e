"""When a beat may be sent: the state machine, without a thread."""

from __future__ import annotations

import hypothesis.strategies as st
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
