"""The states of a stream, the changes between them, and what is sent in each."""

from __future__ import annotations

import itertools
import math

import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.streaming.shared.ring import SetPoint
from aioduco.streaming.shared.space import JOINT_SPACE, Config, Limits
from aioduco.streaming.shared.words import Reason, StreamState
from aioduco.streaming.worker.limiter import SpeedGenerator
from aioduco.streaming.worker.setpoints import PositionGenerator, SetpointSource

PERIOD = 0.01
HOLD = 0.1
ZERO = (0.0,) * 6
LIMITS = Limits((1.0,) * 6, (10.0,) * 6)


class Bench:
    """A source, what it is fed with, and what it gave."""

    def __init__(
        self,
        *,
        speeds: bool = False,
        paced: bool = True,
        way: str = "none",
        interval: float = PERIOD,
    ) -> None:
        self.source = SetpointSource(
            JOINT_SPACE,
            PERIOD,
            hold=HOLD,
            interval=interval if paced else None,
            paced=paced,
            reach=(0.1,) * 6,
            speeds=speeds,
        )
        generator = (
            SpeedGenerator(JOINT_SPACE, LIMITS, PERIOD)
            if speeds
            else PositionGenerator(way, JOINT_SPACE, LIMITS, PERIOD, ZERO)
        )
        self.source.begin(generator)
        self.fed: list[Config] = []
        self.given: list[Config | None] = []
        self._number = 0

    def take(self) -> SetPoint | None:
        if not self.fed:
            return None
        self._number += 1
        return SetPoint(self._number, self._number * round(PERIOD * 1e9), self.fed.pop(0), b"")

    def step(self, *points: float, ticks: int = 1, passed: int = 1) -> StreamState:
        self.fed += [(value,) * 6 for value in points]
        for _ in range(max(ticks, len(points))):
            self.given.append(self.source.step(self.take, passed))
        return self.source.state

    @property
    def last(self) -> Config:
        return next(point for point in reversed(self.given) if point is not None)

    def to_the_end(self) -> None:
        for _ in range(10_000):
            if self.step() is StreamState.ENDED:
                return
        raise AssertionError(f"not ended: {self.source.state}")


def test_nothing_is_sent_before_the_first_set_point() -> None:
    bench = Bench()
    assert bench.step(ticks=50) is StreamState.WAITING
    assert bench.given == [None] * 50


def test_set_points_pass_in_order_one_per_tick() -> None:
    bench = Bench()
    ramp = [0.0005 * n * n for n in range(8)]
    assert bench.step(*ramp) is StreamState.FOLLOWING
    assert bench.given == [(value,) * 6 for value in ramp]


@pytest.mark.cases(4)
@pytest.mark.parametrize("way", ["none", "linear", "cubic", "speeds"])
@pytest.mark.parametrize("ticks", [5 / 3, 6.65, 4.0])
def test_each_target_has_its_time_also_if_that_is_no_whole_number_of_ticks(
    way: str, ticks: float
) -> None:
    speeds = way == "speeds"
    bench = Bench(speeds=speeds, way="none" if speeds else way, interval=ticks * PERIOD)
    bench.fed = [(0.001 * number,) * 6 for number in range(40)]
    taken: list[int] = []
    while bench.fed:
        before = len(bench.fed)
        bench.step()
        taken += [len(bench.given) - 1] * (before - len(bench.fed))
    assert all(abs(tick - number * ticks) < 1 for number, tick in enumerate(taken))
    if way == "linear":  # at the speed of the targets throughout
        places = [place[0] for place in bench.given if place is not None]
        steps = [there - here for here, there in itertools.pairwise(places[2 * taken[1] :])]
        assert steps == pytest.approx([0.001 / ticks] * len(steps))


def test_a_first_set_point_too_far_ends_and_nothing_is_sent() -> None:
    bench = Bench()
    assert bench.step(0.11) is StreamState.ENDED
    assert bench.source.reason is Reason.TOO_FAR
    assert bench.source.text == "joint 1: 0.11 rad away, where 0.1 rad are allowed"
    assert bench.given == [None]


def test_late_set_points_lead_to_holding_and_back() -> None:
    bench = Bench()
    bench.step(0.0, 0.001, 0.002)
    assert bench.step(ticks=5) is StreamState.HOLDING
    assert 1 <= bench.source.starved < 5
    assert bench.last == (0.002,) * 6
    assert bench.step(0.003) is StreamState.FOLLOWING
    assert bench.source.reason is Reason.NONE


def test_starving_longer_than_the_hold_time_decelerates_and_ends() -> None:
    bench = Bench()
    bench.step(*[0.005 * n for n in range(20)])
    seen = [bench.step() for _ in range(12)]
    assert StreamState.HOLDING in seen
    assert bench.source.reason is Reason.STARVED
    bench.to_the_end()
    assert bench.given[-1] is None or bench.given[-1] == bench.last
    assert bench.source.reason is Reason.STARVED


@for_each("paced", [False, True])
def test_the_hold_is_as_long_on_a_slow_connection(paced: bool) -> None:
    numbers = []
    for passed in (1, 5):
        bench = Bench(paced=paced)
        bench.step(*[0.002 * n for n in range(20)])
        begun = len(bench.given)
        while bench.source.reason is Reason.NONE:
            bench.step(passed=passed)
        numbers.append(len(bench.given) - begun)
    assert numbers[1] <= numbers[0] / 5 + 1


def test_set_points_that_wait_for_their_turn_are_no_silence_on_a_slow_connection() -> None:
    bench = Bench(way="linear", interval=10 * PERIOD)
    bench.fed = [(0.002 * n,) * 6 for n in range(30)]
    while bench.fed:
        assert bench.step(passed=5) in {StreamState.FOLLOWING, StreamState.WAITING}


@for_each("way", ["none", "linear", "cubic"])
def test_closing_follows_what_was_sent_to_its_end(way: str) -> None:
    bench = Bench(way=way)
    bench.fed = [(0.002 * n,) * 6 for n in range(30)]
    bench.source.close()
    bench.to_the_end()
    assert bench.source.reason is Reason.CLOSED
    assert bench.last == (0.002 * 29,) * 6


def test_closing_before_the_first_set_point_ends_at_once() -> None:
    bench = Bench()
    bench.source.close()
    assert bench.step() is StreamState.ENDED
    assert bench.source.reason is Reason.CLOSED
    assert bench.given == [None]


@for_each("speeds", [False, True])
def test_braking_takes_as_long_on_a_slow_connection(speeds: bool) -> None:
    numbers = []
    for passed in (1, 5):
        bench = Bench(speeds=speeds)
        bench.step(*[(0.095 if speeds else 0.01) * n for n in range(60)])
        bench.source.brake(Reason.ABORTED)
        begun = len(bench.given)
        while bench.source.state is not StreamState.ENDED:
            bench.step(passed=passed)
        numbers.append(len(bench.given) - begun)
    assert numbers[0] > 8
    assert numbers[1] <= numbers[0] / 5 + 1


def test_braking_takes_nothing_more_and_comes_to_rest_within_the_limits() -> None:
    bench = Bench()
    bench.step(*[0.0005 * n * n for n in range(10)])
    speed = 0.0085 / PERIOD
    bench.fed = [(1.0,) * 6] * 10
    bench.source.brake(Reason.PROGRAM_DIED)
    bench.to_the_end()
    assert bench.source.reason is Reason.PROGRAM_DIED
    assert len(bench.fed) == 10
    places = [point[0] for point in bench.given if point is not None]
    steps = [b - a for a, b in itertools.pairwise(places)]
    changes = [abs(b - a) / PERIOD**2 for a, b in itertools.pairwise(steps)]
    assert max(changes) <= 10.0 * (1 + 1e-6)
    assert steps[-1] == 0
    assert len(places) - 10 == pytest.approx(speed / 10.0 / PERIOD, abs=1.5)


def test_ending_sends_nothing_more_at_once() -> None:
    bench = Bench()
    bench.step(0.0, 0.001, 0.002)
    bench.source.end(Reason.STOPPED)
    bench.step(0.003, 0.004)
    assert bench.given[3:] == [None, None]
    assert bench.source.reason is Reason.STOPPED


def test_a_stream_of_speeds_keeps_its_speed_then_ramps_to_zero() -> None:
    bench = Bench(speeds=True)
    bench.step(*[0.5] * 10)
    assert bench.last == (0.5,) * 6
    assert bench.step(ticks=5) is StreamState.HOLDING
    assert bench.last == (0.5,) * 6
    bench.to_the_end()
    assert bench.source.reason is Reason.STARVED
    assert bench.last == ZERO
    speeds = [point[0] for point in bench.given if point is not None]
    assert max(abs(b - a) for a, b in itertools.pairwise(speeds)) <= 10.0 * PERIOD + 1e-9


def test_a_stream_of_speeds_ends_at_zero_when_closed() -> None:
    bench = Bench(speeds=True)
    bench.step(*[0.5] * 10)
    bench.source.close()
    bench.to_the_end()
    assert bench.source.reason is Reason.CLOSED
    assert bench.last == ZERO


EVENTS = st.lists(
    st.one_of(st.floats(-0.3, 0.3), st.sampled_from(["tick", "close", "starve", "brake", "end"])),
    max_size=60,
)


@given(EVENTS, st.booleans(), st.booleans(), st.sampled_from(["none", "linear", "cubic", "ruckig"]))
def test_whatever_happens_limits_hold_and_the_end_is_final(
    events: list[float | str], speeds: bool, paced: bool, way: str
) -> None:
    bench = Bench(speeds=speeds, paced=paced, way="none")
    if not speeds and way == "ruckig":
        limits = Limits((1.0,) * 6, (10.0,) * 6, (100.0,) * 6)
        bench.source.begin(PositionGenerator(way, JOINT_SPACE, limits, PERIOD, ZERO))
    ended_at: int | None = None
    for event in events:
        match event:
            case float():
                bench.step(event)
            case "tick":
                bench.step()
            case "starve":
                bench.step(ticks=12)
            case "close":
                bench.source.close()
            case "brake":
                bench.source.brake(Reason.ABORTED)
            case "end":
                bench.source.end(Reason.STOPPED)
        if ended_at is None and bench.source.state is StreamState.ENDED:
            ended_at = len(bench.given)
    if ended_at is not None:
        assert all(point is None for point in bench.given[ended_at:])
        assert bench.source.reason is not Reason.NONE
    points = [ZERO, *(point for point in bench.given if point is not None)]
    for before, after in itertools.pairwise(points):
        for a, b in zip(before, after, strict=True):
            assert math.isfinite(b)
            # a speed of 1 per second at most, or for speeds a change of 10 per second
            assert abs(b - a) <= (10.0 if speeds else 1.0) * PERIOD * (1 + 1e-6)


def test_the_first_reason_and_its_text_stay() -> None:
    bench = Bench()
    bench.step(0.01, 0.02)
    bench.source.brake(Reason.ENVELOPE, "first")
    bench.source.brake(Reason.FAILED, "second")
    bench.source.end(Reason.REFUSED, "third")
    assert (bench.source.reason, bench.source.text) == (Reason.ENVELOPE, "first")
    assert bench.source.state is StreamState.ENDED
