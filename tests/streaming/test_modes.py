"""The realtime mode of a stream, and its points in the track pool: off at the end, or known."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from typing import Any

import pytest
from client.bench import HOME, Bench

import aioduco
from aioduco.errors import RobotStateError, StreamError, StreamLost, WorkerFailed
from aioduco.sim import Simulator
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.stream import Stream
from aioduco.testing import Cut, FaultProxy, Place, eventually_async

from .conftest import Cycles, answer_all

THREAD = WorkerOptions(run_in="thread")


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


async def test_the_pool_of_a_stopped_stream_is_empty(bench: Queue) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:

        async def program() -> None:
            stream = robot.track.stream("joints", speed=0.5, acc=1.0, low=10, options=THREAD)
            async with stream:
                for _ in range(30):
                    await stream.send(HOME)
                await eventually_async(lambda: bench.received("trackJointMotion"))
                emptied.append(len(bench.received("trackClearQueue")))
                await robot.stop()

        emptied: list[int] = []
        with pytest.raises(StreamError):
            await program()
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
