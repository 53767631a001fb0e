"""Streams of a robot, on a simulated arm: where they lead, and what ends them."""

from __future__ import annotations

import os
import signal
import threading
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial

import anyio
import numpy as np
import pytest
from moments import streamed_in_time
from patient import patient_queue

import aioduco
from aioduco.errors import (
    RobotStateError,
    StreamError,
    StreamRefused,
    StreamStarved,
    StreamStopped,
    TaskStopped,
    WorkerFailed,
)
from aioduco.models.enums import ProgramState
from aioduco.models.pose import Pose
from aioduco.sim import Simulator
from aioduco.streaming.joint_trajectory import Feedback, JointTrajectory, TrajectoryResult
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.shared.words import StreamState
from aioduco.streaming.stream import Stream
from aioduco.streaming.worker import driver
from aioduco.testing import ApplicationError, FaultProxy, eventually, eventually_async, no_leaks

from .conftest import PROCESS, THREAD
from .robot_motions import KINDS, START, WAY

#: one of each way to bring set-points to the controller
FOLLOWED = ["servoj", "speedj", "joint_position", "track joints"]


async def ready(robot: aioduco.Robot) -> None:
    await robot.rearm_heartbeat()
    await robot.recover()
    await robot.motion.movej2(START, v=3.0, a=20.0)


@pytest.fixture
async def robot(sim: Simulator) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(sim.host, sim.port) as robot:
        await robot.bring_up()
        await robot.motion.movej2(START, v=3.0, a=20.0)
        yield robot


async def followed(robot: aioduco.Robot, kind: str) -> None:
    """A stream, from its start to its end."""
    opened, feed, space, _ = KINDS[kind]
    async with opened(robot, THREAD) as stream:
        await feed(robot, stream, space)


async def place(robot: aioduco.Robot, space: str) -> np.ndarray:
    state = robot.state
    found = await (
        state.get_actual_joints_position() if space == "joints" else state.get_tcp_pose()
    )
    return np.array(found)


@pytest.mark.cases(1)
@pytest.mark.parametrize("kind", KINDS)
async def test_each_leads_the_arm_to_where_its_set_points_lead(
    robot: aioduco.Robot, sim: Simulator, kind: str
) -> None:
    opened, feed, space, _ = KINDS[kind]
    options = PROCESS if kind in FOLLOWED else THREAD
    start = await place(robot, space)
    with patient_queue():  # the program here may be held up for longer than a stream waits
        made = opened(robot, options)
    async with made as stream:
        await feed(robot, stream, space)
    # When it has been left, the arm stands.
    assert not await robot.state.robotmoving()
    end = await place(robot, space)
    if kind == "servo_tcp":
        wanted = np.array(list(Pose.of(start) @ Pose(WAY, 0, 0, 0, 0, 0)))
        np.testing.assert_allclose(end[:3], wanted[:3], atol=1e-3)
    elif feed is KINDS["speedj"].feed:
        # a speed of the tool is in the tool's own frame; how far depends on how long it lasted
        assert np.abs(end - start)[:3].max() > 1e-3
    else:
        # the tool points down: its angle is π, or as well -π
        moved = np.arctan2(np.sin(end - start), np.cos(end - start))
        np.testing.assert_allclose(moved, [WAY, 0, 0, 0, 0, 0], atol=1e-3)
    assert stream.statistics().reason.name == "CLOSED"
    # The robot can be moved by others again.
    await robot.motion.movej2(START, v=3.0, a=20.0)


# -- who may end it ----------------------------------------------------------------------------


async def ended_by(
    robot: aioduco.Robot,
    sim: Simulator,
    kind: str,
    end: Callable[[], object],
    options: WorkerOptions = THREAD,
    error: type[StreamError] = StreamStopped,
) -> None:
    """A stream in full course is ended by something else than its program."""
    opened = KINDS[kind].open(robot, options)

    async def program(stream: Stream) -> None:
        async with stream:
            start = await place(robot, "joints")
            speed = KINDS[kind].feed is KINDS["speedj"].feed
            for n in range(2000):
                point = np.zeros(6) if speed else start.copy()
                point[0] += 0.1 if speed else 1e-3 * n
                await stream.send(point)
                if speed:
                    await anyio.sleep(0.005)

    async with anyio.create_task_group() as tasks:

        async def feeding() -> None:
            with pytest.raises(error):
                await program(opened)

        tasks.start_soon(feeding)
        # on a busy machine it may hold in between, for want of set-points
        await eventually_async(
            lambda: (
                opened.state is StreamState.FOLLOWING
                and np.abs(sim.joints.array - START.array).max() > 5e-3
            )
        )
        if isinstance(ending := end(), Awaitable):
            await ending
            # `stop_now` waits for the worker for a tenth of a second only
            await eventually_async(lambda: opened.quiet)
        else:
            # It waits for the worker's silence for a time only, for it may be in a signal handler.
            eventually(lambda: opened.quiet)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "options"), [*((kind, PROCESS) for kind in FOLLOWED), ("servoj", THREAD)]
)
async def test_a_stop_ends_it_and_the_arm_stands(
    robot: aioduco.Robot, sim: Simulator, kind: str, options: WorkerOptions
) -> None:
    async with no_leaks():
        await ended_by(robot, sim, kind, robot.stop, options)
    assert not sim.view.moving
    await eventually_async(lambda: not sim.tasks)


@pytest.mark.cases(1)
@pytest.mark.parametrize("way", ["stop_now", "pause", "abort"])
async def test_so_do_the_others(robot: aioduco.Robot, sim: Simulator, way: str) -> None:
    end = getattr(robot, way)
    if way == "stop_now":

        async def end() -> None:
            thread = threading.Thread(target=robot.stop_now)
            thread.start()
            await eventually_async(lambda: not thread.is_alive())

    async with no_leaks():
        await ended_by(robot, sim, "servoj", end)
    await eventually_async(lambda: not sim.moving)
    assert not robot._supervisor.stop_coordinator.streams
    await robot.stop()


@pytest.mark.cases(1)
@pytest.mark.parametrize("kind", FOLLOWED)
async def test_so_does_a_stop_by_another_program(
    robot: aioduco.Robot, sim: Simulator, kind: str
) -> None:
    """A set-point that was on its way may move the arm again, but is the last."""
    async with aioduco.connect(sim.host, sim.port, heartbeat=None) as other:
        with robot.permit("block"):
            await ended_by(robot, sim, kind, other.stop)
            await eventually_async(lambda: not sim.tasks)
            assert not sim.view.moving
            assert await robot.realtime.get_realtime_data_queue_size() == 0
            with pytest.raises(TaskStopped, match="was not sent"):
                await robot.motion.movej2(START, v=3.0, a=20.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["servoj", "servo_tcp", "speedj", "speedl"])
async def test_a_loop_of_calls_within_a_permit_ends_by_a_stop_of_another_program(
    robot: aioduco.Robot, sim: Simulator, kind: str
) -> None:
    args: dict[str, object] = {"v": 0.1, "a": 5.0} if "servo" in kind else {"a": 1.0, "time": 20.0}
    by = {
        "servoj": [START[0] + 2.0, *START[1:]],
        "servo_tcp": [0, 0, 1e-4, 0, 0, 0],
        "speedj": [0.05, 0, 0, 0, 0, 0],
    }
    call = partial(getattr(robot.motion, kind), by.get(kind, [0, 0, 0.01, 0, 0, 0]), **args)

    async def loop() -> None:
        with robot.permit("loop"):
            while True:
                await call().start()

    async def stopped_by_another() -> None:
        async with aioduco.connect(sim.host, sim.port, heartbeat=None) as other:
            await eventually_async(lambda: sim.moving and robot.statistics().tasks > before + 10)
            await other.stop()

    before = robot.statistics().tasks
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(stopped_by_another)
        with pytest.raises(TaskStopped, match=f"{kind} was not sent, since the arm was stopped"):
            await loop()
    await eventually_async(lambda: not sim.tasks)
    assert not sim.view.moving


@pytest.mark.slow
async def test_stop_now_from_the_thread_of_the_event_loop(
    robot: aioduco.Robot, sim: Simulator
) -> None:
    """As a signal handler does it: nothing of the event loop goes on meanwhile."""
    await ended_by(robot, sim, "servoj", robot.stop_now, PROCESS)
    await eventually_async(lambda: not sim.moving)


@pytest.mark.slow
async def test_a_stop_while_it_is_being_opened(robot: aioduco.Robot) -> None:
    stream = robot.servo.joints(v=1.0, a=8.0)
    async with no_leaks(), anyio.create_task_group() as tasks:

        async def opening() -> None:
            with pytest.raises(StreamStopped):
                async with stream:
                    raise AssertionError("entered")

        tasks.start_soon(opening)
        await eventually_async(lambda: len(robot._supervisor.stop_coordinator.streams) == 1)
        await robot.stop()
    assert stream.state is StreamState.ENDED


async def test_leaving_the_robot_ends_it(sim: Simulator) -> None:
    async with no_leaks():
        async with aioduco.connect(sim.host, sim.port) as robot:
            await robot.bring_up()
            stream = robot.servo.joints(v=1.0, a=8.0, options=THREAD)
            await stream.__aenter__()
            await stream.send(await robot.state.get_actual_joints_position())
        with pytest.raises(StreamStopped):
            await stream.__aexit__(None, None, None)
    assert not sim.view.moving


@pytest.mark.cases(1)
@pytest.mark.parametrize("kind", ["servoj", "speedj", "track joints"])
async def test_nothing_that_it_had_sent_goes_on_after_a_pause(
    robot: aioduco.Robot, sim: Simulator, kind: str
) -> None:
    await ended_by(robot, sim, kind, robot.pause)
    assert not sim.view.moving
    assert not sim.tasks
    assert sim.view.program is ProgramState.STOPPED
    assert await robot.resume() is False


@pytest.mark.slow
@pytest.mark.parametrize("way", ["stop", "abort"])
async def test_a_stop_does_not_wait_for_a_worker_that_hangs(
    robot: aioduco.Robot, sim: Simulator, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    monkeypatch.setattr("aioduco.supervision.motion_sources._SILENCE", 0.2)
    async with no_leaks():
        stream = robot.servo.joints(v=1.0, a=8.0)

        async def program() -> None:
            async with stream:
                await stream.send(START)
                assert stream.pid is not None
                os.kill(stream.pid, signal.SIGSTOP)
                await getattr(robot, way)()
                # what it sent last cannot move the arm any more
                assert not robot._supervisor.stop_coordinator.worker_died
                await stream.ended()

        with pytest.raises(WorkerFailed, match="killed by SIGKILL"):
            await program()
    assert not sim.view.moving


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["servoj", "joint_position"])
async def test_an_emergency_stop_ends_it(robot: aioduco.Robot, sim: Simulator, kind: str) -> None:
    async def program() -> None:
        async with KINDS[kind].open(robot, THREAD) as stream:
            for n in range(5000):
                await stream.send([2e-4 * n, *START[1:]])
                if n == 100:
                    sim.emergency_stop()

    try:
        # By its state, by the task's, or by what the controller answers: whichever is seen first.
        with pytest.raises(StreamRefused, match="does not follow any more"):
            await program()
        await eventually_async(lambda: not sim.moving)
    finally:
        sim.release_emergency_stop()
    await robot.recover()


@pytest.mark.slow
async def test_a_queue_that_ran_dry_is_said(robot: aioduco.Robot, sim: Simulator) -> None:
    """Its controller is in a safety stop then, and yet enabled."""

    async def program() -> None:
        opened = KINDS["joint_position"].open(robot, WorkerOptions(timeout=3.0))
        async with opened as stream:
            for n in range(5000):
                await stream.send(START)
                if n == 100:
                    assert stream.pid is not None
                    os.kill(stream.pid, signal.SIGSTOP)
                    await eventually_async(lambda: "no data" in "".join(sim.view.errors))
                    os.kill(stream.pid, signal.SIGCONT)

    with pytest.raises(StreamRefused, match=r"takes no points.*error list: .*no data for"):
        await program()
    await robot.recover()


@pytest.mark.slow
async def test_a_program_that_hangs_while_an_array_is_played_stops_the_arm(sim: Simulator) -> None:
    """The heartbeat alone would not do: what is queued would set the arm moving again."""

    async def program() -> None:
        opened = aioduco.connect(
            sim.host, sim.port, heartbeat=2.0, loop_stall_limit=2.0, lag_limit=None
        )
        async with opened as robot:
            await robot.recover()
            start = np.array(await robot.state.get_actual_joints_position())
            rows = start + np.linspace(0, 0.4, 2000)[:, None] * np.eye(6)[0]
            async with robot.servo.joints(v=1.0, a=8.0) as stream, anyio.create_task_group() as t:
                t.start_soon(stream.play, rows)
                await eventually_async(lambda: sim.joints[0] - start[0] > 5e-3)
                # It waits in the thread of the event loop: the stall is what is tested.
                eventually(lambda: stream.quiet)
                eventually(lambda: not sim.view.moving)

    with pytest.raises(BaseExceptionGroup) as caught:
        await program()
    # by the stream's worker, or by the robot's watchdog that has the same limit and stops the arm,
    # of which the stream is told by the program or by the controller
    assert caught.group_contains((StreamStarved, StreamStopped, StreamRefused))


# -- one at a time -----------------------------------------------------------------------------


async def test_no_motion_while_a_stream_is_open(robot: aioduco.Robot) -> None:
    async with robot.servo.joints(v=1.0, a=8.0, options=THREAD) as stream:
        with pytest.raises(RobotStateError, match=r"movej2 was not sent: the arm follows <Stream"):
            await robot.motion.movej2(START, v=1.0, a=1.0)
        with pytest.raises(RobotStateError, match=r"the arm follows <Stream"):
            async with robot.track.stream("joints", speed=0.1, acc=0.1):
                raise AssertionError("entered")
        # What moves nothing goes on.
        await robot.io.set_standard_digital_out(1, value=True)
        await stream.send(START)


async def test_no_points_of_others_in_the_pool_that_a_stream_follows(robot: aioduco.Robot) -> None:
    async with robot.track.stream("joints", speed=0.5, acc=1.0, options=THREAD) as stream:
        await stream.play([START])
        while await robot.track.getQueueSize():
            pass  # it is empty at last, and more may follow
        with pytest.raises(RobotStateError, match=r"trackEnqueue was not sent: the arm follows"):
            await robot.track.trackEnqueue([START])


async def test_nor_in_the_block_of_a_stream_that_has_ended(robot: aioduco.Robot) -> None:
    stream = robot.servo.joints(v=1.0, a=8.0, options=THREAD)
    await stream.__aenter__()
    await stream.send(START)
    await robot.stop()
    with pytest.raises(RobotStateError, match=r"the block of <Stream .* is open; leave it first"):
        await robot.motion.movej2(START, v=1.0, a=1.0)
    with pytest.raises(StreamStopped):
        await stream.__aexit__(None, None, None)
    await robot.motion.movej2(START, v=1.0, a=1.0)


async def test_no_stream_while_a_motion_is_under_way(robot: aioduco.Robot) -> None:
    target = [START[0] + 0.5, *START[1:]]
    motion = await robot.motion.movej2(target, v=0.05, a=5.0).start()
    with pytest.raises(RobotStateError, match=r"servoj was not opened: <Task .* movej2"):
        async with robot.servo.joints(v=1.0, a=8.0):
            raise AssertionError("entered")
    await robot.stop()
    with pytest.raises(aioduco.TaskStopped):
        await motion


async def test_no_stream_while_the_arm_moves_by_what_this_program_resumed(
    robot: aioduco.Robot, sim: Simulator
) -> None:
    """The controller would carry out its set-points when that has ended, far from there."""
    target = [START[0] + 0.5, *START[1:]]
    async with aioduco.connect(sim.host, sim.port) as other:
        await other.motion.movej2(target, v=0.05, a=5.0).start()
        await other.pause()
        await robot.resume()
        with pytest.raises(RobotStateError, match="servoj was not opened: a motion without a task"):
            async with robot.servo.joints(v=1.0, a=8.0):
                raise AssertionError("entered")
        await robot.stop()


@pytest.mark.parametrize("kind", FOLLOWED)
async def test_no_stream_on_an_arm_that_another_program_has_paused(
    robot: aioduco.Robot, sim: Simulator, kind: str
) -> None:
    """It would move the arm when somebody resumes the motion, behind that."""
    async with aioduco.connect(sim.host, sim.port) as other:
        await other.motion.movej2([START[0] + 0.5, *START[1:]], v=0.5, a=2.0).start()
        await other.pause()
        before = sim.tasks
        with pytest.raises(StreamRefused, match="the arm is paused"):
            await followed(robot, kind)
        assert sim.tasks == before
        await other.stop()


@pytest.mark.parametrize("kind", FOLLOWED)
async def test_no_stream_while_another_program_moves_the_arm(
    robot: aioduco.Robot, sim: Simulator, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When that motion had ended, the arm would go back to where it was when the stream began."""
    monkeypatch.setattr(driver, "_SWING", 0.0)
    async with aioduco.connect(sim.host, sim.port) as other:
        motion = await other.motion.movej2([START[0] + 0.5, *START[1:]], v=0.05, a=5.0).start()
        await eventually_async(lambda: sim.moving)
        before = [task.id for task in sim.tasks]
        with pytest.raises(StreamRefused, match="the arm moves, by a person or by another program"):
            await followed(robot, kind)
        assert [task.id for task in sim.tasks] == before
        assert not motion.done
        await other.stop()


async def test_no_stream_of_a_robot_that_is_not_open(sim: Simulator) -> None:
    robot = aioduco.connect(sim.host, sim.port)
    with pytest.raises(RobotStateError, match="the robot is not open"):
        async with robot.servo.joints(v=1.0, a=8.0):
            raise AssertionError("entered")


# -- trajectories ------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("through", ["auto", "servoj"])
async def test_a_trajectory_through_the_queue_or_servoj(
    robot: aioduco.Robot, sim: Simulator, through: str, totals: Counter[str]
) -> None:
    seen: list[Feedback] = []
    start = START.array

    async def follow() -> TrajectoryResult:
        seen.clear()
        return await robot.motion.follow_joint_trajectory(
            JointTrajectory([start, start + 0.1, start], [0.0, 0.4, 0.8]),
            v=1.5,
            a=20.0,
            feedback=seen.append,
            through=through,  # type: ignore[arg-type]
        )

    result = await streamed_in_time(follow, partial(ready, robot), totals)
    assert np.abs(result.goal_error).max() <= 0.01
    assert np.abs(result.path_error).max() <= 0.02
    assert max(each.actual[0] for each in seen) == pytest.approx(0.1, abs=0.01)
    queue = "realtime" if through == "auto" else "servoj"
    assert (result.statistics.queue.samples > 0) == (queue == "realtime")


@pytest.mark.slow
async def test_a_controller_without_a_queue_is_led_by_servoj(sim: Simulator) -> None:
    with FaultProxy(sim.host, sim.port) as proxy:
        proxy.on("get_realtime_data_queue_size", ApplicationError(code=1), times=None)
        async with aioduco.connect(proxy.host, proxy.port) as robot:
            await robot.bring_up()
            start = np.array(await robot.state.get_actual_joints_position())
            await robot.motion.follow_joint_trajectory(
                JointTrajectory([start, start + 0.05], [0.0, 0.3]), v=1.5, a=20.0, options=THREAD
            )
        assert proxy.calls("servoj")
        assert not proxy.calls("realtime_data_enqueue")
