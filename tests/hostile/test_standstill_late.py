"""A program that was held up reads the arm's state before it reports that the arm moves."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, cast

import anyio
import pytest
from supervision.test_absolute_schedule import Clock

from aioduco._wire.lane import WireLane
from aioduco._wire.owner_loop import OwnerLoop
from aioduco.errors import ConnectionLost, StopUnconfirmed
from aioduco.supervision import concurrency, rest
from aioduco.supervision import stop_channel as control
from aioduco.supervision.stop_channel import StopChannel


class AcceptedStop:
    """A call of a stop."""

    async def answer(self) -> int:
        return 1


class Watch:
    """A lane that answers from a script, and keeps the limits that it was given."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.script: deque[Callable[[], bool]] = deque()
        self.standing = False
        self.limits: list[float] = []
        self.owner_loop = OwnerLoop()

    def prepare(self, name: str, args: tuple[Any, ...], timeout: float) -> AcceptedStop:
        assert name == "stop"
        return AcceptedStop()

    def send(self, call: AcceptedStop) -> None:
        """Send nothing: it is accepted."""

    async def call(self, name: str, args: tuple[Any, ...], timeout: float) -> Any:
        self.limits.append(timeout)
        self.clock.now += 0.001
        if self.script:
            return self.script.popleft()()
        return not self.standing


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(control, "time", clock)
    monkeypatch.setattr(concurrency, "time", clock)
    monkeypatch.setattr(rest, "time", clock)
    monkeypatch.setattr(anyio, "sleep", clock.sleep)
    return clock


@pytest.fixture
def watch(clock: Clock) -> Watch:
    return Watch(clock)


@pytest.fixture
def arm(watch: Watch) -> StopChannel:
    lane = cast("WireLane", watch)
    return StopChannel(lane, lane, lane)


def held_up(clock: Clock, seconds: float, moving: bool) -> Callable[[], bool]:
    """An answer that comes while the loop is blocked."""

    def answer() -> bool:
        clock.now += seconds
        return moving

    return answer


async def test_an_arm_that_stands_is_seen_to_after_the_loop_was_blocked(
    clock: Clock, watch: Watch, arm: StopChannel
) -> None:
    watch.standing = True
    watch.script.append(held_up(clock, 30.0, moving=True))
    await arm.rest(stop_timeout=1.0, timeout=5.0)
    assert min(watch.limits) > 0.0


@pytest.mark.parametrize("moving", [True, False])
async def test_the_last_answer_before_a_hold_up_does_not_decide(
    clock: Clock, watch: Watch, arm: StopChannel, moving: bool
) -> None:
    watch.standing = True
    watch.script.append(held_up(clock, 3.0, moving=moving))
    await arm.rest(None, 1.0)


@pytest.mark.parametrize("left", [0.0, -1.02])
async def test_without_any_time_left_the_arm_is_asked_with_a_real_limit(
    watch: Watch, arm: StopChannel, left: float
) -> None:
    watch.standing = True
    await arm.rest(None, left)
    await arm.rest(1.0, left)
    assert min(watch.limits) >= 0.1


@pytest.mark.parametrize("left", [5.0, 0.3, 0.0, -1.02])
async def test_an_arm_that_moves_is_said_to_with_a_time_that_is_true(
    watch: Watch, arm: StopChannel, left: float
) -> None:
    with pytest.raises(StopUnconfirmed, match=r"still moves after \d") as caught:
        await arm.rest(1.0, left)
    assert "-" not in str(caught.value).split("the arm may")[0]
    assert min(watch.limits) > 0.0


async def test_a_silent_controller_is_asked_once_more_after_the_time_is_over(
    clock: Clock, watch: Watch, arm: StopChannel
) -> None:
    def silent() -> bool:
        clock.now += watch.limits[-1]
        raise ConnectionLost("no answer")

    watch.script.extend([silent] * 100)
    begin = clock.now
    with pytest.raises(StopUnconfirmed, match=r"nothing was heard of the arm for \d"):
        await arm.rest(None, 1.0)
    assert watch.limits[-1] >= 0.1
    assert clock.now - begin <= 1.0 + 0.5


async def test_an_arm_that_begins_to_stand_with_the_last_answer_is_asked_on(
    clock: Clock, watch: Watch, arm: StopChannel
) -> None:
    watch.script.extend([lambda: True, held_up(clock, 2.0, moving=True), lambda: False])
    watch.standing = True
    await arm.rest(None, 1.0)


async def test_where_no_further_stop_is_accepted_that_is_said(
    clock: Clock, watch: Watch, arm: StopChannel, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def unconfirmed(timeout: float) -> None:
        clock.now += timeout
        raise StopUnconfirmed("no stop was accepted")

    monkeypatch.setattr(arm, "stop", unconfirmed)
    watch.script.extend([held_up(clock, 0.3, moving=True)] * 2)
    begin = clock.now
    with pytest.raises(StopUnconfirmed, match="no stop was accepted"):
        await arm.rest(stop_timeout=1.0, timeout=5.0)
    assert 5.0 <= clock.now - begin < 6.0
