"""No set-point exceeds the limits, whatever the targets are; what is within them passes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aioduco.streaming.shared.space import JOINT_SPACE, POSE_SPACE, Config, Limits, Space
from aioduco.streaming.worker.limiter import JerkLimiter, Limiter, SpeedGenerator

from .motion import peaks

AMOUNT = st.floats(0.1, 5.0)
PERIOD = st.sampled_from([0.001, 0.002, 0.008, 0.033])
ANGLE = st.floats(-3.0, 3.0)
#: targets that jump, each held for some ticks
JUMPS = st.lists(st.tuples(st.tuples(*[ANGLE] * 6), st.integers(1, 40)), min_size=1, max_size=12)
SPACES: list[Space] = [JOINT_SPACE, POSE_SPACE]
ROUNDING = 1 + 1e-6


def limits(space: Space, velocity: float, acceleration: float, jerk: float) -> Limits:
    groups = len(space.groups)
    return Limits((velocity,) * groups, (acceleration,) * groups, (jerk,) * groups)


def run(
    step: Callable[[Config], Config], space: Space, jumps: object, start: Config
) -> list[Config]:
    points = [start]
    for values, ticks in jumps:  # type: ignore[attr-defined]  # hypothesis draws a list of pairs
        target = space.decode(values)
        points += [step(target) for _ in range(ticks)]
    return points


@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize("kind", [Limiter, JerkLimiter])
@given(velocity=AMOUNT, sharpness=st.floats(2, 40), period=PERIOD, jumps=JUMPS)
def test_velocity_acceleration_and_jerk_are_never_exceeded(
    kind: Any, space: Space, velocity: float, sharpness: float, period: float, jumps: object
) -> None:
    acceleration, jerk = velocity * sharpness, velocity * sharpness * 10
    start = space.decode((0.0,) * 6)
    limiter = kind(space, limits(space, velocity, acceleration, jerk), period, start)
    points = run(limiter.follow, space, jumps, start)
    for _ in range(100_000):
        if not any(limiter.velocity):
            break
        points.append(limiter.brake())
    assert not any(limiter.velocity)
    found = peaks(space, points, period)
    # The rotation of a pose is read back from a quaternion, whose rounding counts twice.
    noise = 1e-12 / period ** (2 if kind is Limiter else 3)
    assert max(found.velocity) <= velocity * ROUNDING + noise
    assert max(found.acceleration) <= acceleration * ROUNDING + noise
    assert kind is Limiter or max(found.jerk) <= jerk * ROUNDING + 1e-3 * jerk + noise


@given(velocity=AMOUNT, sharpness=st.floats(2, 40), period=PERIOD, target=st.tuples(*[ANGLE] * 6))
def test_a_standing_target_is_met_exactly_in_about_the_least_time(
    velocity: float, sharpness: float, period: float, target: Config
) -> None:
    acceleration = velocity * sharpness
    limiter = Limiter(
        JOINT_SPACE, limits(JOINT_SPACE, velocity, acceleration, 1.0), period, (0.0,) * 6
    )
    way = max(map(abs, target))
    ramp = velocity / acceleration
    least = way / velocity + ramp if way > velocity * ramp else 2 * math.sqrt(way / acceleration)
    ticks = 0
    while not (ticks and limiter.at_rest):
        limiter.follow(target)
        ticks += 1
        assert ticks * period <= 1.3 * least + 20 * period
    assert limiter.config == target


@given(
    period=PERIOD,
    amplitudes=st.tuples(*[st.floats(-1, 1)] * 6),
    frequency=st.floats(0.05, 1.0),
)
def test_a_motion_within_the_limits_passes_unchanged(
    period: float, amplitudes: tuple[float, ...], frequency: float
) -> None:
    turn = 2 * math.pi * frequency
    bound = Limits((turn,) * 6, (turn * turn + 1e-6,) * 6)
    limiter = Limiter(JOINT_SPACE, bound, period, (0.0,) * 6)
    for tick in range(200):
        # From rest: 1 - cos has neither a speed nor a step at its begin.
        share = (1 - math.cos(turn * tick * period)) / 2
        target = tuple(a * share for a in amplitudes)
        assert limiter.follow(target) == target
    assert limiter.limited == 0


@given(jumps=JUMPS, top=AMOUNT, change=AMOUNT, period=PERIOD)
def test_speeds_are_ramped_and_end_at_zero(
    jumps: object, top: float, change: float, period: float
) -> None:
    rates = SpeedGenerator(POSE_SPACE, Limits((top, top), (change, change)), period)
    before = rates.config
    for values, ticks in jumps:  # type: ignore[attr-defined]
        rates.aim(values, period, period)
        for _ in range(ticks):
            now = rates.step()
            for group in POSE_SPACE.groups:
                assert math.hypot(*now[group]) <= top * ROUNDING
                step = math.dist(now[group], before[group])
                assert step <= change * period * ROUNDING + 1e-12
            before = now
    limit = top / change / period + 2
    ticks = 0
    while not rates.at_rest:
        now = rates.brake()
        assert math.dist(now[:3], before[:3]) <= change * period * ROUNDING + 1e-12
        before = now
        ticks += 1
        assert ticks <= limit
    assert before == (0.0,) * 6
