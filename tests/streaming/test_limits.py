"""No set-point exceeds the limits, whatever the targets are; what is within them passes."""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import anyio
import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st
from wire.servers import PATIENCE, Peer, ScriptedServer

from aioduco._wire.endpoint import Endpoint
from aioduco._wire.own_connection import OwnConnection
from aioduco.api.streams.servo import Servo
from aioduco.api.streams.speed import Speed
from aioduco.errors import ParameterError, StreamRefused, StreamStarved
from aioduco.streaming.shared.space import JOINT_SPACE, POSE_SPACE, Config, Limits, Space
from aioduco.streaming.shared.words import StreamState
from aioduco.streaming.worker.limiter import JerkLimiter, Limiter, SpeedGenerator
from aioduco.streaming.worker.rest import bring_to_rest
from aioduco.supervision.unanswered import UnansweredMotion
from aioduco.testing import Delay, FaultProxy, eventually_async

from .conftest import HERE, THREAD, UNWATCHED, Controller, fed
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


@given(velocity=AMOUNT, sharpness=st.floats(2, 40), period=PERIOD, times=st.tuples(*[ANGLE] * 6))
def test_a_standing_target_is_met_exactly_in_about_the_least_time(
    velocity: float, sharpness: float, period: float, times: Config
) -> None:
    target = tuple(time * min(velocity, 2.0) for time in times)  # some seconds away, not minutes
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


@given(period=PERIOD, amplitudes=st.tuples(*[st.floats(-1, 1)] * 6), frequency=st.floats(0.05, 1.0))
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
        for passed in range(1, ticks + 1):  # as on a connection that gets slower
            now = rates.step(passed)
            for group in POSE_SPACE.groups:
                assert math.hypot(*now[group]) <= top * ROUNDING
                step = math.dist(now[group], before[group])
                assert step <= change * period * passed * ROUNDING + 1e-12
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


@pytest.mark.parametrize("passed", [1, 3])
def test_speeds_that_an_envelope_slows_down_keep_the_limits(passed: int) -> None:
    slow = math.inf

    def allowed(speeds: Any) -> float:
        return min(1.0, slow / math.hypot(*speeds[:3]))

    rates = SpeedGenerator(POSE_SPACE, Limits((1.0, 1.0), (2.0, 2.0)), 0.01, allowed)
    rates.aim((0.6, 0.0, 0.8, 0.0, 0.0, 0.0), 0.01, 0.01)
    speeds = [rates.step(passed) for _ in range(60)]
    slow = 0.1
    speeds += [rates.step(passed) for _ in range(60)]
    assert math.hypot(*speeds[59]) == pytest.approx(1.0)
    assert math.hypot(*speeds[-1]) == pytest.approx(0.1)
    steps = [math.dist(one, other) for one, other in itertools.pairwise(speeds)]
    assert max(steps) <= 2.0 * 0.01 * passed * ROUNDING


@pytest.mark.parametrize("kind", [Limiter, JerkLimiter])
def test_braking_in_fewer_steps_is_no_longer_way(kind: Any) -> None:
    """On a slow connection each step takes several ticks."""
    numbers, ways = [], []
    for passed in (1, 5):
        limiter = kind(JOINT_SPACE, limits(JOINT_SPACE, 1.0, 2.0, 40.0), 0.01, (0.0,) * 6)
        for n in range(200):
            begun = limiter.follow((0.008 * n, *(0.0,) * 5))
        numbers.append(0)
        while not limiter.at_rest:
            config = limiter.brake(passed)
            numbers[-1] += 1
        ways.append(config[0] - begun[0])
        assert limiter.brake(passed) == config
    assert numbers[1] <= numbers[0] / 5 + 2
    assert 0.0 <= ways[1] <= ways[0]


@pytest.mark.slow
async def test_joint_speeds_carry_the_dead_man_time_and_end_by_speed_stop(
    controller: Controller,
) -> None:
    opened = Speed(controller.endpoint).joints(
        a=2.0, v=0.5, dead_man=0.15, hold=10.0, options=THREAD
    )
    async with opened as stream:
        async for tick in stream.ticks():
            await stream.send([1.0, 0.0, 0.0, 0.0, 0.0, -0.1])
            if tick.number == 25:
                break
    calls = controller.server.received("speedj")
    speeds = np.array([call.args[0] for call in calls])
    assert {call.args[1:] for call in calls} == {(2.0, 150, False)}
    assert speeds.max() == 0.5
    assert np.abs(np.diff(speeds, axis=0)).max() <= 2.0 / 50 * (1 + 1e-6)
    assert not speeds[-1].any()
    assert controller.names()[-1] == "speed_stop"


async def test_turning_speeds_between_two_times_are_numbers_and_no_orientations() -> None:
    """As angles they would turn at 3 rad/s the other way round, and slower."""
    stream = Speed(Controller.nowhere()).linear(a=0.5, latest=False)
    speeds = [[0.0] * 6, [0.0, 0.0, 0.1, 0.4, 0.5, 3.5]]
    sampled = np.array(await stream._sampled(speeds, [0.0, 1.0]))
    assert sampled.shape == (51, 6)
    np.testing.assert_allclose(sampled, sampled[:, 5:] / 3.5 * np.array(speeds[1]), atol=1e-12)


async def test_a_speed_that_somebody_pauses_while_it_ends_is_told(controller: Controller) -> None:
    """What the program sends next must not move an arm that somebody has paused."""
    options = dataclasses.replace(THREAD, watch=0.02)
    opened = Speed(controller.endpoint).joints(a=0.01, v=0.5, hold=10.0, options=options)
    controller.server.answer(
        "get_noneblock_taskstate", lambda _: 1 + (opened.state is StreamState.DECELERATING)
    )
    ramped = partial(eventually_async, lambda: len(controller.server.received("speedj")) > 50)
    with pytest.raises(StreamRefused, match="was paused"):
        await fed(opened, [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]], ramped)
    assert controller.names()[-2:] == ["speed_stop", "stop"]


async def test_a_speed_that_is_found_paused_at_its_end_is_stopped(controller: Controller) -> None:
    """Also where nobody looked: what is left of it must not move the arm when it is resumed."""
    opened = Speed(controller.endpoint).joints(a=0.5, v=0.5, options=UNWATCHED)
    controller.server.answer(
        "get_robot_state", lambda: [6, 2 + (opened.state >= StreamState.DECELERATING), 5, 1]
    )
    with pytest.raises(StreamRefused, match="the arm is paused"):
        await fed(opened, [[0.1, 0.0, 0.0, 0.0, 0.0, 0.0]])
    assert controller.names()[-2:] == ["speed_stop", "stop"]


async def test_a_tool_speed_without_a_hand_on_it_ends_at_zero(controller: Controller) -> None:
    opened = Speed(controller.endpoint).linear(a=0.5, dead_man=0.2, hold=0.06, options=THREAD)
    with pytest.raises(StreamStarved):
        await fed(opened, [[0.05, 0.0, 0.0, 0.0, 0.0, 0.2]], opened.ended)
    speeds = np.array([call.args[0] for call in controller.server.received("speedl")])
    assert np.linalg.norm(np.diff(speeds[:, :3], axis=0), axis=1).max() <= 0.5 / 50 * (1 + 1e-6)
    assert not speeds[-1].any()
    assert controller.names()[-2:] == ["speed_stop", "stop"]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["speeds", "places"])
async def test_an_arm_brakes_as_fast_on_a_slow_connection(
    controller: Controller, kind: str
) -> None:
    """Five ticks pass in each call: with one step a call, the arm would take five times as long."""
    name = "speedj" if kind == "speeds" else "servoj"
    with FaultProxy(controller.server.host, controller.server.port) as proxy:
        proxy.on(name, Delay(reply=0.05), times=None)
        endpoint = dataclasses.replace(controller.endpoint, port=proxy.port)
        if kind == "speeds":
            stream = Speed(endpoint).joints(
                a=1.0, v=1.0, rate=100, dead_man=2.0, hold=10.0, options=THREAD
            )
            targets = [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
        else:
            stream = Servo(endpoint).joints(v=1.0, a=1.0, rate=100, options=THREAD)
            targets = [[5e-5 * n * n, *HERE[1:]] for n in range(100)]
        with anyio.CancelScope() as scope:
            async with stream:
                for target in targets:
                    await stream.send(target)
                await eventually_async(lambda: len(controller.points(name)) > 60)
                before = len(controller.points(name))
                scope.cancel()
        sent = [point[0] for point in controller.points(name)][before:]
    steps = np.array(sent) if kind == "speeds" else np.diff(sent)
    assert steps[-1] == 0.0
    assert (np.diff(steps) <= 1e-9).all()
    assert 0 < (steps > 0.0).sum() < 25


def test_a_dead_man_time_is_no_less_than_two_calls_and_not_for_ever() -> None:
    speed = Speed(Controller.nowhere())
    for make in (speed.joints, speed.linear):
        for wrong in (0.03, None, 200):  # milliseconds
            with pytest.raises(ParameterError, match="dead_man"):
                make(a=1.0, rate=50.0, dead_man=wrong)  # type: ignore[arg-type]  # that is the test


def moving(count: int) -> Callable[[Peer], None]:
    """An arm that is seen to move some times."""
    left = count

    def script(peer: Peer) -> None:
        nonlocal left
        while (call := peer.receive()) is not None:
            left -= call.name == "robotmoving"
            peer.answer(call, left >= 0 if call.name == "robotmoving" else 4)

    return script


def rest(server: ScriptedServer, seconds: float, *, stops: bool) -> tuple[bool, int]:
    """Whether the arm was brought to rest, and how often the worker showed that it runs."""
    own = OwnConnection(Endpoint(server.host, server.port, PATIENCE))
    own.ready()
    signs: list[None] = []
    now = time.monotonic()
    motion = UnansweredMotion.none(now, now + seconds, stops=stops)
    try:
        return bring_to_rest(motion, own, PATIENCE, lambda: signs.append(None)), len(signs)
    finally:
        own.close()


@for_each("count", [0, 3])
def test_it_is_seen_to_stand_twice(count: int) -> None:
    with ScriptedServer(moving(count)) as server:
        stands, signs = rest(server, PATIENCE, stops=False)
        assert stands
        assert server.names == ["robotmoving"] * (count + 2)
        assert signs == count + 3
        assert server.connections == 1


def test_a_connection_that_breaks_meanwhile_is_replaced() -> None:
    def breaks(peer: Peer) -> None:
        peer.receive()
        peer.reset()

    with ScriptedServer(breaks, moving(1)) as server:
        stands, _ = rest(server, PATIENCE, stops=False)
        assert stands
        assert server.connections == 2
        assert "stop" not in server.names


def test_an_arm_that_moves_on_is_given_up() -> None:
    with ScriptedServer(moving(10**9)) as server:
        stands, _ = rest(server, 0.05, stops=False)
        assert not stands
        assert "stop" not in server.names
