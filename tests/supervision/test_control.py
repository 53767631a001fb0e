"""Stop, pause, resume, abort: no other call delays them."""

from __future__ import annotations

import asyncio
import re
import sys
import time
from typing import Any

import anyio
import pytest
from client.bench import HOME, Bench, under_way
from moments import on_another_thread

import aioduco
from aioduco import Outcome, TaskState
from aioduco._process.reporting import reporter
from aioduco._wire.deadline_socket import DeadlineSocket
from aioduco._wire.lane import WireLane
from aioduco.supervision import stop_channel
from aioduco.testing import Cut, DropReply, FaultProxy, HalfOpen, Place, eventually_async


async def occupied(robot: aioduco.Robot, bench: Bench, tg: anyio.abc.TaskGroup) -> None:
    """Every thread of the pool sits in a call that does not return."""
    bench.hold("set_standard_digital_out")
    pool = robot.statistics().lanes["call"]
    for num in range(1, 7):
        tg.start_soon(robot.io.set_standard_digital_out, num, True)
    await eventually_async(lambda: len(bench.received("set_standard_digital_out")) == 4)
    assert robot.statistics().lanes["call"].busy == 4
    assert pool.busy == 0


async def test_stop_waits_behind_nothing(bench: Bench) -> None:
    arrivals: list[float] = []
    async with (
        aioduco.connect(bench.host, bench.port, call_timeout=20.0) as robot,
        anyio.create_task_group() as tg,
    ):
        await occupied(robot, bench, tg)
        for _ in range(20):
            task = await under_way(bench, robot)
            before = time.monotonic()
            await robot.stop()
            arrivals.append(bench.received("stop")[-1].at - before)
            assert task.outcome is Outcome.STOPPED
        # All of them sat in the pool all the time.
        assert robot.statistics().lanes["call"].busy == 4
        assert robot.statistics().lanes["call"].waiting == 2
        tg.cancel_scope.cancel()
    assert max(arrivals) < 10.0  # what sits in the pool does so for 30 s


async def test_stop_comes_back_when_the_arm_stands(robot: aioduco.Robot, bench: Bench) -> None:
    bench.motion_time, bench.braking_time = 30.0, 0.15
    await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    await robot.stop()
    assert not bench.moving()
    assert time.monotonic() - bench.received("stop")[0].at >= 0.15


async def test_stop_now_from_another_thread_while_the_loop_hangs(
    robot: aioduco.Robot, bench: Bench
) -> None:
    task = await under_way(bench, robot)
    on_another_thread(robot.stop_now)  # the event loop cannot run meanwhile
    assert bench.commands[-1] == "stop"
    with pytest.raises(aioduco.TaskStopped):
        await task


@pytest.mark.parametrize("interrupt", [KeyboardInterrupt(), TimeoutError("an alarm")], ids=repr)
async def test_stop_now_that_is_interrupted_is_sent_all_the_same(
    robot: aioduco.Robot, bench: Bench, monkeypatch: pytest.MonkeyPatch, interrupt: BaseException
) -> None:
    await under_way(bench, robot)

    def interrupted(*_: Any) -> None:
        monkeypatch.undo()
        raise interrupt

    monkeypatch.setattr(WireLane, "call_from_thread", interrupted)
    with pytest.raises(type(interrupt)) as raised:
        robot.stop_now()
    assert raised.value is interrupt
    assert bench.commands[-1] == "stop"


async def test_a_stop_is_repeated_over_fresh_connections(bench: Bench, proxy: FaultProxy) -> None:
    async with aioduco.connect(proxy.host, proxy.port) as robot:
        task = await under_way(bench, robot)
        proxy.on("stop", DropReply())
        proxy.on("stop", Cut(Place.IN_REQUEST))
        await robot.stop()
        assert task.outcome is Outcome.STOPPED
        figures = robot.statistics()
        assert figures.stop_attempts >= 2
        assert figures.stops == 1
    assert not bench.moving()


@pytest.mark.slow
async def test_a_stop_that_cannot_be_confirmed_says_so(bench: Bench) -> None:
    robot = aioduco.connect(bench.host, bench.port, stop_timeout=0.3)
    await robot.open()
    await under_way(bench, robot)
    bench.answer("stop", -1)
    with pytest.raises(aioduco.StopUnconfirmed, match="Press the emergency stop") as caught:
        await robot.stop()
    # the last attempt has what is left of the time
    assert isinstance(caught.value.__cause__, aioduco.Refused | aioduco.OutcomeUnknown)
    with pytest.raises(aioduco.StopUnconfirmed, match="no stop was accepted"):
        robot.stop_now(0.2)
    # The way out tries once more, says the same, and closes everything all the same.
    with pytest.raises(aioduco.StopUnconfirmed, match="no stop was accepted"):
        await robot.aclose()
    await eventually_async(lambda: bench.connections == 0)
    assert len(bench.received("stop")) > 3


async def test_an_arm_that_does_not_come_to_rest_is_said_to_move(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    # What is said last is heard, however late a busy machine says it.
    monkeypatch.setattr(stop_channel, "_LAST_LIMIT", 30.0)
    async with aioduco.connect(bench.host, bench.port, standstill_timeout=0.2) as robot:
        await under_way(bench, robot)
        bench.answer("robotmoving", True)
        with pytest.raises(aioduco.StopUnconfirmed, match="the arm still moves"):
            await robot.stop()
        bench.answer("robotmoving", bench.moving)


async def test_a_stop_during_the_start_of_a_motion_holds_for_it(
    robot: aioduco.Robot, bench: Bench
) -> None:
    """The stop is served first, the motion afterwards: it must not go on."""
    start = bench._answers["movej2"]
    gate = bench.hold("movej2", start)
    tasks: list[aioduco.Task] = []

    async def go() -> None:
        tasks.append(await under_way(bench, robot))

    async with anyio.create_task_group() as tg:
        tg.start_soon(go)
        await eventually_async(lambda: bench.received("movej2"))
        tg.start_soon(robot.stop)
        await eventually_async(lambda: bench.received("stop"))
        # The arm stands, but `stop` does not say so: the motion may still come.
        assert bench.commands[:2] == ["movej2", "stop"]
        gate.set()
    assert not bench.moving()
    with pytest.raises(aioduco.TaskStopped):
        await tasks[0]


async def test_a_motion_that_is_served_after_a_pause_is_paused_when_that_returns(
    robot: aioduco.Robot, bench: Bench
) -> None:
    let = bench.hold("movej2", bench._answers["movej2"])
    async with anyio.create_task_group() as tg:
        tg.start_soon(under_way, bench, robot)
        await eventually_async(lambda: bench.received("movej2"))

        async def let_late() -> None:
            await eventually_async(lambda: bench.received("pause"))
            let.set()

        tg.start_soon(let_late)
        await robot.pause()
        assert let.is_set()
        assert not bench.moving()
    (task,) = robot.tasks
    await eventually_async(lambda: task.state is aioduco.TaskState.PAUSED)
    assert "stop" not in bench.commands


async def test_pause_waits_for_standstill_and_resume_goes_on(
    robot: aioduco.Robot, bench: Bench
) -> None:
    task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    await eventually_async(bench.moving)
    assert await robot.pause() is True
    assert not bench.moving()
    assert await robot.resume() is True
    assert await task is Outcome.FINISHED


@pytest.mark.parametrize("name", ["pause", "resume"])
async def test_pause_and_resume_say_whether_anything_was_paused(
    robot: aioduco.Robot, bench: Bench, name: str
) -> None:
    call = getattr(robot, name)
    assert await call() is False
    assert len(bench.received(name)) == 1  # it is sent in any case
    for state in (aioduco.ProgramState.PAUSED, aioduco.ProgramState.PAUSING):
        bench.states[1] = int(state)  # of another program
        assert await call() is True


@pytest.mark.parametrize("name", ["pause", "resume", "abort"])
async def test_a_bare_state_in_place_of_a_task_is_its_end(
    robot: aioduco.Robot, bench: Bench, name: str
) -> None:
    carried_out = bench._answers[name]

    def answered(block: bool) -> int:
        carried_out(block)
        return int(aioduco.TaskState.FINISHED)

    bench.answer(name, answered)
    await getattr(robot, name)()
    numbers = [call.args[0] for call in bench.received("get_noneblock_taskstate")]
    assert int(aioduco.TaskState.FINISHED) not in numbers  # which is no task
    bench.answer(name, int(aioduco.TaskState.ILLEGAL))
    with pytest.raises(aioduco.TaskIllegal):
        await getattr(robot, name)()


async def test_abort_ends_the_motion_and_never_passes_for_blending(
    robot: aioduco.Robot, bench: Bench
) -> None:
    bench.motion_time = 30.0

    def abort(block: bool) -> int:
        answer: int = bench._answers["stop"](block)
        for task in bench.tasks.values():
            if task.motion:
                task.state = aioduco.TaskState.INTERRUPT
        return answer

    bench.answer("abort", abort)
    first = await robot.motion.movej2(HOME, v=1.0, a=1.0, r=0.05).start()
    second = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    await robot.abort()
    for task in (first, second):
        with pytest.raises(aioduco.TaskInterrupted):
            await task


@pytest.mark.parametrize("why", ["cancelled", "unanswered", "refused"])
async def test_an_abort_that_does_not_come_to_its_end_stops_the_arm(bench: Bench, why: str) -> None:
    if why == "refused":
        bench.answer("abort", -1)
    else:
        bench.hold("abort")
    async with aioduco.connect(bench.host, bench.port, call_timeout=0.3) as robot:
        task = await under_way(bench, robot)
        aborting = asyncio.ensure_future(robot.abort())
        if why == "cancelled":
            await eventually_async(lambda: "abort" in bench.commands)
            aborting.cancel()
        with pytest.raises((asyncio.CancelledError, aioduco.OutcomeUnknown, aioduco.Refused)):
            await aborting
        assert not bench.moving()
        with pytest.raises(aioduco.TaskStopped):
            await task


@pytest.mark.parametrize("name", ["stop", "pause", "resume", "abort"])
async def test_nothing_is_sent_before_opening_and_after_closing(bench: Bench, name: str) -> None:
    robot = aioduco.connect(bench.host, bench.port)
    with pytest.raises(aioduco.RobotStateError, match=f"{name} was not sent: the robot is not op"):
        await getattr(robot, name)()
    async with robot:
        pass
    with pytest.raises(aioduco.RobotStateError, match=f"{name} was not sent: the robot is closed"):
        await getattr(robot, name)()
    with pytest.raises(aioduco.RobotStateError, match="closed"):
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
    assert bench.commands == []


async def test_a_half_open_stop_connection_does_not_delay_the_stop_for_long(
    bench: Bench, proxy: FaultProxy
) -> None:
    """A cable pulled on one connection only: the next one carries the stop."""
    async with aioduco.connect(proxy.host, proxy.port) as robot:
        await under_way(bench, robot)
        proxy.on("stop", HalfOpen())
        await robot.stop()
        assert robot.statistics().stop_attempts == 2
    assert not bench.moving()


async def test_a_read_is_few_frames_and_no_thread_from_its_send(
    robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each frame costs time in every call; none may come between unseen."""
    await robot.state.get_tcp_pose()
    names: list[str] = []
    send = DeadlineSocket.send_at_once

    def sent(stream: DeadlineSocket, data: bytes) -> int:
        frame = sys._getframe(1)
        while not names and frame is not None:
            names.append(frame.f_code.co_name)
            while names[-1] != "get_tcp_pose" and frame.f_back is not None:
                frame = frame.f_back
                names.append(frame.f_code.co_name)
        return send(stream, data)

    monkeypatch.setattr(DeadlineSocket, "send_at_once", sent)
    await robot.state.get_tcp_pose()
    # beside these: `DeadlineSocket.send_at_once` and `nonblocking.send_at_once`
    assert names[::-1] == ["get_tcp_pose", "call", "call", "send"]


async def test_an_awaited_motion_is_few_frames_and_no_task_from_its_send(
    robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    names: list[str] = []
    senders: list[asyncio.Task[Any] | None] = []
    send = DeadlineSocket.send_at_once

    def sent(stream: DeadlineSocket, data: bytes) -> int:
        frame = sys._getframe(1)
        if b"movej2" in data:
            senders.append(asyncio.current_task())
            while frame.f_back is not None and frame.f_code.co_filename != __file__:
                names.append(frame.f_code.co_name)
                frame = frame.f_back
        return send(stream, data)

    monkeypatch.setattr(DeadlineSocket, "send_at_once", sent)
    await robot.motion.movej2(HOME, v=1.0, a=1.0)
    assert senders == [asyncio.current_task()]
    # beside these: `DeadlineSocket.send_at_once` and `nonblocking.send_at_once`
    assert names[::-1] == ["_run", "launch", "_launch", "answered", "send", "send"]


# -- paused by others ------------------------------------------------------------------------------


async def test_a_motion_that_somebody_else_pauses_is_logged_once_each_time(
    robot: aioduco.Robot, bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    """It waits, maybe for hours: a person must find out for what."""
    follower = robot._supervisor.stop_coordinator.follower
    bench.motion_time = 60.0
    task = await under_way(bench, robot)

    async def paused() -> int:
        """Pause it and look at it for a while; how often the log tells of it then."""
        bench._pause(True)
        await eventually_async(lambda: task.state is TaskState.PAUSED)
        polls = follower.polls
        await eventually_async(lambda: follower.polls > polls + 5)
        bench._resume(True)
        await eventually_async(lambda: task.state is TaskState.RUNNING)
        assert reporter.flush()
        said = r"PAUSED> waits, .*pause\(\) .*switch of the mode.*aioduco resume.*robot\.stop\(\)"
        return len(re.findall(said, caplog.text))

    assert [await paused(), await paused()] == [1, 2]
    await robot.stop()


async def test_a_pause_by_the_program_itself_is_not_logged(
    robot: aioduco.Robot, bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    bench.motion_time = 60.0
    task = await under_way(bench, robot)
    await robot.pause()
    await eventually_async(lambda: task.state is TaskState.PAUSED)
    await robot.stop()
    assert reporter.flush()
    assert "PAUSED" not in caplog.text
    task = await under_way(bench, robot)
    bench._pause(True)  # by somebody else, after the program's own pause was over
    await eventually_async(lambda: task.state is TaskState.PAUSED)
    assert reporter.flush()
    assert "PAUSED" in caplog.text
    await robot.stop()


async def test_a_pause_by_somebody_else_is_logged_also_where_they_resumed_our_own(
    robot: aioduco.Robot, bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    """The program's pause was over then, though the program did not end it."""
    bench.motion_time = 60.0
    task = await under_way(bench, robot)
    await robot.pause()
    await eventually_async(lambda: task.state is TaskState.PAUSED)
    bench._resume(True)
    await eventually_async(lambda: task.state is TaskState.RUNNING)
    assert reporter.flush()
    assert "PAUSED" not in caplog.text
    bench._pause(True)
    await eventually_async(lambda: task.state is TaskState.PAUSED)
    assert reporter.flush()
    assert "PAUSED" in caplog.text
    await robot.stop()
