"""What is done about an unanswered motion: the state machine."""

from __future__ import annotations

from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.supervision.unanswered import MAX_WATCH, MIN_WATCH, NextStep, UnansweredMotion

ANSWER_BY, UNTIL = 60.0, 70.0


def motion() -> UnansweredMotion:
    return UnansweredMotion(0.0, ANSWER_BY, UNTIL)


def stand(one: UnansweredMotion, sent: float, accepted: float) -> None:
    """A stop was accepted, and the arm was seen to stand."""
    one.stopped(sent, accepted)
    look(one, accepted)
    look(one, accepted)


def look(one: UnansweredMotion, now: float, *, moving: bool = False) -> None:
    """It was asked whether the arm moves, and answered at once."""
    one.seen(now, now, moving=moving)


def test_the_arm_is_stopped_first() -> None:
    assert motion().step(0.0) is NextStep.STOP


def test_a_standing_arm_is_watched_as_long_as_the_answer_may_come() -> None:
    one = motion()
    stand(one, 0.0, 0.1)
    assert one.step(0.1) is NextStep.LOOK
    assert one.step(ANSWER_BY - 0.1) is NextStep.LOOK
    for now in (ANSWER_BY, ANSWER_BY + 1.0):
        assert one.step(now) is NextStep.RESET


def test_an_answer_makes_a_new_stop_certain() -> None:
    one = motion()
    stand(one, 0.0, 0.1)
    one.answered(5.0)
    assert one.step(5.0) is NextStep.STOP
    one.stopped(4.9, 5.1)  # it was sent before the answer came, so the motion may be behind it
    assert one.step(5.1) is NextStep.STOP
    stand(one, 5.1, 5.2)
    assert one.step(5.2) is NextStep.DONE


@for_each("outage, watch", [(0.01, MIN_WATCH), (1.0, 1.0), (3.2, 3.2), (30.0, MAX_WATCH)])
def test_after_an_outage_the_arm_is_watched_as_long_as_it_took(outage: float, watch: float) -> None:
    one = motion()
    one.connection_reset(0.0)
    stand(one, 0.0, outage)
    look(one, outage + watch - 0.001)
    assert one.step(outage + watch + 1.0) is NextStep.LOOK
    look(one, outage + watch)
    assert one.step(outage + watch) is NextStep.DONE


def test_an_outage_is_as_long_as_from_the_reset_to_the_stop() -> None:
    one = motion()
    one.connection_reset(10.0)
    stand(one, 10.0, 10.5)
    look(one, 10.9)
    assert one.step(10.9) is NextStep.LOOK
    look(one, 11.1)
    assert one.step(11.1) is NextStep.DONE


def test_the_last_look_begins_after_the_watch() -> None:
    one = motion()
    one.connection_reset(0.0)
    stand(one, 0.0, 1.0)
    one.seen(1.9, 2.1, moving=False)  # it may have been served at 1.9, and the motion at 2.0
    assert one.step(2.1) is NextStep.LOOK


@for_each("more", [0, 1, 5])
def test_an_arm_that_stood_for_two_looks_or_more_and_moves_is_stopped_at_once(more: int) -> None:
    """It is not one that still brakes: the motion has come, however soon after the stop."""
    one = motion()
    one.connection_reset(0.0)
    stand(one, 0.0, 0.1)
    for _ in range(more):
        look(one, 0.15)
    look(one, 0.2, moving=True)
    assert one.step(0.2) is NextStep.STOP
    braking = motion()
    braking.connection_reset(0.0)
    braking.stopped(0.0, 0.1)
    look(braking, 0.1)
    look(braking, 0.2, moving=True)
    assert braking.step(0.2) is NextStep.LOOK


def test_it_shows_what_is_known_of_the_motion_and_the_arm() -> None:
    one = motion()
    assert repr(one) == "<UnansweredMotion open, seen standing 0 times>"
    one.connection_reset(1.0)
    assert "reset" in repr(one)
    one = motion()
    one.answered(1.0)
    stand(one, 1.0, 1.1)
    assert repr(one) == "<UnansweredMotion answered, seen standing 2 times>"


def test_an_arm_that_begins_to_move_in_the_watch_is_stopped_and_watched_anew() -> None:
    one = motion()
    one.connection_reset(0.0)
    stand(one, 0.0, 2.0)
    look(one, 3.0, moving=True)
    assert one.step(3.0) is NextStep.STOP
    stand(one, 3.0, 3.1)
    assert one.step(4.0) is NextStep.LOOK
    look(one, 3.1 + 3.1)
    assert one.step(3.1 + 3.1) is NextStep.DONE


def test_an_arm_that_is_braking_is_left_its_time() -> None:
    one = motion()
    one.answered(0.0)
    one.stopped(0.0, 0.1)
    look(one, 0.2, moving=True)
    assert one.step(0.2) is NextStep.LOOK
    look(one, 0.7, moving=True)
    assert one.step(0.7) is NextStep.STOP


def test_a_controller_that_is_not_heard_is_told_to_stop_again() -> None:
    one = motion()
    one.answered(0.0)
    one.stopped(0.0, 0.1)
    one.poll_failed(0.2, 0.6)
    assert one.step(0.6) is NextStep.STOP


def test_it_is_given_up_when_what_was_tried_after_the_time_has_failed() -> None:
    one = motion()
    one.connection_reset(0.0)
    one.poll_failed(UNTIL - 0.1, UNTIL + 0.1)
    assert one.step(UNTIL + 0.1) is NextStep.STOP
    one.poll_failed(UNTIL + 0.1, UNTIL + 0.2)
    assert one.step(UNTIL + 0.2) is NextStep.GIVE_UP


@for_each("stops", [True, False])
def test_a_program_that_was_suspended_looks_before_it_gives_up(stops: bool) -> None:
    one = UnansweredMotion.none(0.0, 5.0, stops=stops)
    look(one, 0.1, moving=True)
    assert one.step(1000.0) is NextStep.LOOK
    look(one, 1000.0)
    assert one.step(1000.0) is NextStep.LOOK
    look(one, 1000.01)
    assert one.step(1000.01) is NextStep.DONE


@for_each("late", [5.0, 6.0])
def test_an_arm_that_still_moves_after_the_time_is_given_up(late: float) -> None:
    one = UnansweredMotion.none(0.0, 5.0, stops=False)
    look(one, 4.9, moving=True)
    assert one.step(late) is NextStep.LOOK
    look(one, late, moving=True)
    assert one.step(late) is NextStep.GIVE_UP


def test_where_no_stop_is_wanted_none_is_asked_for() -> None:
    one = UnansweredMotion.none(0.0, 5.0, stops=False)
    look(one, 0.1)
    one.poll_failed(0.2, 0.7)
    assert one.step(0.7) is NextStep.LOOK
    look(one, 0.8)
    look(one, 1.4, moving=True)
    assert one.step(1.4) is NextStep.LOOK
    look(one, 1.5)
    look(one, 1.6)
    assert one.step(1.6) is NextStep.DONE


def test_an_arm_that_was_stopped_is_stopped_again_when_it_moves_on() -> None:
    one = UnansweredMotion.none(0.0, 5.0, stops=True)
    look(one, 0.4, moving=True)
    assert one.step(0.4) is NextStep.LOOK
    look(one, 0.6, moving=True)
    assert one.step(0.6) is NextStep.STOP


MOVES = st.sampled_from(
    ["answered", "connection_reset", "stop", "stands", "moves", "unheard", "nothing"]
)


@given(st.lists(st.tuples(MOVES, st.floats(0.0, 4.0)), max_size=60))
def test_it_is_never_done_while_the_motion_may_still_begin(story: list[tuple[str, float]]) -> None:
    """Done: answered and stopped after it, or reset and stopped and watched for long enough."""
    one = motion()
    now = 0.0
    fate: str | None = None
    fate_at = stop_at = disturbed_at = 0.0
    stopped = False
    for what, later in story:
        now += later
        match what:
            case "answered" | "connection_reset" if fate is None:
                getattr(one, what)(now)
                fate, fate_at, stopped = what, now, False
            case "stop":
                one.stopped(now, now)
                stopped, stop_at = True, now
            case "stands":
                look(one, now)
            case "moves":
                look(one, now, moving=True)
                disturbed_at = now
            case "unheard":
                one.poll_failed(now, now)
                disturbed_at = now
        if one.step(now) is NextStep.DONE:
            assert fate is not None
            assert stopped
            assert stop_at >= fate_at
            assert stop_at >= disturbed_at or what != "unheard"
            if fate == "connection_reset":
                assert now - stop_at >= min(max(stop_at - fate_at, MIN_WATCH), MAX_WATCH)
            return
