"""After late, empty and failed answers the arm is stopped, and stands."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import anyio
import pytest
from client.bench import HOME, Bench
from wire.lanes import noted

import aioduco
from aioduco.models.enums import Outcome
from aioduco.testing import ApplicationError, Fault, FaultProxy, Garbage, eventually_async


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench() as bench:
        bench.motion_time = 30.0
        yield bench


async def test_a_motion_that_was_queued_and_answered_by_an_error_is_stopped(bench: Bench) -> None:
    start = bench._answers["movej2"]

    def queued(*args: Any) -> int:
        start(*args)
        raise RuntimeError("internal error, after the motion was queued")

    bench.answer("movej2", queued)
    async with aioduco.connect(bench.host, bench.port) as robot:
        with pytest.raises(aioduco.ControllerError):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert [task.name for task in bench.tasks.values()].count("movej2") == 1
        assert not bench.moving()
        bench.answer("movej2", start)
        bench.motion_time = 0.01
        assert await robot.motion.movej2(HOME, v=1.0, a=1.0) is Outcome.FINISHED


@pytest.mark.parametrize(
    "fault",
    [ApplicationError(5, "missing result", forward=True), Garbage()],
    ids=["no result", "no answer at all"],
)
async def test_a_motion_that_was_queued_and_not_answered_truly_is_stopped(
    bench: Bench, fault: Fault
) -> None:
    async with (
        FaultProxy(bench.host, bench.port) as proxy,
        aioduco.connect(proxy.host, proxy.port) as robot,
    ):
        proxy.on("movej2", fault)
        with pytest.raises((aioduco.OutcomeUnknown, aioduco.ControllerError)):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert [task.name for task in bench.tasks.values()].count("movej2") == 1
        assert not bench.moving()


async def test_a_motion_that_the_controller_does_not_know_is_refused_and_stops_nothing(
    bench: Bench,
) -> None:
    async with (
        FaultProxy(bench.host, bench.port) as proxy,
        aioduco.connect(proxy.host, proxy.port) as robot,
    ):
        proxy.on("movej2", ApplicationError(1, "unknown function"))
        with pytest.raises(aioduco.UnknownFunction):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert "stop" not in bench.commands


@pytest.mark.slow
async def test_nobody_is_told_before_a_motion_that_is_read_late_was_stopped(bench: Bench) -> None:
    """The controller has taken the command and reads it after the stop."""
    start = bench._answers["movej2"]
    gate = bench.hold("movej2", start)
    told: list[BaseException] = []

    async with aioduco.connect(bench.host, bench.port, call_timeout=1.0) as robot:
        async with anyio.create_task_group() as tg:
            motion = robot.motion.movej2(HOME, v=1.0, a=1.0)
            tg.start_soon(noted, told, aioduco.OutcomeUnknown, motion)
            await eventually_async(lambda: bench.commands[:2] == ["movej2", "stop"])
            stop = anyio.Event()

            async def stopped() -> None:
                await robot.stop()
                stop.set()

            tg.start_soon(stopped)
            count = len(bench.received("stop"))
            await eventually_async(lambda: len(bench.received("stop")) > count)
            looks = len(bench.received("robotmoving"))
            await eventually_async(lambda: len(bench.received("robotmoving")) > looks + 20)
            assert not told
            assert not stop.is_set()
            gate.set()
        assert told
        assert "answered late" in str(told[0])
        assert not bench.moving()
        assert bench.commands.index("stop", bench.commands.index("movej2")) > 0


async def test_a_resume_whose_answer_is_lost_moves_nothing_later(bench: Bench) -> None:
    """As a motion: what it would set moving is stopped, and its late answer is waited for."""
    async with aioduco.connect(bench.host, bench.port, call_timeout=1.0) as robot:
        task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        await robot.pause()
        resume = bench._answers["resume"]
        gate = bench.hold("resume", resume)
        served: list[bool] = []

        def stop(block: bool) -> int:
            gate.set()
            served.append(block)
            answer: int = bench._stop(block)
            return answer

        bench.answer("stop", stop)
        with pytest.raises((aioduco.OutcomeUnknown, aioduco.TaskError)):
            await robot.resume()
        assert served
        assert not bench.moving()
        with pytest.raises(aioduco.TaskError):
            await task


@pytest.mark.slow
@pytest.mark.parametrize("how", ["lost", "cancelled"])
@pytest.mark.parametrize("queue", ["realtime", "track"])
async def test_points_whose_answer_is_lost_move_nothing_later(
    bench: Bench, queue: str, how: str
) -> None:
    """As a motion: they may be queued late; then the mode is ended, or the pool emptied."""
    name, ending = {
        "realtime": ("realtime_data_enqueue", "end_realtime_mode"),
        "track": ("trackEnqueue", "trackClearQueue"),
    }[queue]

    async def put() -> None:
        if queue == "track":
            await robot.track.trackEnqueue([aioduco.Joints(*HOME)])
        else:
            point = aioduco.RealtimePoint.joint_position(HOME)
            await robot.realtime.realtime_data_enqueue([point])

    for each in ("start_realtime_mode", "end_realtime_mode", "trackEnqueue", "trackClearQueue"):
        bench.answer(each, 4)
    async with aioduco.connect(bench.host, bench.port, call_timeout=1.0) as robot:
        if queue == "track":
            robot.track.trackJointMotion(0.4, 1.0).mark_used()  # the arm may follow the pool
        else:
            await robot.realtime.start_realtime_mode(0)
        gate = bench.hold(name)

        def stop(block: bool) -> int:
            gate.set()
            answer: int = bench._stop(block)
            return answer

        bench.answer("stop", stop)
        if how == "lost":
            with pytest.raises(aioduco.OutcomeUnknown):
                await put()
        else:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(put)
                await eventually_async(lambda: bench.received(name))
                tasks.cancel_scope.cancel()
        sent = bench.commands
        assert "stop" in sent[sent.index(name) :]
        assert sent.index(ending, sent.index(name)) > 0
        assert not robot._supervisor.stop_coordinator.moving


@pytest.mark.slow
async def test_a_wait_that_finds_no_answer_ends(bench: Bench) -> None:
    bench.hold("movej2", 4)
    async with aioduco.connect(
        bench.host, bench.port, call_timeout=1.0, unanswered_timeout=0.2
    ) as robot:
        with pytest.raises(aioduco.OutcomeUnknown, match="no answer came in time"):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert not bench.moving()
