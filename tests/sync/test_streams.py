"""Streams of the blocking interface, on a simulated arm: where they lead, how they end."""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import numpy as np
import pytest

import aioduco
import aioduco.sync
from aioduco.errors import (
    ParameterError,
    SetPointTooFar,
    StreamClosed,
    StreamLost,
    StreamRefused,
    StreamStarved,
    StreamStopped,
    WorkerFailed,
)
from aioduco.models.op import Op, output
from aioduco.models.pose import Joints
from aioduco.sim import Simulator
from aioduco.streaming.joint_trajectory import JointTrajectory
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.shared.words import StreamState
from aioduco.sync import Robot, Stream
from aioduco.testing import eventually
from sync.conftest import Interrupts, meanwhile

START = Joints(0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0)
WAY = 0.03  # rad, m
THREAD = WorkerOptions(run_in="thread")
#: a busy machine's clock is late; neither the stream nor the controller must trip over that
QUEUE: dict[str, Any] = {"com_lost_time": 0.5, "depth": 100, "options": THREAD}
PATIENT: dict[str, Any] = {"hold": 30.0, "options": THREAD}

T = TypeVar("T")


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator() as sim:
        yield sim


def ready(robot: Robot) -> None:
    robot.rearm_heartbeat()
    robot.recover()
    robot.motion.movej2(START, v=3.0, a=20.0)


@pytest.fixture
def robot(sim: Simulator) -> Iterator[Robot]:
    with aioduco.sync.connect(sim.host, sim.port, heartbeat=30.0, loop_stall_limit=30.0) as robot:
        robot.bring_up()
        robot.motion.movej2(START, v=3.0, a=20.0)
        yield robot


def in_time(robot: Robot, run: Callable[[], T]) -> T:
    """Lead the arm, once more if the machine was too busy for it: the stream has then ended."""
    for _ in range(20):
        try:
            return run()
        except (WorkerFailed, StreamLost, StreamRefused, StreamStarved):
            ready(robot)
    return run()


def fed(stream: Stream, *steps: Callable[[], object]) -> None:
    """Open it, take these steps, and leave it."""
    with stream:
        for step in steps:
            step()


def bump(start: Any) -> list[list[float]]:
    first, *others = start
    way = [WAY * (1 - math.cos(math.pi * n / 100)) / 2 for n in range(101)]
    return [[first + each, *others] for each in way]


def joints(robot: Robot, stream: Stream) -> None:
    stream.play(bump(robot.state.get_actual_joints_position()))


def pose(robot: Robot, stream: Stream) -> None:
    stream.follow(bump(robot.state.get_tcp_pose()))


def offsets(_robot: Robot, stream: Stream) -> None:
    for _ in range(30):
        stream.send([WAY / 30, 0, 0, 0, 0, 0])


def speeds(robot: Robot, stream: Stream) -> None:
    for _ in stream.ticks(50):
        stream.send([0.1, 0, 0, 0, 0, 0])
        if not np.allclose(robot.state.get_actual_joints_position(), START, atol=WAY / 3):
            break


#: each maker of streams, and what feeds what it makes
KINDS: dict[str, tuple[Callable[[Robot], Stream], Callable[[Robot, Stream], None]]] = {
    "servo.joints": (lambda r: r.servo.joints(v=1.0, a=8.0, **PATIENT), joints),
    "servo.pose": (lambda r: r.servo.pose(v=1.0, a=8.0, **PATIENT), pose),
    "servo.linear": (lambda r: r.servo.linear(v=1.0, a=8.0, **PATIENT), pose),
    "servo.tcp_offset": (lambda r: r.servo.tcp_offset(v=1.0, a=8.0, **PATIENT), offsets),
    "speed.joints": (lambda r: r.speed.joints(a=2.0, dead_man=1.0, **PATIENT), speeds),
    "speed.linear": (lambda r: r.speed.linear(a=2.0, dead_man=1.0, **PATIENT), speeds),
    "realtime.stream": (
        lambda r: r.realtime.stream("joint_position", v=1.0, a=8.0, hold=30.0, **QUEUE),
        joints,
    ),
    "track.stream": (
        lambda r: r.track.stream("joints", speed=0.5, acc=2.0, options=THREAD),
        joints,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_each_leads_the_arm_and_leaves_it_standing(robot: Robot, sim: Simulator, kind: str) -> None:
    opened, feed = KINDS[kind]

    def lead() -> Stream:
        with opened(robot) as stream:
            feed(robot, stream)
        return stream

    before = sim.joints.array
    stream = in_time(robot, lead)
    assert not robot.state.robotmoving()
    assert np.abs(sim.joints.array - before).max() > 5e-3
    figures = stream.statistics()
    assert (figures.reason.name, stream.state) == ("CLOSED", StreamState.ENDED)
    assert (stream.commanded is None) is (kind == "track.stream")  # its pace is the arm's own
    assert stream.taken > 0
    assert stream.quiet
    assert "CLOSED" in repr(stream)
    with pytest.raises(StreamClosed):
        next(stream.ticks())


@pytest.mark.slow
def test_its_worker_has_a_process_of_its_own_and_its_options_are_those_of_the_awaited_one(
    robot: Robot, sim: Simulator
) -> None:
    with robot.servo.joints(v=1.0, a=8.0, rate=250, latest=True, hold=30.0) as stream:
        assert (stream.rate, stream.state) == (250.0, StreamState.WAITING)
        assert stream.pid not in (None, os.getpid())
        stream.send(START)
        with pytest.raises(SetPointTooFar):
            stream.send([1.0, *START[1:]])
        with pytest.raises(ParameterError):
            stream.play(bump(START))  # not with `latest`
        stream.send(START)  # it goes on after what was refused
    with pytest.raises(ParameterError, match="upsample"):
        robot.servo.joints(v=1.0, a=8.0, upsample="nearest")  # type: ignore[arg-type]
    with pytest.raises(StreamClosed, match=r"in its block, by `with` or, where it is awaited,"):
        robot.servo.joints(v=1.0, a=8.0).send(START)
    with pytest.raises(StreamClosed, match="opened once"), stream:
        raise AssertionError("entered")


@pytest.mark.slow
def test_points_of_a_track_set_outputs(robot: Robot, sim: Simulator) -> None:
    op = Op.at_start(output(3))
    with robot.track.stream(
        "joints", speed=0.5, acc=2.0, operations=True, options=THREAD
    ) as stream:
        for number, point in enumerate(bump(START)):
            stream.send(point, op if number == 50 else None)
    assert robot.io.get_standard_digital_out(3)


def test_an_error_in_the_block_brings_the_arm_to_rest_at_once(robot: Robot) -> None:
    stream = robot.servo.joints(v=1.0, a=8.0, **PATIENT)
    with pytest.raises(ValueError, match="not in list"):
        fed(stream, lambda: stream.send(START), lambda: list[int]().remove(1))
    assert stream.reason.name == "ABORTED"
    assert not robot.state.robotmoving()


@pytest.mark.slow
def test_an_interrupt_in_a_call_brings_the_arm_to_rest(
    robot: Robot, sim: Simulator, interrupts: Interrupts
) -> None:
    far = [[START.j1 + n * 1e-4, *START[1:]] for n in range(4000)]
    stream = robot.servo.joints(v=1.0, a=8.0, **PATIENT)
    with pytest.raises(KeyboardInterrupt), interrupts(lambda: stream.taken > 20), stream:
        stream.play(far)
    assert stream.reason.name == "ABORTED"
    assert stream.taken < len(far)
    assert not robot.state.robotmoving()


def test_so_does_one_outside_of_a_call(robot: Robot) -> None:
    stream = robot.servo.joints(v=1.0, a=8.0, **PATIENT)
    with pytest.raises(KeyboardInterrupt):
        fed(stream, lambda: stream.send(START), lambda: os.kill(os.getpid(), signal.SIGINT))
    assert stream.reason.name == "ABORTED"


def test_a_program_that_sends_nothing_more_leaves_a_standing_arm(robot: Robot) -> None:
    """As one that hangs: its thread makes no call, and the robot's loop goes on."""
    stream = robot.servo.joints(v=1.0, a=8.0, hold=0.1, options=THREAD)
    with pytest.raises(StreamStarved):
        fed(stream, lambda: stream.send(START), stream.ended, lambda: stream.send(START))
    assert not robot.state.robotmoving()


@pytest.mark.cases(1)
@pytest.mark.parametrize("way", ["stop", "stop_now", "pause"])
def test_a_stop_from_another_thread_ends_it(robot: Robot, way: str) -> None:
    stream = robot.servo.joints(v=1.0, a=8.0, **PATIENT)

    def stop() -> None:
        eventually(lambda: stream.taken > 20)
        getattr(robot, way)()

    far = [[START.j1 + n * 1e-4, *START[1:]] for n in range(4000)]
    with pytest.raises(StreamStopped), meanwhile(stop), stream:
        stream.play(far)
    assert stream.quiet
    robot.stop()


@pytest.mark.slow
def test_closing_the_robot_ends_it_and_its_end_is_told(sim: Simulator) -> None:
    robot = aioduco.sync.connect(sim.host, sim.port)
    robot.open()
    robot.bring_up()
    stream = robot.servo.joints(v=1.0, a=8.0, **PATIENT)
    with pytest.raises(StreamStopped):
        fed(stream, lambda: joints(robot, stream), robot.close)
    assert stream.state is StreamState.ENDED
    assert stream.statistics().sent > 0
    assert not sim.view.moving


@pytest.mark.slow
def test_ticks_that_were_missed_are_left_out(robot: Robot) -> None:
    period = 0.02
    with robot.servo.joints(v=1.0, a=8.0, latest=True, **PATIENT) as stream:
        ticks = stream.ticks(1 / period)
        begun = next(ticks)
        assert (begun.number, begun.dt) == (0, period)  # a busy loop may skip some even here
        until = time.monotonic() + 5 * period
        while time.monotonic() < until:
            stream.send(START)
        late = next(ticks)
        assert (late.number, late.skipped >= 4) == (1, True)
        assert late.time - begun.time >= 5 * period


@pytest.mark.slow
def test_a_joint_trajectory(robot: Robot, sim: Simulator) -> None:
    times = np.linspace(0.0, 0.5, 20)
    positions = np.tile(list(START), (20, 1))
    positions[:, 5] = 0.1 * (1 - np.cos(np.pi * times / 0.5)) / 2
    seen: list[float] = []

    def follow() -> Any:
        return robot.motion.follow_joint_trajectory(
            JointTrajectory(positions, times),
            v=1.5,
            a=10.0,
            through="servoj",
            feedback=lambda each: seen.append(each.time),
            options=THREAD,
        )

    result = in_time(robot, follow)
    assert np.abs(result.goal_error).max() < 0.01
    assert seen
    assert abs(sim.joints[5] - START.j6 - 0.1) < 0.01
