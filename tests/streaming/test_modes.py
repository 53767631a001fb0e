"""The realtime mode of a stream, and its points in the track pool: off at the end, or known."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from client.bench import HOME, Bench
from for_each import for_each

import aioduco
from aioduco import JointTrajectory, SwitchPlace, Tolerances, TrajectorySwitch
from aioduco.api.motion.trajectory import _points, _send, _Way
from aioduco.errors import RobotStateError, StreamError, StreamLost, WorkerFailed
from aioduco.sim import Simulator
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.stream import Stream
from aioduco.testing import Cut, FaultProxy, Place, eventually_async

from .conftest import THREAD, Cycles, answer_all


class Queue(Bench):
    """A controller with a realtime queue and a track pool.

    Attributes:
        on: whether realtime mode is on.
    """

    def __init__(self) -> None:
        super().__init__()
        self.on = False
        cycles = Cycles(0.001)

        def start(*_: Any) -> int:
            self.on = True
            return cycles.start()

        def end() -> int:
            self.on = False
            return cycles.end()

        mode = {"start_realtime_mode": start, "end_realtime_mode": end}
        track = {"trackClearQueue": 4, "trackEnqueue": 4, "getQueueSize": 20}
        answer_all(self, {**cycles.answers, **mode, **track, "trackJointMotion": 1234})
        self.end = end


@pytest.fixture
def bench() -> Iterator[Queue]:
    with Queue() as bench:
        yield bench


async def go_on(robot: aioduco.Robot, options: WorkerOptions, during: Any) -> None:
    """Hold the arm by a realtime stream, and call `during` once it is in full course."""
    async with robot.realtime.stream(
        "joint_position", v=1.0, a=5.0, hold=10.0, options=options
    ) as stream:
        await stream.send(HOME)
        called = False
        while True:
            await stream.send(HOME)
            if stream.statistics().sent > 200 and not called:
                called = True
                during(stream)


@pytest.mark.slow
async def test_a_stream_whose_connection_breaks_ends_its_mode_on_another_one(bench: Queue) -> None:
    with FaultProxy(bench.host, bench.port) as proxy:
        async with aioduco.connect(proxy.host, proxy.port) as robot:
            with pytest.raises(StreamLost):
                await go_on(
                    robot,
                    THREAD,
                    lambda _: proxy.on("get_realtime_data_queue_size", Cut(Place.BEFORE_REPLY)),
                )
            assert not bench.on
            assert "end_realtime_mode" not in robot._supervisor.stop_coordinator.modes
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
    assert len(bench.received("end_realtime_mode")) == 1


@pytest.mark.slow
async def test_the_robot_ends_the_mode_of_a_worker_that_was_killed(bench: Queue) -> None:
    def kill(stream: Stream) -> None:
        assert stream.pid is not None
        os.kill(stream.pid, signal.SIGKILL)

    async with aioduco.connect(bench.host, bench.port) as robot:
        with pytest.raises(WorkerFailed, match="SIGKILL"):
            await go_on(robot, WorkerOptions(), kill)
        assert not bench.on
        await robot.motion.movej2(HOME, v=1.0, a=1.0)


@pytest.mark.slow
async def test_nothing_moves_the_arm_in_a_mode_that_could_not_be_ended(bench: Queue) -> None:
    with FaultProxy(bench.host, bench.port) as proxy:
        async with aioduco.connect(proxy.host, proxy.port) as robot:

            def cut(_: Stream) -> None:
                proxy.on("end_realtime_mode", Cut(Place.AFTER_REQUEST), times=None)
                proxy.on("get_realtime_data_queue_size", Cut(Place.BEFORE_REPLY))

            with pytest.raises(StreamError):
                await go_on(robot, THREAD, cut)
            for send in (
                lambda: robot.motion.movej2(HOME, v=1.0, a=1.0),
                lambda: robot.servo.joints(v=1.0, a=1.0).__aenter__(),
                lambda: robot.realtime.realtime_data_enqueue(
                    [aioduco.RealtimePoint.joint_position(HOME)]
                ),
            ):
                before = len(bench.received("movej2")), len(bench.received("realtime_data_enqueue"))
                with pytest.raises(RobotStateError, match="end_realtime_mode was not answered"):
                    await send()
                assert before == (
                    len(bench.received("movej2")),
                    len(bench.received("realtime_data_enqueue")),
                )
            proxy.clear()
            await robot.stop()
            assert not bench.on
            await robot.motion.movej2(HOME, v=1.0, a=1.0)


@pytest.mark.slow
async def test_leaving_the_robot_ends_it_at_the_latest(bench: Queue) -> None:
    with FaultProxy(bench.host, bench.port) as proxy:
        async with aioduco.connect(proxy.host, proxy.port) as robot:

            def cut(_: Stream) -> None:
                bench.on = True
                proxy.on("end_realtime_mode", Cut(Place.IN_REQUEST), times=None)
                proxy.on("get_realtime_data_queue_size", Cut(Place.BEFORE_REPLY))

            with pytest.raises(StreamError):
                await go_on(robot, THREAD, cut)
            assert bench.on
            proxy.clear()
    assert not bench.on


async def test_a_stop_ends_the_mode_once(bench: Queue) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        with pytest.raises(StreamError):
            await go_on(robot, THREAD, lambda _: robot.stop_now())
        await robot.stop()
        assert not bench.on
    assert len(bench.received("end_realtime_mode")) == 1


@pytest.mark.parametrize("refused", [False, True])
async def test_the_pool_of_a_stopped_stream_is_empty(bench: Queue, *, refused: bool) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:

        async def program() -> None:
            stream = robot.track.stream("joints", speed=0.5, acc=1.0, low=10, options=THREAD)
            async with stream:
                for _ in range(30):
                    await stream.send(HOME)
                await eventually_async(lambda: bench.received("trackJointMotion"))
                emptied.append(len(bench.received("trackClearQueue")))
                if refused:
                    bench.answer("trackClearQueue", 7)
                await robot.stop()

        emptied: list[int] = []
        with pytest.raises(StreamError):
            await program()
        if refused:
            with pytest.raises(aioduco.RobotStateError, match="trackClearQueue was not answered"):
                await robot.motion.movej2(HOME, v=1.0, a=1.0)
            bench.answer("trackClearQueue", 4)
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        else:
            assert [len(bench.received("trackClearQueue")) - 1] == emptied
        assert "trackClearQueue" not in robot._supervisor.stop_coordinator.modes


async def test_points_from_before_a_stop_are_not_followed_after_it() -> None:
    with Simulator(speed=20.0) as sim:
        async with aioduco.connect(sim.host, sim.port) as robot:
            await robot.bring_up()
            here = [float(angle) for angle in await robot.state.get_actual_joints_position()]
            before = [[here[0] + 0.02 * n, *here[1:]] for n in range(1, 40)]
            await robot.track.trackEnqueue([aioduco.Joints(*point) for point in before])
            motion = await robot.track.trackJointMotion(0.2, 1.0).start()
            await eventually_async(lambda: sim.joints[0] > here[0] + 0.05)
            await robot.stop()
            with pytest.raises(aioduco.TaskStopped):
                await motion
            assert await robot.track.getQueueSize() == 0
            stood = sim.joints[0]
            assert stood < here[0] + 0.7
            after = [[stood - 0.01 * n, *here[1:]] for n in range(1, 11)]
            await robot.track.trackEnqueue([aioduco.Joints(*point) for point in after])
            await robot.track.trackJointMotion(0.5, 2.0)
            assert sim.joints[0] == pytest.approx(after[-1][0], abs=5e-3)


HERE = np.array([0.0, 0.3, 1.2, 0.1, -1.5, 0.0])
WAY = np.array([0.5, -0.2, 0.1, 0.3, -0.4, 0.6])
INTERVAL = 0.002


class Sent(SimpleNamespace):
    """A stream that takes every point at once; at one of them something happens."""

    def __init__(self, number: int, happens: Any) -> None:
        super().__init__(points=[], number=number, happens=happens)

    @property
    def taken(self) -> int:
        return max(0, len(self.points) - 100)

    async def send(self, point: Any) -> None:
        self.points.append(np.array(point))
        if len(self.points) == self.number:
            self.happens()

    async def play(self, points: Any) -> None:
        await self.send(points[0])


async def send(switch: TrajectorySwitch, number: int, happens: Any) -> tuple[Sent, _Way]:
    curve = JointTrajectory([HERE, HERE + WAY], [0.0, 2.0]).curve(HERE.tolist())
    stream: Any = Sent(number, happens)
    way = _Way(curve, INTERVAL, Tolerances())
    await _send(stream, await _points(curve, INTERVAL, 3.0), way, switch, 3.0)
    return stream, way


async def test_the_event_loop_runs_while_a_long_trajectory_is_sampled() -> None:
    curve = JointTrajectory([HERE, HERE + WAY], [0.0, 100.0]).curve(HERE.tolist())
    turns: list[None] = []

    async def count() -> None:
        while True:
            turns.append(None)
            await asyncio.sleep(0.0)

    counting = asyncio.create_task(count())
    assert len(await _points(curve, 0.001, 3.0)) == 100_001
    counting.cancel()
    assert len(turns) > 10


async def test_the_arm_goes_over_without_a_step() -> None:
    switch, places = TrajectorySwitch(), []

    def make(place: SwitchPlace) -> tuple[JointTrajectory, Tolerances]:
        places.append(place)
        goal = place.joints - 0.2
        return JointTrajectory([place.joints, goal], [0.0, 1.0], [place.speeds, [0.0] * 6]), limits

    limits = Tolerances(path=0.3)
    stream, way = await send(switch, 400, lambda: switch.ask(make))
    (place,) = places
    assert place.delay == pytest.approx(0.2)
    points = np.array(stream.points)
    np.testing.assert_allclose(points[400], place.joints)
    np.testing.assert_allclose(points[-1], place.joints - 0.2, atol=1e-9)
    speeds = np.diff(points, axis=0) / INTERVAL
    assert np.abs(np.diff(speeds, axis=0)).max() / INTERVAL < 8.0
    assert np.abs(speeds[300:450]).max(axis=1).min() > 0.2  # nor a rest
    assert len(points) == 400 + 501
    # the arm is compared with the one before, and then with the other
    np.testing.assert_allclose(
        way.at(np.array([100.0, 399.5, 500.0])), points[[100, 399, 500]], atol=2e-3
    )
    assert way.part(399).tolerances is not limits
    assert way.part(400).tolerances is way.last().tolerances is limits
    assert way.time(450) == pytest.approx(0.1)


async def test_one_that_is_not_made_changes_nothing() -> None:
    switch = TrajectorySwitch()
    asked: list[str] = []
    stream, _ = await send(
        switch,
        400,
        lambda: switch.ask(lambda place: asked.append("made"), lambda: asked.append("no")),
    )
    assert asked == ["made"]
    np.testing.assert_allclose(stream.points[-1], HERE + WAY)


@for_each("number", [1001, None])
async def test_it_is_said_when_it_is_too_late(number: int | None) -> None:
    switch = TrajectorySwitch()
    asked: list[str] = []

    def ask() -> None:
        switch.ask(lambda place: asked.append("made"), lambda: asked.append("no"))

    if number is None:
        ask()
    else:
        await send(switch, number, ask)
    assert asked == ["no"]
