"""The realtime queue and the track pool: kept filled, and ended in order."""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
import itertools
import math
import threading
from collections.abc import Callable
from typing import Any, cast

import anyio
import numpy as np
import pytest
from for_each import for_each

from aioduco._wire.rpc import PointOp, RealTimeControlData
from aioduco.api.streams.realtime import CYCLE, RealtimeStreams
from aioduco.api.streams.servo import Servo
from aioduco.api.streams.track import TrackStreams
from aioduco.errors import (
    FirstPointTooFar,
    ParameterError,
    StreamError,
    StreamLost,
    StreamRefused,
    StreamStarved,
    StreamStopped,
)
from aioduco.models.op import Op, output
from aioduco.models.pose import Pose
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.shared.words import Reason, StreamState
from aioduco.streaming.stream import Stream
from aioduco.streaming.worker import driver
from aioduco.testing import (
    ApplicationError,
    RecordingServer,
    eventually,
    eventually_async,
    no_leaks,
)

from .conftest import HERE, Controller, Cycles, answer_all, at, fed, near

#: a busy machine may take long over an answer
PROCESS, THREAD = (
    WorkerOptions(run_in="process", timeout=20.0),
    WorkerOptions(run_in="thread", timeout=20.0),
)
workers = pytest.mark.parametrize("options", [THREAD, PROCESS], ids=["thread", "process"])


# -- realtime queue ----------------------------------------------------------------------------

#: what is called at its end: the mode, then the points that are left
ENDED = ["end_realtime_mode", "clear_realtime_data_queue"]


@pytest.fixture
def queue(controller: Controller) -> Cycles:
    cycles = Cycles(CYCLE)
    answer_all(controller.server, cycles.answers)
    return cycles


def of_positions(controller: Controller, a: float = 5.0, **options: Any) -> Stream:
    """A realtime stream of joint positions."""
    options = {"options": THREAD, **options}
    return RealtimeStreams(controller.endpoint).stream("joint_position", v=1.0, a=a, **options)


def positions(queue: Cycles) -> Any:
    return np.array([point.joint_pos_cmd for point in queue.points])


@pytest.mark.parametrize("name", ["max_step", "reach"])
@pytest.mark.parametrize(
    ("mode", "limit"), [("twist", (0.1, 0.5)), ("joint_velocity", 0.5)], ids=["twist", "joints"]
)
def test_of_speeds_there_is_no_step_and_no_reach(name: str, mode: str, limit: Any) -> None:
    with pytest.raises(ParameterError, match=f"{name} is .*left out: it is for positions alone"):
        RealtimeStreams(Controller.nowhere()).stream(mode, v=limit, a=limit, **{name: limit})


@pytest.mark.parametrize(("name", "given"), [("upsample", "linear"), ("chunks", True)])
def test_speeds_have_no_upsampling_and_no_chunks(name: str, given: Any) -> None:
    fed: dict[str, Any] = {"source_rate": 30, "upsample": "cubic", name: given}
    with pytest.raises(ParameterError, match=f"{name} is .*left out: it is for positions alone"):
        RealtimeStreams(Controller.nowhere()).stream("twist", v=0.1, a=0.5, **fed)


def test_offsets_have_no_chunks() -> None:
    wrong: Any = {"source_rate": 30, "upsample": "cubic", "chunks": True}
    with pytest.raises(ParameterError, match=r"chunks is True, .*for positions alone"):
        Servo(Controller.nowhere()).tcp_offset(v=0.1, a=0.5, **wrong)


def test_the_rate_of_the_queue_is_the_controllers() -> None:
    wrong: Any = {"rate": 500.0}
    with pytest.raises(ParameterError, match=r"rate is 500\.0, .*give source_rate"):
        RealtimeStreams(Controller.nowhere()).stream("joint_position", v=1.0, a=1.0, **wrong)


@pytest.mark.cases(1)
@workers
async def test_an_array_goes_through_the_queue_from_rest_to_rest(
    controller: Controller, queue: Cycles, options: WorkerOptions
) -> None:
    trajectory = np.array([near(0.0), near(0.1), near(0.0)])
    opened = of_positions(controller, 50.0, depth=60, options=options)
    async with no_leaks():
        async with opened as stream:
            await stream.play(trajectory, [0.0, 0.2, 0.4])
        statistics = stream.statistics()
    places = positions(queue)
    # The queue begins with where the arm is, and ends with nothing but rest.
    np.testing.assert_allclose(places[:60], [HERE] * 60, atol=1e-12)
    np.testing.assert_allclose(places[-60:], [HERE] * 60, atol=1e-9)
    assert np.abs(np.diff(places, axis=0)).max() <= 1.0 * CYCLE * (1 + 1e-6)
    moving = [tuple(place) for place, _ in itertools.groupby(map(tuple, places))]
    assert 395 <= len(moving) <= 405
    assert all(point.status for point in queue.points)
    assert statistics.reason is Reason.CLOSED
    assert statistics.queue.samples > 0
    order = [name for name in controller.names() if name not in ("get_robot_state",)]
    assert order[:4] == [
        "get_actual_joints_position",
        "clear_realtime_data_queue",
        "realtime_data_enqueue",
        "start_realtime_mode",
    ]
    assert order[-2:] == ENDED
    assert controller.server.received("start_realtime_mode")[0].args == (0, 100.0, 0.02)


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("frame", "read", "back"),
    [("base", "get_wobj", True), ("tool", "get_tcp_pose_coord", False), ("wobj", "", True)],
)
async def test_a_twist_is_turned_into_the_frame_of_the_work_object(
    controller: Controller, queue: Cycles, frame: Any, read: str, back: bool
) -> None:
    controller.server.answer("get_wobj", [0.3, 0.1, 0.2, 0.4, -0.2, 0.7])
    place = Pose(0.5, 0.1, 0.4, 3.0, 0.0, 1.0) if frame == "tool" else Pose(0, 0, 0, 0.4, -0.2, 0.7)
    opened = RealtimeStreams(controller.endpoint).stream(
        "twist", v=(0.25, 1.0), a=(1.0, 5.0), frame=frame, options=THREAD
    )
    async with opened as stream:
        await stream.play([[0.0, 0.0, 0.1, 0.2, 0.0, 0.0]] * 300)
    fastest = max(queue.points, key=lambda point: math.hypot(*point.cart_vel_tool_wobj_cmd[:3]))
    turn = np.eye(3) if frame == "wobj" else place.matrix[:3, :3]
    turn = turn.T if back else turn
    np.testing.assert_allclose(fastest.cart_vel_tool_wobj_cmd[:3], turn @ [0, 0, 0.1], atol=1e-9)
    np.testing.assert_allclose(fastest.cart_vel_tool_wobj_cmd[3:], turn @ [0.2, 0, 0], atol=1e-9)
    reads = [name for name in controller.names() if name.startswith(("get_wobj", "get_tcp"))]
    assert set(reads) == ({read} if read else set())


async def test_the_queue_is_never_filled_beyond_its_depth(
    controller: Controller, queue: Cycles
) -> None:
    depths: list[int] = []

    def enqueue(points: list[RealTimeControlData], block: bool) -> int:
        answer = queue.enqueue(points, block)
        depths.append(queue.size())
        return answer

    controller.server.answer("realtime_data_enqueue", enqueue)
    async with of_positions(controller, 50.0, depth=30) as stream:
        await stream.play([near(0.0)] * 300)
    assert max(depths) <= 30


@pytest.mark.slow
async def test_a_stall_of_the_event_loop_does_not_reach_the_controller(
    controller: Controller, queue: Cycles
) -> None:
    count = 700
    trajectory = [near(0.02 * (1 - math.cos(math.pi * n / 350))) for n in range(count + 1)]
    opened = of_positions(controller, 50.0, depth=100, options=PROCESS)
    async with opened as stream, anyio.create_task_group() as tasks:
        tasks.start_soon(stream.play, trajectory)
        await eventually_async(lambda: len(queue.points) > 120)
        # It blocks the event loop, but not the threads that the controller answers from.
        eventually(lambda: len(queue.points) > 420)
    assert stream.statistics().starved == 0
    np.testing.assert_allclose(positions(queue)[-1], trajectory[-1], atol=1e-9)


async def test_speeds_are_ramped_and_end_at_zero(controller: Controller, queue: Cycles) -> None:
    opened = RealtimeStreams(controller.endpoint).stream(
        "joint_velocity", v=0.5, a=5.0, latest=True, options=THREAD
    )
    async with opened as stream:
        async for tick in stream.ticks(100.0):
            await stream.send([0.2, 0.0, 0.0, 0.0, 0.0, -0.2])
            if tick.number == 20:
                break
    speeds = np.array([point.joint_vel_cmd for point in queue.points])
    assert np.abs(np.diff(speeds, axis=0)).max() <= 5.0 * CYCLE * (1 + 1e-6)
    assert speeds[:, 0].max() == pytest.approx(0.2)
    assert not speeds[-40:].any()


async def test_the_mode_ends_when_the_controllers_filter_has_let_the_arm_arrive(
    controller: Controller, queue: Cycles
) -> None:
    """At 10 Hz its time constant is 16 points: it takes more than the queue holds."""
    async with of_positions(controller, filter_bandwidth=10.0) as stream:
        await stream.send(HERE)
        await stream.send(near(1e-3))
    resting = queue.points[: queue.taken].count(queue.points[-1])
    assert math.exp(-resting / 16) < 1e-4


async def test_a_cancellation_does_not_wait_for_the_controllers_filter(
    controller: Controller, queue: Cycles
) -> None:
    stream = of_positions(controller, filter_bandwidth=0.05)

    async def left() -> None:
        async with stream:
            await stream.send(HERE)

    leaving = asyncio.create_task(left())
    await eventually_async(lambda: stream.state is StreamState.DECELERATING)
    leaving.cancel()
    with pytest.raises(asyncio.CancelledError):
        await leaving
    assert queue.taken < 30_000  # 10 time constants are 32,000 points
    assert controller.names()[-3:] == [*ENDED, "get_robot_state"]


async def test_starving_ends_in_rest_then_the_mode_then_a_stop(
    controller: Controller, queue: Cycles
) -> None:
    opened = of_positions(controller, hold=0.05)
    with pytest.raises(StreamStarved):
        await fed(opened, (near(2e-6 * n * n) for n in range(200)), opened.ended)
    places = positions(queue)
    assert np.abs(np.diff(np.diff(places, axis=0), axis=0)).max() / CYCLE**2 <= 5.0 * (1 + 1e-6)
    assert (places[-40:] == places[-1]).all()
    assert controller.names()[-3:] == ["end_realtime_mode", "stop", "clear_realtime_data_queue"]


async def test_a_halt_leaves_realtime_mode_and_sends_no_stop(
    controller: Controller, queue: Cycles
) -> None:
    opened = of_positions(controller)
    with pytest.raises(StreamStopped):
        await fed(opened, [HERE], opened.halt)
    assert controller.names()[-2:] == ENDED


async def test_the_queue_of_a_mode_whose_end_is_refused_is_emptied(
    controller: Controller, queue: Cycles
) -> None:
    controller.server.answer("end_realtime_mode", ApplicationError(6, "no such mode is on"))
    opened = of_positions(controller)
    with pytest.raises(StreamStopped):
        await fed(opened, [HERE], opened.halt)
    assert controller.names()[-2:] == ENDED


async def test_a_refused_mode_is_an_error_and_nothing_moves(
    controller: Controller, queue: Cycles
) -> None:
    controller.server.answer("start_realtime_mode", 7)
    opened = RealtimeStreams(controller.endpoint).stream("pose", v=0.1, a=0.5, options=THREAD)
    with pytest.raises(StreamRefused, match="start_realtime_mode answered 7"):
        await fed(opened, [[0.5, 0.1, 0.4, 3.0, 0.0, 1.0]])
    # the first points are not followed by whoever starts the mode next
    assert controller.names()[-1] == "clear_realtime_data_queue"
    assert controller.server.received("get_tcp_pose_coord")[0].args == ("", "")


async def test_where_nothing_was_sent_that_moves_the_arm_nothing_is_stopped(
    controller: Controller, queue: Cycles
) -> None:
    controller.server.answer("clear_realtime_data_queue", 7)
    with pytest.raises(StreamRefused, match="if anything was sent that moves the arm"):
        await fed(of_positions(controller), [HERE])
    assert not controller.server.received("stop")


OLDER = ["an older one"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("then", "error", "said"),
    [
        ({}, StreamStopped, r"reports no error: another program, or a person, has probably"),
        (
            {"get_last_error": [*OLDER, "no data for 0.02 s"]},
            StreamRefused,
            r"takes no points.*error list: no data for 0\.02 s",
        ),
        ({"get_robot_state": [6, 0, 7, 1]}, StreamRefused, "takes no points"),
        ({"get_robot_state": []}, StreamRefused, "takes no points.*was stopped .*or an error"),
    ],
    ids=["stopped", "an error", "a safety stop", "no states"],
)
@pytest.mark.parametrize("closed", [False, True], ids=["in full course", "after the last point"])
async def test_a_queue_from_which_nothing_is_taken_any_more_ends_the_stream(
    controller: Controller,
    queue: Cycles,
    then: dict[str, Any],
    error: type[StreamError],
    said: str,
    *,
    closed: bool,
) -> None:
    """The controller has left realtime mode by itself, and only what it reports says why."""
    controller.server.answer("get_last_error", OLDER)
    opened = of_positions(controller, options=dataclasses.replace(THREAD, timeout=2.0))

    def full() -> None:
        answer_all(controller.server, {"get_realtime_data_queue_size": 40, **then})

    points = [HERE] * 50 if closed else at(100, full)
    with pytest.raises(error, match=said):
        await fed(opened, points, full if closed else None)
    others = [] if error is StreamStopped else ["stop"]  # who has stopped it may move it by now
    ended = ["end_realtime_mode", *others, "clear_realtime_data_queue"]
    assert controller.names()[-len(ended) :] == ended


async def test_an_arm_that_is_disabled_while_it_comes_to_rest_is_told(
    controller: Controller, queue: Cycles
) -> None:
    """Also after the last point was taken: the arm lags behind it."""

    def stands() -> bool:
        controller.server.answer("get_robot_state", [4, 2, 5, 1])
        return False

    opened = of_positions(controller, options=THREAD)
    with pytest.raises(StreamRefused, match="not ENABLE"):
        await fed(opened, [HERE] * 3, lambda: controller.server.answer("robotmoving", stands))
    assert controller.names()[-2:] == ["stop", "clear_realtime_data_queue"]


@pytest.mark.parametrize(
    ("end", "error"),
    [
        (lambda stream, _: stream.halt(), StreamStopped),
        (lambda _, server: server.answer("get_robot_state", [5, 0, 9, 1]), StreamRefused),
        (lambda _, server: server._server.drop(), StreamLost),
    ],
    ids=["halt", "disabled", "lost"],
)
async def test_an_end_while_the_last_points_are_followed_is_told(
    controller: Controller,
    queue: Cycles,
    end: Callable[[Stream, RecordingServer], object],
    error: type[StreamError],
) -> None:
    """The arm is not where the program has led it, and what follows must not begin from there."""
    opened = of_positions(controller, options=dataclasses.replace(THREAD, watch=0.02))

    def left() -> int:
        return 40 if opened.state is StreamState.DECELERATING else 20

    async def ended() -> None:
        await eventually_async(lambda: opened.state is StreamState.DECELERATING)
        end(opened, controller.server)

    controller.server.answer("get_realtime_data_queue_size", left)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(ended)
        with pytest.raises(error):
            await fed(opened, [HERE] * 50)


@for_each("mode", ["joint_torque", 2, "nonsense"])
def test_torques_and_unknown_modes_are_refused(mode: Any) -> None:
    known = '"joint_position", "joint_velocity", "pose" or "twist"'
    with pytest.raises(ParameterError, match=known) as refused:
        RealtimeStreams(Controller.nowhere()).stream(mode, v=1.0, a=1.0)
    assert refused.value.__context__ is None  # one error is shown, and not two


# -- track pool --------------------------------------------------------------------------------


class PoolDrive:
    """A pool that is followed at so many points per look at it."""

    def __init__(self, controller: Controller, per_look: int) -> None:
        self.points: list[Any] = []
        self.taken = 0
        self.running = False
        self.ended = 4
        self.starts = 0
        self._per_look = per_look
        answers = {
            "trackClearQueue": self.clear,
            "trackEnqueue": self.enqueue,
            "trackEnqueueOp": self.enqueue,
            "trackJointMotion": self.start,
            "trackCartMotion": self.start,
            "getQueueSize": self.size,
            "get_noneblock_taskstate": self.state,
        }
        answer_all(controller.server, answers)

    def clear(self) -> int:
        self.taken = len(self.points)
        return 4

    def enqueue(self, points: list[Any], _block: bool) -> int:
        if len(self.points) - self.taken + len(points) > 1000:
            return -1
        self.points += points
        return 4

    def start(self, *_: Any) -> int:
        self.running = True
        self.ended = 4
        self.starts += 1
        return 1234

    def size(self) -> int:
        left = len(self.points) - self.taken
        self.running = self.running and left > 0
        self.taken += min(left, self._per_look) if self.running else 0
        return left

    def state(self, _task: int) -> int:
        if self.taken == len(self.points):
            self.running = False
        return 1 if self.running else self.ended

    def end(self, state: int) -> None:
        """Take no more points, though there are some."""
        self.running, self.ended = False, state


def track(controller: Controller, **options: Any) -> Stream:
    """A stream of joints for the track pool, which begins with few points."""
    few: dict[str, Any] = {"low": 10, "high": 20, "period": 0.005, "options": THREAD}
    return TrackStreams(controller.endpoint).stream("joints", speed=0.5, acc=1.0, **few | options)


@pytest.mark.slow
@workers
async def test_the_pool_stays_between_its_marks_and_every_point_arrives(
    controller: Controller, options: WorkerOptions
) -> None:
    pool = PoolDrive(controller, per_look=30)
    path = [near(1e-4 * n) for n in range(900)]
    opened = TrackStreams(controller.endpoint).stream(
        "joints", speed=0.5, acc=1.0, low=50, high=200, options=options
    )
    async with opened as stream:
        await stream.play(path)
    assert pool.points == path
    assert pool.starts == 1
    levels = stream.statistics().queue
    assert levels.max <= 200
    assert stream.statistics().drained == 0
    assert controller.server.received("trackJointMotion")[0].args == (0.5, 1.0, False)


@workers
@pytest.mark.parametrize("count", [1, 20, 120])
async def test_a_path_that_is_played_is_in_the_pool_when_play_returns(
    controller: Controller, options: WorkerOptions, count: int
) -> None:
    """Also one that has too few points to begin with: no more of it come."""
    pool = PoolDrive(controller, per_look=5)
    path = [near(1e-4 * n) for n in range(count)]
    opened = TrackStreams(controller.endpoint).stream(
        "joints", speed=0.5, acc=1.0, low=50, high=60, hold=60.0, options=options
    )
    async with opened as stream:
        await stream.play(path)
        assert stream.taken == count
        await eventually_async(lambda: pool.points == path)
        assert pool.starts >= 1
        await stream.play(path)  # and it goes on
        assert stream.taken == 2 * count
    assert pool.points == path * 2


async def test_a_path_that_begins_elsewhere_is_refused_by_play(controller: Controller) -> None:
    PoolDrive(controller, per_look=5)
    taken, seen = threading.Event(), threading.Event()

    def place() -> list[float]:
        taken.set()
        assert seen.wait(30.0)
        return [0.0] * 6

    controller.server.answer("get_actual_joints_position", place)
    opened = TrackStreams(controller.endpoint).stream("joints", speed=0.5, acc=1.0, options=THREAD)
    passed: list[str] = []

    async def program() -> None:
        async with opened as stream:
            await stream.play([near(0.2)])
            passed.append("play")

    async def compare() -> None:
        """Tell where the arm is only when the program has seen that the point was taken."""
        await eventually_async(taken.is_set)
        opened._session._wake()
        await anyio.wait_all_tasks_blocked()
        seen.set()

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(compare)
        with pytest.raises(FirstPointTooFar, match=r"joint 1: 0\.2 rad away"):
            await program()
    assert passed == []


async def test_a_path_of_poses_with_outputs(controller: Controller) -> None:
    pool = PoolDrive(controller, per_look=5)
    start = [0.5, 0.1, 0.4, 3.0, 0.0, 1.0]
    opened = TrackStreams(controller.endpoint).stream(
        "pose", speed=0.2, acc=0.5, tool="gun", wobj="part", operations=True, options=THREAD
    )
    on = Op.at_start(output(3))
    async with opened as stream:
        await stream.send(start)
        with pytest.raises(ParameterError, match="an Op, or None"):
            await stream.send(start, cast("Op", 3))
        await stream.send([0.51, *start[1:]], on)
    assert pool.points == [PointOp(start, Op().wire()), PointOp([0.51, *start[1:]], on.wire())]
    assert controller.server.received("trackCartMotion")[0].args == (
        0.2, 0.5, False, "gun", "part", 0.005,
    )  # fmt: skip


async def test_a_pool_that_ran_dry_is_started_again(controller: Controller) -> None:
    pool = PoolDrive(controller, per_look=1000)
    async with track(controller) as stream:
        for n in range(20):
            await stream.send(near(1e-4 * n))
        await eventually_async(lambda: stream.state is StreamState.HOLDING)
        for n in range(20, 40):
            await stream.send(near(1e-4 * n))
        await eventually_async(lambda: len(pool.points) == 40)
    # more often, where this program was too slow to feed it
    assert stream.statistics().drained >= 1
    assert pool.starts >= 2


@pytest.mark.parametrize(
    ("state", "error"), [(4, None), (3, StreamStopped), (6, StreamRefused)], ids=str
)
async def test_a_pool_from_which_nobody_takes_is_started_again_if_its_motion_has_come_to_rest(
    controller: Controller, state: int, error: type[StreamError] | None
) -> None:
    """The pool may run dry in the instant before new points are in it."""
    pool = PoolDrive(controller, per_look=1)
    opened = track(controller)

    async def program() -> None:
        async with opened as stream:
            for n in range(100):
                await stream.send(near(1e-4 * n))
                if n == 30:
                    await eventually_async(lambda: pool.starts == 1)
                    pool.end(state)

    with contextlib.nullcontext() if error is None else pytest.raises(error):
        await program()
    assert pool.starts == (2 if error is None else 1)


async def test_a_program_that_feeds_no_more_ends_the_track(controller: Controller) -> None:
    PoolDrive(controller, per_look=1000)
    opened = track(controller, hold=0.05)
    with pytest.raises(StreamStarved):
        await fed(opened, (near(1e-4 * n) for n in range(20)), opened.ended)
    assert "trackClearQueue" in controller.names()
    assert controller.names()[-1] == "stop"


async def leave_by_an_error(
    controller: Controller, pool: PoolDrive, before: Callable[[], object] = lambda: None
) -> None:
    """Leave a stream, whose motion has begun, by an error."""
    async with track(controller) as stream:
        for n in range(100):
            await stream.send(near(1e-4 * n))
        await eventually_async(lambda: pool.starts == 1)
        before()
        raise ZeroDivisionError


async def test_leaving_by_an_error_empties_the_pool(controller: Controller) -> None:
    pool = PoolDrive(controller, per_look=1)
    with pytest.raises(ZeroDivisionError):
        await leave_by_an_error(controller, pool)
    assert pool.taken == len(pool.points) < 100
    assert controller.names().count("trackClearQueue") == 2


async def test_leaving_by_an_error_stops_a_motion_that_somebody_paused(
    controller: Controller,
) -> None:
    """Its task would not end before somebody resumes it."""
    pool = PoolDrive(controller, per_look=1)
    with anyio.fail_after(30.0), pytest.raises(ZeroDivisionError):
        await leave_by_an_error(controller, pool, lambda: pool.end(2))
    assert len(controller.server.received("stop")) == 1


async def test_a_full_pool_is_said(controller: Controller) -> None:
    pool = PoolDrive(controller, per_look=1)
    pool.points = [None] * 950
    controller.server.answer("trackClearQueue", 4)
    opened = TrackStreams(controller.endpoint).stream("joints", speed=0.5, acc=1.0, options=THREAD)
    points = [near(1e-4 * n) for n in range(300)]
    with pytest.raises(StreamRefused, match="the pool is full"):
        await fed(opened, [], lambda: opened.play(points))


def stream_of(controller: Controller, kind: str, options: WorkerOptions) -> Stream:
    """A stream of joints by each of the three drivers."""
    if kind == "servo":
        return controller.servo.joints(v=1.0, a=5.0, reach=0.1, options=options)
    if kind == "realtime":
        return of_positions(controller, reach=0.1, options=options)
    tracks = TrackStreams(controller.endpoint)
    return tracks.stream("joints", speed=0.5, acc=1.0, options=options)


@workers
@pytest.mark.parametrize("kind", ["servo", "realtime", "track"])
async def test_a_stream_that_begins_elsewhere_sends_nothing(
    controller: Controller, queue: Cycles, kind: str, options: WorkerOptions
) -> None:
    pool = PoolDrive(controller, per_look=1)
    said = r"joint 1: 0\.2 rad away, where 0\.\d+ rad are allowed"
    with anyio.fail_after(30.0), pytest.raises(FirstPointTooFar, match=said):
        await fed(stream_of(controller, kind, options), [near(0.2)])
    assert not [*controller.points(), *queue.points, *pool.points]
    assert not controller.server.received("start_realtime_mode")
    assert pool.starts == 0
    assert not controller.server.received("stop")


@pytest.mark.parametrize("kind", ["servo", "realtime", "track"])
async def test_a_stream_begins_when_the_arm_swings_no_more(
    controller: Controller, queue: Cycles, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It begins where the arm then is."""
    monkeypatch.setattr(driver, "_SWING", 60.0)
    PoolDrive(controller, per_look=1)
    looks: list[bool] = []

    def moving() -> bool:
        looks.append(len(looks) < 3)
        return looks[-1]

    controller.server.answer("robotmoving", moving)
    controller.server.answer(
        "get_actual_joints_position", lambda: near(0.2 if not looks or looks[-1] else 0.0)
    )
    await fed(stream_of(controller, kind, THREAD), [HERE])
    assert len(looks) > 3


@pytest.mark.cases(8)
@pytest.mark.parametrize("kind", ["servo", "realtime", "track"])
@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ([0.0] * 5, r"it answered \[0\.0, 0\.0, 0\.0, 0\.0, 0\.0\]: the place is not known"),
        ([*HERE[:2], math.nan, *HERE[3:]], "nan.*: the place is not known"),
        ([*HERE, 0.7], None),
    ],
    ids=["five", "nan", "rail"],
)
async def test_where_the_arm_is_has_six_numbers(
    controller: Controller, queue: Cycles, kind: str, answer: list[float], said: str | None
) -> None:
    """Without those of external axes; of fewer, or of nan, nothing is made that could be sent."""
    controller.server.answer("trackClearQueue", 7)
    controller.server.answer("get_actual_joints_position", answer)
    stream = stream_of(controller, kind, THREAD)
    if said is not None:
        with pytest.raises(StreamRefused, match=said):
            await fed(stream, [HERE])
        assert not [*controller.points(), *queue.points]
    elif kind == "track":  # the bench refuses the next step
        with pytest.raises(StreamRefused, match="trackClearQueue was refused"):
            await fed(stream, [HERE])
    else:
        await fed(stream, [HERE])
        assert [*controller.points(), *queue.points]
