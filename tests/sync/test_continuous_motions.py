"""A continuous motion of the blocking interface needs a block that ends it."""

from __future__ import annotations

import itertools
import threading
import time
from typing import Any, cast

import pytest
from api.desk import Desk
from moments import on_another_thread

import aioduco.sync
from aioduco import Jog, Outcome, TaskFailed, TaskState, TaskStopped
from aioduco.sync import Robot, Task
from aioduco.sync._presence import CallRecord, CallTimes
from aioduco.testing import eventually
from sync.conftest import HOME

DOWN = [0.0, 0.0, -0.02, 0.0, 0.0, 0.0]


def test_presence() -> None:
    calls = CallRecord()
    calls.enter()
    assert calls.idle_time(50.0) == 0.0
    calls.enter()  # a call within a call
    calls.leave(51.0)
    assert calls.idle_time(60.0) == 0.0
    calls.leave(60.0)
    assert calls.idle_time(60.5) == 0.5
    calls.enter()
    assert calls.idle_time(70.0) == 0.0


def test_each_thread_has_its_own_calls() -> None:
    times, seen = CallTimes(), []
    for _ in range(2):  # one after the other: the second may get the number of the first
        on_another_thread(lambda: seen.append(times.here))
    assert len({id(calls) for calls in (times.here, *seen)}) == 3
    assert times.here is times.here


def held_by_nobody(robot: Robot, desk: Desk) -> Task:
    """Start a motion, and make no call until it is stopped."""
    task = robot.motion.speedl.start(DOWN, a=1.0, time=None)
    eventually(lambda: "stop" in desk.commands)
    return task


def test_it_is_stopped_when_the_program_hangs(robot: Robot, desk: Desk) -> None:
    task = held_by_nobody(robot, desk)
    with pytest.raises(TaskStopped) as caught:
        task.wait()
    assert "robot.sleep" in caught.value.__notes__[0]
    assert not desk.moving()


def test_a_later_task_of_its_number_is_another_one(robot: Robot, desk: Desk) -> None:
    """A controller that was restarted begins its numbers anew."""
    with pytest.raises(TaskStopped):
        held_by_nobody(robot, desk).wait()
    desk._ids = itertools.count(1000)
    desk.ends = TaskState.ERROR
    with pytest.raises(TaskFailed) as caught:
        robot.motion.movej2.start(HOME, v=1.0, a=1.0).wait()
    assert not hasattr(caught.value, "__notes__")


def test_another_thread_may_begin_to_hold_one_at_any_moment(
    robot: Robot, desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    runner, limit = robot._runner, robot._runner._limit

    def meanwhile(task: Any) -> float | None:
        runner.holds(cast("Any", type("Another", (), {"id": 1})()))
        return limit(task)

    monkeypatch.setattr(runner, "_limit", meanwhile)
    held_by_nobody(robot, desk)
    assert runner.running


@pytest.mark.slow
def test_samples_hold_it_and_properties_of_its_task_do_not(robot: Robot, desk: Desk) -> None:
    """As in a window, whose timer looks at the arm."""
    task = robot.motion.speedl.start(DOWN, a=1.0, time=None)
    until = time.monotonic() + 1.0  # five times the limit
    while time.monotonic() < until:
        robot.feed.latest(max_age=5.0)
    assert "stop" not in desk.commands
    eventually(lambda: task.done)
    assert "stop" in desk.commands


@pytest.mark.slow
def test_another_threads_calls_do_not_hold_it(robot: Robot, desk: Desk) -> None:
    over = threading.Event()

    def poll() -> None:
        while not over.is_set():
            robot.state.get_tcp_pose()

    thread = threading.Thread(target=poll)
    thread.start()
    try:
        robot.motion.move_jog.start(Jog.joint(1, 1, 10), time=None)
        eventually(lambda: "stop" in desk.commands)
    finally:
        over.set()
        thread.join()


@pytest.mark.slow
def test_calls_of_later_threads_do_not_hold_the_motion_of_one_that_has_ended(
    robot: Robot, desk: Desk
) -> None:
    """A later thread often gets the number of the thread before it."""

    def stopped() -> bool:
        on_another_thread(robot.state.get_tcp_pose)
        return "stop" in desk.commands

    on_another_thread(lambda: robot.motion.speedl.start(DOWN, a=1.0, time=None))
    eventually(stopped)


def test_calls_and_sleep_hold_it(robot: Robot, desk: Desk) -> None:
    with robot.motion.speedl.start(DOWN, a=1.0, time=None):
        robot.sleep(0.5)  # beyond the limit of 0.2 s
        for _ in range(20):
            robot.state.get_tcp_pose()
    assert desk.commands == ["speedl", "speed_stop"]


@pytest.mark.slow
def test_a_wait_holds_it(robot: Robot, desk: Desk) -> None:
    task = robot.motion.speedl.start(DOWN, a=1.0, time=None)
    with pytest.raises(TimeoutError):
        task.wait(timeout=0.5)
    assert desk.going_on
    task.end()


@pytest.mark.slow
def test_what_ends_by_itself_goes_on(robot: Robot, desk: Desk) -> None:
    """To a target, for a time, or led by a person: no call for more than the limit."""
    desk.motion_time = 0.5
    robot.motion.movej2.start(HOME, v=1.0, a=1.0)
    eventually(lambda: not desk.moving())
    robot.motion.speedl.start(DOWN, a=1.0, time=0.5)
    eventually(lambda: not desk.moving())
    assert "stop" not in desk.commands
    with robot.motion.teach_mode.start() as task:
        robot.sleep(0.0)
        began = len(desk.received("get_noneblock_taskstate"))
        eventually(lambda: len(desk.received("get_noneblock_taskstate")) > began + 10)
        assert task.outcome is None
    assert "stop" not in desk.commands


def test_a_limit_for_every_motion(desk: Desk) -> None:
    desk.motion_time = 30.0
    with aioduco.sync.connect(desk.host, desk.port, program_limit=0.2) as robot:
        task = robot.motion.movej2.start(HOME, v=1.0, a=1.0)
        eventually(lambda: "stop" in desk.commands)
        assert task.cancel() is Outcome.STOPPED


@pytest.mark.slow
def test_no_limit(desk: Desk) -> None:
    with aioduco.sync.connect(desk.host, desk.port, hold_limit=None, heartbeat=1.0) as robot:
        robot.motion.speedl.start(DOWN, a=1.0, time=None)
        beats = len(desk.received("rpc_heartbeat"))
        eventually(lambda: len(desk.received("rpc_heartbeat")) > beats + 4, timeout=20.0)
        assert desk.going_on
