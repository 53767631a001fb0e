"""Motions that are answered only at their end, and the mode in which the arm follows a queue."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import anyio
import pytest
from client.bench import HOME, BenchTask
from moments import cancelled_once

import aioduco
from aioduco import HeartbeatState, RealtimeMode, RealtimePoint
from aioduco.testing import Cut, FaultProxy, Place, eventually, eventually_async

if TYPE_CHECKING:
    from api.desk import Desk


def replays(desk: Desk, answer: int | None = None) -> None:
    """Have `replay` move the arm, and answer when it stands, or at once with an answer."""

    def replay(*_: Any) -> int:
        now = time.monotonic()
        task_id = desk._add(BenchTask("replay", now, now + desk.motion_time))
        if answer is not None:
            return task_id if answer > 8 else answer
        eventually(lambda: not desk.moving(), 60.0)  # as a controller that blocks
        return int(desk.tasks[task_id].state or desk.task_state(task_id))

    desk.answer("replay", replay)


async def test_a_replay_returns_at_its_end(robot: aioduco.Robot, desk: Desk) -> None:
    desk.motion_time = 0.1
    replays(desk)
    await robot.motion.replay("track", 50, 0)
    assert not desk.moving()
    assert "stop" not in desk.commands


@pytest.mark.slow
async def test_a_replay_lasts_longer_than_a_call_may_take(desk: Desk) -> None:
    desk.motion_time = 1.5
    replays(desk)
    async with aioduco.connect(desk.host, desk.port, call_timeout=1.0, pool_size=1) as robot:
        await robot.motion.replay("track", 50, 0)
        assert not desk.moving()


async def test_a_replay_that_is_answered_with_an_id_is_followed(
    robot: aioduco.Robot, desk: Desk
) -> None:
    desk.motion_time = 0.1
    replays(desk, answer=1000)
    await robot.motion.replay("track", 50, 0)
    assert not desk.moving()
    desk.motion_time = 30.0
    async with cancelled_once(desk.moving):
        await robot.motion.replay("track", 50, 0)
    assert not desk.moving()
    assert desk.commands[:3] == ["replay", "replay", "stop"]
    # If it was cancelled before its answer came, the arm is stopped once more when it has come.
    assert set(desk.commands[3:]) <= {"stop"}


@pytest.mark.parametrize(
    ("answer", "error"),
    [(6, aioduco.TaskFailed), (7, aioduco.TaskIllegal), (-1, aioduco.Refused)],
)
async def test_a_replay_that_fails(
    robot: aioduco.Robot, desk: Desk, answer: int, error: type[Exception]
) -> None:
    desk.answer("replay", answer)
    with pytest.raises(error, match="replay"):
        await robot.motion.replay("track", 50, 0)


async def test_cancelling_a_replay_stops_the_arm(robot: aioduco.Robot, desk: Desk) -> None:
    desk.motion_time = 30.0
    replays(desk)
    async with cancelled_once(desk.moving) as scope:
        await robot.motion.replay("track", 50, 0)
    assert scope.cancelled_caught
    assert not desk.moving()


async def test_a_stop_ends_a_replay(robot: aioduco.Robot, desk: Desk) -> None:
    desk.motion_time = 30.0
    replays(desk)
    async with anyio.create_task_group() as tg:

        async def stop() -> None:
            await eventually_async(desk.moving)
            await robot.stop()

        tg.start_soon(stop)
        with pytest.raises(aioduco.TaskStopped):
            await robot.motion.replay("track", 50, 0)
    assert not desk.moving()


async def test_leaving_the_robot_stops_a_replay(desk: Desk) -> None:
    desk.motion_time = 30.0
    replays(desk)
    async with anyio.create_task_group() as tg, aioduco.connect(desk.host, desk.port) as robot:

        async def replay() -> None:
            with pytest.raises((aioduco.TaskStopped, aioduco.ConnectionLost)):
                await robot.motion.replay("track", 50, 0)

        tg.start_soon(replay)
        await eventually_async(desk.moving)
    assert not desk.moving()


@pytest.mark.slow
async def test_a_replay_whose_answer_is_lost_is_stopped(desk: Desk) -> None:
    desk.motion_time = 30.0
    replays(desk)
    async with (
        FaultProxy(desk.host, desk.port) as proxy,
        aioduco.connect(proxy.host, proxy.port) as robot,
    ):
        proxy.on("replay", Cut(Place.AFTER_REQUEST))
        with pytest.raises(aioduco.OutcomeUnknown):
            await robot.motion.replay("track", 50, 0)
        assert "stop" in desk.commands
        assert not desk.moving()


async def test_without_a_heartbeat_nothing_is_replayed(desk: Desk) -> None:
    async with aioduco.connect(desk.host, desk.port, heartbeat=0.2) as robot:
        gate = desk.hold("rpc_heartbeat", None)
        await eventually_async(lambda: beats(robot) is not HeartbeatState.BEATING)
        with pytest.raises(aioduco.HeartbeatLost, match="replay was not sent"):
            await robot.motion.replay("track", 50, 0)
        gate.set()
    assert "replay" not in desk.commands


def beats(robot: aioduco.Robot) -> HeartbeatState:
    assert robot.heartbeat is not None
    return robot.heartbeat.state


# -- realtime control ------------------------------------------------------------------------------


@pytest.fixture
def realtime(desk: Desk) -> Desk:
    for name in ("start_realtime_mode", "end_realtime_mode", "realtime_data_enqueue"):
        desk.answer(name, 4)
    return desk


async def test_realtime_mode_is_ended_when_the_robot_is_left(realtime: Desk) -> None:
    async with aioduco.connect(realtime.host, realtime.port) as robot:
        await robot.realtime.realtime_data_enqueue([RealtimePoint.joint_position(HOME)])
        await robot.realtime.start_realtime_mode(RealtimeMode.JOINT_POSITION)
        assert realtime.received("start_realtime_mode")[0].args == (0, 100.0, 0.02)
    assert realtime.commands[2:] == ["stop", "end_realtime_mode", "stop"]


async def test_realtime_mode_is_ended_by_a_stop(robot: aioduco.Robot, realtime: Desk) -> None:
    await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    await robot.stop()
    assert realtime.commands == ["start_realtime_mode", "stop", "end_realtime_mode", "stop"]
    await robot.aclose()
    assert len(realtime.commands) == 4


async def test_realtime_mode_that_was_ended_leaves_nothing_to_end(
    robot: aioduco.Robot, realtime: Desk
) -> None:
    await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    await robot.realtime.end_realtime_mode()
    await robot.aclose()
    assert realtime.commands == ["start_realtime_mode", "end_realtime_mode"]


async def test_realtime_mode_that_was_refused_leaves_nothing_to_end(
    robot: aioduco.Robot, realtime: Desk
) -> None:
    realtime.answer("start_realtime_mode", 7)
    with pytest.raises(aioduco.TaskIllegal):
        await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    await robot.aclose()
    assert realtime.commands == ["start_realtime_mode"]


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


async def test_realtime_mode_that_cannot_be_ended_becomes_a_stop(
    robot: aioduco.Robot, realtime: Desk
) -> None:
    await robot.realtime.start_realtime_mode(RealtimeMode.TWIST)
    realtime.answer("end_realtime_mode", 6)
    with pytest.raises(aioduco.TaskFailed, match="end_realtime_mode"):
        await robot.realtime.end_realtime_mode()
    assert "stop" in realtime.commands


async def test_points_of_two_modes_do_not_mix(robot: aioduco.Robot, realtime: Desk) -> None:
    points = [RealtimePoint.joint_position(HOME), RealtimePoint.joint_velocity([0.0] * 6)]
    with pytest.raises(aioduco.ParameterError, match=r"points\[1\]"):
        await robot.realtime.realtime_data_enqueue(points)
    with pytest.raises(aioduco.ParameterError, match="at least one"):
        await robot.realtime.realtime_data_enqueue([])
    assert realtime.commands == []
