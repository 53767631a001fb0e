"""What was asked for before a stop is not sent after it, whatever had to be read first.

Each function that can move the arm is asked for with an envelope, so that as much as possible is
read before it is sent. Then each of these reads hangs while the arm is stopped.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import threading
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import anyio
import pytest
from client.bench import FLANGE, HOME, POSE
from moments import on_another_thread
from wire.lanes import noted

import aioduco
from aioduco import Joints, JointTrajectory, RealtimeMode, RealtimePoint, WorkerOptions
from aioduco.devices.teleoperation import teleoperate
from aioduco.envelope import Envelope, Zone
from aioduco.recording.playback import WaypointFile, run_waypoints
from aioduco.streaming.stream import Stream
from aioduco.supervision.command import MotionCommand
from aioduco.testing import eventually_async
from api.cases import Case, blocking_cases, cases
from api.desk import HELD, Desk

_Call = Callable[[aioduco.Robot], Coroutine[Any, Any, object]]

#: what the robot asks for by itself, all the time
_BY_ITSELF = {
    "rpc_heartbeat",
    "getRobotStatus",
    "getRobotIOStatus",
    "robotmoving",
    "get_noneblock_taskstate",
    "get_robot_state",
}
_READ = {
    "get_tcp_offset": [0.0] * 6,
    "get_wobj": [0.0] * 6,
    "get_flange_pose": FLANGE,
    "get_tcp_pose_coord": POSE,
    "get_actual_joints_position": HOME,
    "get_tcp_pose": POSE,
    "get_last_error": [],
}
_THREAD = WorkerOptions(run_in="thread")
#: far below the arm, so that what it does is read, and allowed
_ENVELOPE = Envelope("gcr5_910", Zone.plane((0, 0, -5.0), (0, 0, 1)))


def _in_other_frames() -> list[Case]:
    """The motions that read the tool's pose before they are sent."""
    found = []
    for case in cases():
        if case.moves and "frame" in case.parameters and case.section == "motion":
            changed: dict[str, Any] = {"frame": "base"}
            if case.name == "speedl":
                changed["twist"] = [0.0, 0.0, -0.01, 0.0, 0.0, 0.0]
            found.append(replace(case, args=case.args | changed))
    return found


MOVING = [
    case
    for case in (*cases(), *_in_other_frames(), *blocking_cases())
    if case.moves and case.section != "external_axes"
]


def _asks(robot: aioduco.Robot, case: Case) -> Callable[[], Awaitable[object]]:
    """Ask for it by an await, or by `start`, where it would otherwise be waited for."""
    made = case.method(robot)(**case.args)
    if isinstance(made, MotionCommand):
        return made.start

    async def awaited() -> object:
        return await made

    return awaited


async def _stopped(case: Case, held: str = "") -> tuple[list[str], BaseException | None]:
    """Ask for something, and stop the arm when it was sent, or while a read hangs.

    Args:
        case: what is asked for.
        held: the read that hangs until the stop has returned; empty to let it be sent.

    Returns:
        The functions that arrived since it was asked for, and what it raised.
    """
    with Desk() as desk:
        desk.motion_time = 30.0
        if case.name not in HELD:
            desk.moves(case.name)
        if case.section == "blocking":
            desk.blocks(case.name)
        for name, answer in _READ.items():
            desk.answer(name, answer)
        async with aioduco.connect(desk.host, desk.port) as robot:
            robot.envelope = _ENVELOPE
            raised: list[BaseException] = []

            awaited = held or case.name
            gate = desk.hold(held, _READ[held]) if held else None
            begin = len(desk.received())
            before = len(desk.received(awaited))
            async with anyio.create_task_group() as group:
                asked = _asks(robot, case)()
                group.start_soon(noted, raised, aioduco.DucoError, asked)
                await eventually_async(lambda: len(desk.received(awaited)) > before or raised)
                await robot.stop()
                if gate is not None:
                    gate.set()
        names = [call.method for call in desk.received()[begin:]]
        return names, raised[0] if raised else None


@pytest.mark.cases(1)
@pytest.mark.parametrize("case", MOVING, ids=lambda case: f"{case.section}-{case.name}")
async def test_what_reads_before_it_is_sent_is_not_sent_after_a_stop(case: Case) -> None:
    names, error = await _stopped(case)
    assert case.name in names, error
    reads = {one for one in names[: names.index(case.name)] if one not in _BY_ITSELF}
    assert reads
    for read in sorted(reads):
        names, error = await _stopped(case, read)
        assert case.name not in names, f"sent after the stop that came while {read} was read"
        assert isinstance(error, aioduco.TaskStopped), read
        assert "was not sent" in str(error)


def into_realtime(robot: aioduco.Robot) -> Coroutine[Any, Any, None]:
    return robot.realtime.start_realtime_mode(RealtimeMode.JOINT_POSITION)


async def into_track(robot: aioduco.Robot) -> None:
    await robot.track.trackEnqueue([Joints(*HOME)])
    await robot.track.trackJointMotion(1.0, 2.0).start()


async def refused_by_a_stop(
    desk: Desk, robot: aioduco.Robot, ask: Callable[[], Awaitable[object]], read: threading.Event
) -> None:
    """Ask for something that reads the tool first, and stop the arm before that is answered."""
    raised: list[BaseException] = []

    async with anyio.create_task_group() as group:
        group.start_soon(noted, raised, aioduco.DucoError, ask())
        await eventually_async(lambda: desk.received("get_tcp_offset"))
        await robot.stop()
        read.set()
    assert [type(each) for each in raised] == [aioduco.TaskStopped]


FED: dict[str, tuple[Callable[[aioduco.Robot], Awaitable[None]], _Call]] = {
    "realtime_data_enqueue": (
        into_realtime,
        lambda robot: robot.realtime.realtime_data_enqueue([RealtimePoint.joint_position(HOME)]),
    ),
    "trackEnqueue": (into_track, lambda robot: robot.track.trackEnqueue([Joints(*HOME)])),
}


@pytest.mark.parametrize("name", FED)
async def test_points_whose_check_reads_while_the_arm_is_stopped_are_not_sent(
    desk: Desk, name: str
) -> None:
    begin, feed = FED[name]
    desk.motion_time = 30.0
    desk.moves("trackJointMotion")
    for each in ("trackEnqueue", "trackClearQueue", "start_realtime_mode", "end_realtime_mode"):
        desk.answer(each, 4)
    desk.answer("realtime_data_enqueue", 4)
    desk.answer("get_wobj", [0.0] * 6)
    async with aioduco.connect(desk.host, desk.port) as robot:
        await begin(robot)
        before = len(desk.received(name))
        read = desk.hold("get_tcp_offset", [0.0] * 6)
        robot.envelope = _ENVELOPE
        await refused_by_a_stop(desk, robot, lambda: feed(robot), read)
        assert len(desk.received(name)) == before


STREAMS: dict[str, Callable[[aioduco.Robot], Stream]] = {
    "servo": lambda robot: robot.servo.joints(v=1.0, a=5.0, options=_THREAD),
    "servo in space": lambda robot: robot.servo.linear(v=1.0, a=5.0, options=_THREAD),
    "realtime": lambda robot: robot.realtime.stream("joint_position", v=1, a=5, options=_THREAD),
    "track": lambda robot: robot.track.stream("joints", speed=1, acc=5, options=_THREAD),
}


@pytest.mark.parametrize("kind", STREAMS)
async def test_a_stream_whose_envelope_is_read_while_the_arm_is_stopped_is_not_opened(
    desk: Desk, kind: str
) -> None:
    for name, answer in _READ.items():
        desk.answer(name, answer)
    async with aioduco.connect(desk.host, desk.port) as robot:
        robot.envelope = _ENVELOPE
        read = desk.hold("get_tcp_offset", [0.0] * 6)
        stream = STREAMS[kind](robot)
        await refused_by_a_stop(desk, robot, stream.__aenter__, read)


# -- called before a stop, begun after it ----------------------------------------------------------


def _line() -> JointTrajectory:
    return JointTrajectory([Joints(*HOME), Joints(*HOME)], [0.0, 1.0])


def _taught() -> WaypointFile:
    waypoints = WaypointFile.new(arm="GCR5 910")
    waypoints.add("home", HOME)
    return waypoints


def _blocking(case: Case, robot: aioduco.Robot) -> Coroutine[Any, Any, object]:
    called: Coroutine[Any, Any, object] = case.method(robot)(**case.args)
    return called


CALLED: dict[str, _Call] = {
    "start": lambda robot: robot.motion.movej2(HOME, v=1.0, a=1.0).start(),
    "run": lambda robot: robot.motion.run(robot.motion.movej2(HOME, v=1.0, a=1.0)),
    "follow_joint_trajectory": lambda robot: robot.motion.follow_joint_trajectory(
        _line(), v=1.0, a=1.0
    ),
    "replay": lambda robot: robot.motion.replay("track 1", 50, 1),
    "resume": lambda robot: robot.resume(),
    "start_realtime_mode": into_realtime,
    "realtime_data_enqueue": FED["realtime_data_enqueue"][1],
    "teleoperate": lambda robot: teleoperate(robot, SimpleNamespace()),
    "run_waypoints": lambda robot: run_waypoints(robot, _taught()),
    **{f"blocking.{case.name}": partial(_blocking, case) for case in blocking_cases()},
}


@pytest.mark.cases(8)
@pytest.mark.parametrize("name", CALLED)
async def test_what_was_called_before_a_stop_and_begins_after_it_is_not_sent(
    desk: Desk, name: str
) -> None:
    async with aioduco.connect(desk.host, desk.port) as robot:
        begun = asyncio.ensure_future(CALLED[name](robot))
        robot.stop_now()  # the task has not run once
        sent = len(desk.received())
        with pytest.raises(aioduco.TaskStopped, match="was not sent"):
            await begun
        assert {call.method for call in desk.received()[sent:]} <= _BY_ITSELF | {"stop"}


async def test_a_stop_ends_what_another_thread_has_handed_over(
    desk: Desk, robot: aioduco.Robot
) -> None:
    loop = asyncio.get_running_loop()
    handed_over: list[concurrent.futures.Future[object]] = []

    def hand_over() -> None:
        handed_over.append(asyncio.run_coroutine_threadsafe(CALLED["start"](robot), loop))
        robot.stop_now()

    on_another_thread(hand_over)  # the event loop cannot run meanwhile
    with pytest.raises(aioduco.TaskStopped, match="was not sent"):
        await asyncio.wrap_future(handed_over[0])
    assert not desk.received("movej2")


class _Plan:
    """Reads where the arm is, and follows a line."""

    arm = "GCR5 910"

    async def run_on(
        self, motion: Any, read_joints: Any, **options: Any
    ) -> aioduco.TrajectoryResult | None:
        await read_joints()
        found: aioduco.TrajectoryResult = await CALLED["follow_joint_trajectory"](
            SimpleNamespace(motion=motion)  # type: ignore[arg-type]  # all that it asks of a robot
        )
        return found


@pytest.mark.parametrize(
    ("call", "read"),
    [
        (CALLED["follow_joint_trajectory"], "get_realtime_data_queue_size"),
        (lambda robot: robot.motion.execute(_Plan()), "get_actual_joints_position"),
    ],
)
async def test_a_pause_ends_a_path_whose_stream_is_not_open_yet(
    desk: Desk, robot: aioduco.Robot, call: _Call, read: str
) -> None:
    """The arm stood, so that nothing was paused, and it began to move after that."""
    desk.answer("get_realtime_data_queue_size", 0)
    held = desk.hold(read, {**_READ, "get_realtime_data_queue_size": 0}[read])
    begun = asyncio.ensure_future(call(robot))
    await eventually_async(lambda: bool(desk.received(read)))
    await robot.pause()
    held.set()
    with pytest.raises(aioduco.TaskStopped, match="was not sent"):
        await begun


async def test_a_pause_ends_what_an_undertaking_has_called_and_not_begun(
    desk: Desk, robot: aioduco.Robot
) -> None:
    desk.moves("movej2")
    with robot.permit("two motions"):
        begun = asyncio.ensure_future(CALLED["start"](robot))
        await robot.pause()
        with pytest.raises(aioduco.TaskStopped, match="was not sent"):
            await begun
        assert not desk.received("movej2")
        await CALLED["run"](robot)  # called after it
