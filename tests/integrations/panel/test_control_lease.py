"""Who commands the arm, and for how long: the state machine."""

from __future__ import annotations

import hmac

import pytest
from for_each import for_each
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from aioduco.integrations.panel.control_lease import (
    BeginLease,
    BeginMotion,
    ControlLease,
    EndLease,
    EndMotion,
    LeaseEffect,
    LeasePhase,
    RefusePage,
)
from aioduco.integrations.panel.page_requests import JogMotion
from aioduco.models.jog import Jog

TOKEN = "correct horse battery"
HOLD, PAGE = 0.4, 3.0
JOG = JogMotion(Jog.joint(1, 1, 10))


def lease(token: str = TOKEN) -> ControlLease:
    return ControlLease(token, hold_limit=HOLD, page_limit=PAGE)


def commanded(page: int = 1) -> ControlLease:
    """A lease that a page holds at the time 0."""
    made = lease()
    assert made.take(page, TOKEN, 0.0) == BeginLease(page)
    made.opened()
    return made


@for_each("token", ["", "correct horse", TOKEN + " ", "König", "\ud800"])
def test_a_wrong_token_gets_nothing_and_is_shown_nowhere(token: str) -> None:
    made = lease()
    refused = made.take(1, token, 0.0)
    assert isinstance(refused, RefusePage)
    assert refused.wrong_token
    assert (made.phase, made.holder) == (LeasePhase.FREE, None)
    assert TOKEN not in f"{made!r} {refused!r}"
    assert not token or token not in refused.reason


def test_tokens_are_compared_in_constant_time(monkeypatch: pytest.MonkeyPatch) -> None:
    compared: list[tuple[bytes, bytes]] = []

    def compare(one: bytes, other: bytes) -> bool:
        compared.append((one, other))
        return False

    monkeypatch.setattr(hmac, "compare_digest", compare)
    # no other way lets in: not even the right token does
    assert isinstance(lease().take(1, TOKEN, 0.0), RefusePage)
    assert compared == [(TOKEN.encode(), TOKEN.encode())]


def test_without_a_token_nobody_commands() -> None:
    refused = lease("").take(1, "", 0.0)
    assert refused == RefusePage(1, "this panel only watches")


def test_one_page_commands_at_a_time() -> None:
    made = lease()
    assert made.take(1, TOKEN, 0.0) == BeginLease(1)
    assert made.press(1, JOG, 0.0, 0.0) == RefusePage(1, "the robot is still being opened")
    made.opened()
    assert made.take(2, TOKEN, 0.0) == RefusePage(2, "another page commands")
    assert isinstance(made.press(2, JOG, 0.0, 0.0), RefusePage)
    assert made.press(1, JOG, 0.0, 0.0) == BeginMotion(JOG)
    assert isinstance(made.press(1, JOG, 0.0, 0.0), RefusePage), "one motion at a time"
    assert made.button_released(2) is None
    assert made.beat(2, 9.0, 9.0, down=False) is None
    assert made.release(2) is None
    assert made.button_released(1) == EndMotion()
    assert made.button_released(1) is None
    assert isinstance(made.press(1, JOG, 0.0, 0.0), RefusePage), "its end is not seen yet"
    made.motion_ended()
    assert made.press(1, JOG, 0.0, 0.0) == BeginMotion(JOG)
    assert made.release(1, "its page is gone") == EndLease("its page is gone")
    assert isinstance(made.take(2, TOKEN, 0.0), RefusePage), "it is not seen through yet"
    made.closed()
    assert made.take(2, TOKEN, 0.0) == BeginLease(2)


@for_each(
    "beats, at, ends",
    [
        # (number of seconds at which what the page saw was sent, and at which it says so)
        ([], 0.4, False),
        ([], 0.41, True),
        ([(0.3, 0.35)], 0.69, False),
        ([(0.3, 0.35)], 0.71, True),
        # keep-alives that are late are none: they tell of what was sent long ago
        ([(0.0, 0.1), (0.0, 0.2), (0.0, 0.3), (0.0, 0.4)], 0.45, True),
        ([(0.1, 0.6), (0.2, 0.6), (0.3, 0.6)], 0.69, False),
        ([(0.1, 0.6), (0.2, 0.6), (0.3, 0.6)], 0.71, True),
    ],
)
def test_a_hold_lives_on_what_its_page_has_seen(
    beats: list[tuple[float, float]], at: float, ends: bool
) -> None:
    made = commanded()
    assert made.press(1, JOG, 0.0, 0.0) == BeginMotion(JOG)
    for seen, now in beats:
        assert made.beat(1, seen, now, down=True) is None
    effect = made.due(at)
    assert isinstance(effect, EndMotion) is ends
    if isinstance(effect, EndMotion):
        assert "silent or late" in effect.reason
        assert made.beat(1, at, at, down=True) is None, "a beat alone starts nothing"
        assert made.due(at) is None, "it ends once"


def test_a_page_that_shows_what_is_old_does_not_move_the_arm() -> None:
    made = commanded()
    refused = made.press(1, JOG, 1.0, 1.0 + HOLD + 0.01)
    assert refused == RefusePage(1, "what this page shows is too old to move by")
    assert made.motion is None


def test_a_silent_page_loses_the_lease() -> None:
    made = commanded()
    made.beat(1, 0.0, 2.0, down=False)
    assert made.due(2.0 + PAGE) is None
    assert made.due(2.0 + PAGE + 0.01) == EndLease("its page was silent")
    assert (made.phase, made.holder) == (LeasePhase.ENDING, None)


def test_a_lease_that_is_lost_while_it_opens_is_not_opened() -> None:
    made = lease()
    made.take(1, TOKEN, 0.0)
    assert isinstance(made.release(1), EndLease)
    made.opened()
    assert made.phase.value == "ending"
    made.closed()
    assert made.phase.value == "free"


def test_a_stop_ends_what_is_held_and_nothing_starts_until_it_is_through() -> None:
    made = commanded()
    made.press(1, JOG, 0.0, 0.0)
    assert made.stop() == EndMotion("the arm was stopped")
    assert made.stop() is None
    made.motion_ended()
    made.stop_ended()
    assert made.press(1, JOG, 0.0, 0.0) == RefusePage(1, "the arm is being stopped")
    made.stop_ended()
    assert made.press(1, JOG, 0.0, 0.0) == BeginMotion(JOG)


def test_the_end_of_a_lease_is_the_end_of_its_motion_which_is_told_once() -> None:
    made = commanded()
    made.press(1, JOG, 0.0, 0.0)
    assert isinstance(made.release(1), EndLease)
    assert made.due(60.0) is None
    assert made.stop() is None


class Pages(RuleBasedStateMachine):
    """Three pages, the arm and the time, in any order: what is moved is always someone's."""

    def __init__(self) -> None:
        super().__init__()
        self.lease = lease()
        self.now = 0.0
        self.opening = False
        self.ending = False
        self.moving = False
        self.told_to_end = False
        self.stops = 0
        self.pressed = False

    def saw(self, effect: LeaseEffect | None) -> None:
        if isinstance(effect, BeginLease):
            assert not self.opening
            assert not self.ending
            self.opening = True
        elif isinstance(effect, EndLease):
            self.ending = self.told_to_end = True
        elif isinstance(effect, BeginMotion):
            assert not self.moving
            assert self.stops == 0
            self.moving, self.told_to_end = True, False
        elif isinstance(effect, EndMotion):
            assert self.moving
            assert not self.told_to_end
            self.told_to_end = True

    page = st.integers(1, 3)

    @rule(page=page, right=st.booleans())
    def take(self, page: int, right: bool) -> None:
        effect = self.lease.take(page, TOKEN if right else "wrong", self.now)
        assert right or not isinstance(effect, BeginLease)
        self.saw(effect)

    @rule(page=page, age=st.floats(0, 2))
    def press(self, page: int, age: float) -> None:
        effect = self.lease.press(page, JOG, self.now - age, self.now)
        if isinstance(effect, BeginMotion):
            assert page == self.lease.holder
            assert age <= HOLD
        self.saw(effect)

    @rule(page=page, age=st.floats(0, 2), down=st.booleans())
    def beat(self, page: int, age: float, down: bool) -> None:
        self.saw(self.lease.beat(page, self.now - age, self.now, down=down))

    @rule(page=page)
    def button_released(self, page: int) -> None:
        self.saw(self.lease.button_released(page))

    @rule(page=page)
    def leave(self, page: int) -> None:
        self.saw(self.lease.release(page, "gone"))

    @rule()
    def opened(self) -> None:
        if self.opening:
            self.lease.opened()

    @rule()
    def closed(self) -> None:
        if self.opening and self.ending:
            self.lease.closed()
            self.opening = self.ending = self.moving = self.told_to_end = False

    @rule()
    def motion_ended(self) -> None:
        if self.moving:
            self.lease.motion_ended()
            self.moving = self.told_to_end = False

    @rule()
    def stop(self) -> None:
        self.stops += 1
        self.saw(self.lease.stop())
        assert not self.moving or self.told_to_end

    @rule()
    def stop_ended(self) -> None:
        if self.stops:
            self.stops -= 1
            self.lease.stop_ended()

    @rule(seconds=st.floats(0, 5))
    def pass_time(self, seconds: float) -> None:
        self.now += seconds
        effect = self.lease.due(self.now)
        self.saw(effect)
        if seconds > HOLD and self.moving and isinstance(effect, EndMotion | EndLease | None):
            assert self.told_to_end

    @invariant()
    def what_moves_is_someones(self) -> None:
        if self.moving and not self.told_to_end:
            assert self.lease.holder is not None
            assert self.lease.phase is LeasePhase.HELD


TestPages = Pages.TestCase
