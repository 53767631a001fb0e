"""From a low rate to the stream's rate: smooth, within limits, and to the target."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aioduco.streaming.shared.options import UPSAMPLING
from aioduco.streaming.shared.space import JOINT_SPACE, Config, Limits
from aioduco.streaming.worker.interpolation import Cubic, interpolator
from aioduco.streaming.worker.setpoints import PositionGenerator

from .motion import peaks

PERIOD = 0.002
SLOW = 1 / 30
LIMITS = Limits((2.0,) * 6, (15.0,) * 6, (300.0,) * 6)
ZERO = (0.0,) * 6


def policy(time: float) -> Config:
    """A motion as a learned policy gives it, from rest."""
    return tuple(0.1 * (axis + 1) * (1 - math.cos(3 * time)) / 2 for axis in range(6))


def bare_steps(seconds: float) -> list[Config]:
    """What the controller gets when the 30 Hz targets are sent as they are, at 500 Hz."""
    ticks = round(seconds / PERIOD)
    return [policy(math.floor(tick * PERIOD / SLOW) * SLOW) for tick in range(ticks)]


def followed(way: str, seconds: float, jitter: float = 0.0) -> list[Config]:
    generator = PositionGenerator(way, JOINT_SPACE, LIMITS, PERIOD, policy(0.0))
    points = [generator.config]
    number, before = 0, 0.0
    for tick in range(round(seconds / PERIOD)):
        time = tick * PERIOD
        late = jitter * SLOW * ((number * 7919) % 11 / 10)
        if time >= number * SLOW + late:
            generator.aim(policy(time), max(PERIOD, time - before), 1.2 * SLOW)
            number, before = number + 1, time
        points.append(generator.step())
    return points


@pytest.mark.parametrize("way", ["cubic", "ruckig"])
@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_acceleration_is_at_most_a_fifth_of_the_bare_steps(way: str, jitter: float) -> None:
    bare = peaks(JOINT_SPACE, bare_steps(4.0), PERIOD)
    found = peaks(JOINT_SPACE, followed(way, 4.0, jitter), PERIOD)
    assert max(found.acceleration) <= max(bare.acceleration) / 5


@pytest.mark.cases(1)
@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_ruckig_keeps_the_limit_of_jerk(jitter: float) -> None:
    found = peaks(JOINT_SPACE, followed("ruckig", 4.0, jitter), PERIOD)
    assert max(found.jerk) <= 300.0 * (1 + 1e-3)


@pytest.mark.cases(1)
@pytest.mark.parametrize("way", ["linear", "cubic", "ruckig"])
def test_the_motion_is_followed_one_interval_later(way: str) -> None:
    points = followed(way, 4.0)
    lag = 1.2 * SLOW
    errors = [
        max(abs(a - b) for a, b in zip(points[tick], policy(tick * PERIOD - lag), strict=True))
        for tick in range(100, len(points))
    ]
    # 5 % of the amplitude of the fastest joint
    assert max(errors) <= 0.05 * 0.6


@pytest.mark.cases(1)
@pytest.mark.parametrize("way", UPSAMPLING)
@given(targets=st.lists(st.tuples(*[st.floats(-1, 1)] * 6), min_size=1, max_size=8))
@settings(deadline=None)
def test_every_way_ends_at_rest_at_the_last_target(way: str, targets: list[Config]) -> None:
    generator = PositionGenerator(way, JOINT_SPACE, LIMITS, PERIOD, ZERO)
    for target in targets:
        generator.aim(target, SLOW, SLOW)
        for _ in range(10):
            generator.step()
    for _ in range(3000):
        if generator.at_rest:
            break
        generator.step()
    assert generator.at_rest
    assert generator.config == targets[-1]
    assert generator._limiter.velocity == ZERO


@pytest.mark.parametrize("way", UPSAMPLING)
@given(target=st.tuples(*[st.floats(-1, 1)] * 6), ticks=st.integers(1, 200))
@settings(deadline=None)
def test_every_way_brakes_to_rest_where_it_is(way: str, target: Config, ticks: int) -> None:
    generator = PositionGenerator(way, JOINT_SPACE, LIMITS, PERIOD, ZERO)
    generator.aim(target, SLOW, SLOW)
    points = [generator.step() for _ in range(ticks)]
    speed = max(map(abs, generator._limiter.velocity))
    start = generator.config
    count = 0
    while not generator.at_rest or not count:
        points.append(generator.brake())
        count += 1
        assert count * PERIOD <= 2.0 / 15.0 + 15.0 / 300.0 * 3 + 2 * PERIOD
    found = peaks(JOINT_SPACE, [ZERO, *points], PERIOD)
    assert max(found.acceleration) <= 15.0 * (1 + 1e-6)
    # The way to rest: v²/2a, and what the limit of jerk adds.
    furthest = speed * speed / 30 + 0.2 * speed + 0.01
    assert max(abs(a - b) for a, b in zip(start, generator.config, strict=True)) <= furthest


@given(step=st.floats(-1, 1))
def test_a_single_step_is_not_overshot(step: float) -> None:
    for way in ("none", "linear", "cubic"):
        reference = interpolator(way, JOINT_SPACE, PERIOD, ZERO)
        target = (step,) * 6
        for _ in range(5):
            reference.aim(target, SLOW, SLOW)
            places = [reference.step()[0] for _ in range(17)]
            assert all(min(0, step) - 1e-12 <= p <= max(0, step) + 1e-12 for p in places)


@given(
    targets=st.lists(st.tuples(*[st.floats(-1, 1)] * 6), min_size=2, max_size=8),
    ticks=st.integers(1, 25),
)
def test_a_cubic_has_no_step_in_place_or_velocity(targets: list[Config], ticks: int) -> None:
    reference = Cubic(JOINT_SPACE, PERIOD, ZERO)
    places: list[Config] = [ZERO]
    for target in targets:
        reference.aim(target, SLOW, SLOW)
        places += [reference.step() for _ in range(ticks)]
    found = peaks(JOINT_SPACE, places, PERIOD)
    # A curve over 34 ms changes its velocity by no more than this much per tick, wherever it is
    # cut off; a step in place or velocity would show as one of 500/s, or 1000 times as much.
    assert max(found.velocity) <= 20 * 2 / SLOW
    if ticks < 17:
        assert max(found.acceleration) <= 60 * 2 / SLOW**2
