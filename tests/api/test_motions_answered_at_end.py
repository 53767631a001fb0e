"""Motions that the controller answers at their end, and the mode that follows a queue."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any, NamedTuple

import anyio
import pytest
from client.bench import HOME, POSE
from moments import cancelled_once

import aioduco
from aioduco import HeartbeatState, ProgramState, RealtimeMode, RealtimePoint, TaskState
from aioduco._process.reporting import reporter
from aioduco.testing import ApplicationError, Cut, FaultProxy, Place, eventually_async
from api.cases import END_ERRORS
from api.desk import Desk


class AnsweredAtItsEnd(NamedTuple):
    """A motion that the controller answers when it has ended."""

    name: str
    call: Callable[[aioduco.Robot], Awaitable[object]]


MOTIONS = [
    AnsweredAtItsEnd("replay", lambda robot: robot.motion.replay("track", 50, 0)),
    AnsweredAtItsEnd("movel", lambda robot: robot.blocking.movel(POSE, v=0.2, a=0.5)),
]


@pytest.fixture(params=MOTIONS, ids=lambda each: each.name)
def motion(request: pytest.FixtureRequest, desk: Desk) -> AnsweredAtItsEnd:
    made: AnsweredAtItsEnd = request.param
    desk.moves(made.name)
    desk.blocks(made.name)
    desk.motion_time = 30.0
    return made


@pytest.mark.slow
async def test_it_lasts_longer_than_a_call_may_take(desk: Desk, motion: AnsweredAtItsEnd) -> None:
    desk.motion_time = 1.5
    async with aioduco.connect(desk.host, desk.port, call_timeout=1.0, pool_size=1) as robot:
        await motion.call(robot)
        assert not desk.moving()
        assert "stop" not in desk.commands


@pytest.mark.cases(4)
@pytest.mark.parametrize(("answer", "error"), [*END_ERRORS.items(), (-1, aioduco.Refused)])
async def test_another_end_is_an_error_that_says_what_the_controller_lists(
    robot: aioduco.Robot, desk: Desk, motion: AnsweredAtItsEnd, answer: int, error: type[Exception]
) -> None:
    desk.errors = ["an older one"]
    desk.fails(motion.name, answer, "out of reach")
    with pytest.raises(error, match=motion.name) as caught:
        await motion.call(robot)
    if isinstance(caught.value, aioduco.TaskError):
        assert caught.value.errors == ("out of reach",)


@pytest.mark.parametrize("answer", [0, 1, 2, 9])
async def test_an_answer_that_is_no_end_stops_the_arm(
    robot: aioduco.Robot, desk: Desk, answer: int
) -> None:
    """It may be on its way, and nothing follows it."""
    desk.moves("movel")
    desk.motion_time = 30.0
    move = desk._answers["movel"]
    desk.answer("movel", lambda *args: move(*args) and answer)
    with pytest.raises(aioduco.OutcomeUnknown, match=f"answer, {answer}, is no end"):
        await robot.blocking.movel(POSE, v=0.2, a=0.5)
    assert not desk.moving()


@pytest.mark.parametrize("on_cancel", ["stop", "detach", "pause"])
async def test_cancelling_it_stops_the_arm(
    desk: Desk, motion: AnsweredAtItsEnd, on_cancel: Any
) -> None:
    async with aioduco.connect(desk.host, desk.port, on_cancel=on_cancel) as robot:
        async with cancelled_once(desk.moving) as scope:
            await motion.call(robot)
        assert scope.cancelled_caught
        assert not desk.moving()


async def test_a_stop_ends_it(robot: aioduco.Robot, desk: Desk, motion: AnsweredAtItsEnd) -> None:
    async with anyio.create_task_group() as tg:

        async def stop() -> None:
            await eventually_async(desk.moving)
            await robot.stop()

        tg.start_soon(stop)
        with pytest.raises(aioduco.TaskStopped):
            await motion.call(robot)
        assert not desk.moving()


async def test_leaving_the_robot_stops_it(desk: Desk, motion: AnsweredAtItsEnd) -> None:
    async with anyio.create_task_group() as tg, aioduco.connect(desk.host, desk.port) as robot:

        async def move() -> None:
            with pytest.raises((aioduco.TaskStopped, aioduco.ConnectionLost)):
                await motion.call(robot)

        tg.start_soon(move)
        await eventually_async(desk.moving)
    assert not desk.moving()


@pytest.mark.slow
async def test_if_its_answer_is_lost_the_arm_is_stopped(
    desk: Desk, proxy: FaultProxy, motion: AnsweredAtItsEnd
) -> None:
    async with aioduco.connect(proxy.host, proxy.port) as robot:
        proxy.on(motion.name, Cut(Place.AFTER_REQUEST))
        with pytest.raises(aioduco.OutcomeUnknown):
            await motion.call(robot)
        assert "stop" in desk.commands
        assert not desk.moving()


async def test_without_a_heartbeat_nothing_is_sent(desk: Desk, motion: AnsweredAtItsEnd) -> None:
    async with aioduco.connect(desk.host, desk.port, heartbeat=0.2) as robot:
        gate = desk.hold("rpc_heartbeat", None)
        await eventually_async(
            lambda: robot.heartbeat and robot.heartbeat.state is not HeartbeatState.BEATING
        )
        with pytest.raises(aioduco.HeartbeatLost, match=f"{motion.name} was not sent"):
            await motion.call(robot)
        gate.set()
    assert desk.received(motion.name) == ()


async def test_a_replay_that_is_answered_with_an_id_is_followed(
    robot: aioduco.Robot, desk: Desk
) -> None:
    desk.moves("replay")
    desk.motion_time = 0.1
    await robot.motion.replay("track", 50, 0)
    assert not desk.moving()
    desk.motion_time = 30.0
    async with cancelled_once(desk.moving):
        await robot.motion.replay("track", 50, 0)
    assert not desk.moving()
    assert desk.commands[:3] == ["replay", "replay", "stop"]
    # If it was cancelled before its answer came, the arm is stopped once more when it has come.
    assert set(desk.commands[3:]) <= {"stop"}


async def test_a_replay_with_an_id_that_fails_says_what_the_controller_lists(
    robot: aioduco.Robot, desk: Desk
) -> None:
    desk.moves("replay")
    desk.motion_time = 30.0
    desk.ends = TaskState.ERROR
    desk.errors = ["an older one"]

    async def fail() -> None:
        await eventually_async(desk.moving)
        desk.errors = ["an older one", "out of reach"]
        desk.arrive()

    async with anyio.create_task_group() as tg:
        tg.start_soon(fail)
        with pytest.raises(aioduco.TaskFailed) as caught:
            await robot.motion.replay("track", 50, 0)
    assert caught.value.errors == ("out of reach",)


# -- realtime control ------------------------------------------------------------------------------


#: how a stop ends the mode: the next start does not begin with the points that are left
ENDED = ["end_realtime_mode", "clear_realtime_data_queue"]


@pytest.fixture
def realtime(desk: Desk) -> Desk:
    for name in ("start_realtime_mode", *ENDED, "realtime_data_enqueue"):
        desk.answer(name, 4)
    return desk


async def test_realtime_mode_is_ended_when_the_robot_is_left(realtime: Desk) -> None:
    async with aioduco.connect(realtime.host, realtime.port) as robot:
        await robot.realtime.realtime_data_enqueue([RealtimePoint.joint_position(HOME)])
        await robot.realtime.start_realtime_mode(RealtimeMode.JOINT_POSITION)
        assert realtime.received("start_realtime_mode")[0].args == (0, 100.0, 0.02)
    assert realtime.commands[2:] == ["stop", *ENDED, "stop"]


async def test_realtime_mode_is_ended_by_a_stop(robot: aioduco.Robot, realtime: Desk) -> None:
    await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    await robot.stop()
    assert realtime.commands == ["start_realtime_mode", "stop", *ENDED, "stop"]
    await robot.aclose()
    assert len(realtime.commands) == 5


async def test_realtime_mode_that_was_ended_leaves_nothing_to_end(
    robot: aioduco.Robot, realtime: Desk
) -> None:
    await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    await robot.realtime.end_realtime_mode()
    await robot.aclose()
    assert realtime.commands == ["start_realtime_mode", *ENDED]  # nothing is left to the next


@pytest.mark.parametrize("by", ["end", "stop"])
async def test_an_older_controller_has_no_queue_to_empty(
    realtime: Desk, caplog: pytest.LogCaptureFixture, by: str
) -> None:
    with FaultProxy(realtime.host, realtime.port) as proxy:
        proxy.on(ENDED[1], ApplicationError(1, "Invalid method name"), times=None)
        async with aioduco.connect(proxy.host, proxy.port) as robot:
            await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
            await (robot.realtime.end_realtime_mode() if by == "end" else robot.stop())
        assert len(proxy.calls(ENDED[0])) == len(proxy.calls(ENDED[1])) == 1
    assert ("stop" in realtime.commands) is (by == "stop")
    assert reporter.flush()
    assert not caplog.text


async def test_realtime_mode_that_was_refused_leaves_nothing_to_end(
    robot: aioduco.Robot, realtime: Desk
) -> None:
    realtime.answer("start_realtime_mode", 7)
    with pytest.raises(aioduco.TaskIllegal):
        await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    await robot.aclose()
    assert realtime.commands == ["start_realtime_mode"]


async def test_realtime_mode_that_may_be_on_is_ended(robot: aioduco.Robot, realtime: Desk) -> None:
    realtime.answer("start_realtime_mode", 1)
    with pytest.raises(aioduco.OutcomeUnknown):
        await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    assert realtime.commands == ["start_realtime_mode", "stop", *ENDED, "stop"]


async def test_cancelling_the_start_of_realtime_mode_stops_the_arm(
    robot: aioduco.Robot, realtime: Desk
) -> None:
    gate = realtime.hold("start_realtime_mode")
    async with anyio.create_task_group() as tg:
        tg.start_soon(robot.realtime.start_realtime_mode, RealtimeMode.TWIST)
        await eventually_async(lambda: realtime.received("start_realtime_mode"))
        tg.cancel_scope.cancel()
        gate.set()  # the stop must not overtake what is under way
    assert tg.cancel_scope.cancelled_caught
    assert realtime.commands[1:3] == ["stop", "end_realtime_mode"]


@pytest.mark.parametrize(
    "refusal", [-1, ApplicationError(6, "no such mode is on")], ids=["-1", "error"]
)
async def test_a_stop_empties_the_queue_of_a_mode_whose_end_is_refused(
    robot: aioduco.Robot, realtime: Desk, refusal: object
) -> None:
    """The mode is off then, and who starts it again would begin with what is left."""
    await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    realtime.answer("end_realtime_mode", refusal)
    await robot.stop()
    assert realtime.commands == ["start_realtime_mode", "stop", *ENDED, "stop"]


async def test_realtime_mode_that_cannot_be_ended_becomes_a_stop(
    robot: aioduco.Robot, realtime: Desk
) -> None:
    await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    realtime.answer("end_realtime_mode", 6)
    with pytest.raises(aioduco.TaskFailed, match="end_realtime_mode"):
        await robot.realtime.end_realtime_mode()
    assert "stop" in realtime.commands


async def test_realtime_mode_that_somebody_has_paused_becomes_a_stop(
    robot: aioduco.Robot, realtime: Desk
) -> None:
    """The arm is on its way, and the program's next motion would move it from there."""
    await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    realtime.states[1] = ProgramState.PAUSED
    with pytest.raises(aioduco.TaskStopped, match="paused"):
        await robot.realtime.end_realtime_mode()
    assert realtime.commands[1:] == ["stop", *ENDED, "stop"]


async def test_a_mode_that_is_not_entered_says_why(robot: aioduco.Robot, realtime: Desk) -> None:
    realtime.errors = ["an old error"]
    realtime.fails("start_realtime_mode", 8, "torques are not followed")
    with pytest.raises(aioduco.TaskParameterMismatch) as failed:
        await robot.realtime.start_realtime_mode(RealtimeMode.JOINT_TORQUE)
    assert failed.value.errors == ("torques are not followed",)
    await robot.stop()
    assert "end_realtime_mode" not in realtime.commands


async def test_a_full_realtime_queue_says_that_it_is(robot: aioduco.Robot, realtime: Desk) -> None:
    realtime.answer("realtime_data_enqueue", -1)
    with pytest.raises(aioduco.Refused, match="no room for the points"):
        await robot.realtime.realtime_data_enqueue([RealtimePoint.joint_position(HOME)])


async def test_points_of_two_modes_do_not_mix(robot: aioduco.Robot, realtime: Desk) -> None:
    points = [RealtimePoint.joint_position(HOME), RealtimePoint.joint_velocity([0.0] * 6)]
    with pytest.raises(aioduco.ParameterError, match=r"points\[1\]"):
        await robot.realtime.realtime_data_enqueue(points)
    with pytest.raises(aioduco.ParameterError, match="at least one"):
        await robot.realtime.realtime_data_enqueue([])
    assert realtime.commands == []
