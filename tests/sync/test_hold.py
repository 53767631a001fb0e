"""A motion without an end of its own needs somebody who holds it."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import pytest

import aioduco.sync
from aioduco import Jog, Joints, Outcome, ParameterError, TaskStopped
from aioduco.sync._presence import CallTimes
from aioduco.testing import eventually

if TYPE_CHECKING:
    from api.desk import Desk

    from aioduco.sync import Robot

DOWN = [0.0, 0.0, -0.02, 0.0, 0.0, 0.0]
HOME = Joints(0, 0, 1.5, 0, -1.5, 0)


def test_presence() -> None:
    presence = CallTimes()
    presence.enter(1)
    assert presence.idle_time(1, 50.0) == 0.0
    presence.enter(1)  # a call within a call
    presence.leave(1, 51.0)
    assert presence.idle_time(1, 60.0) == 0.0
    presence.leave(1, 60.0)
    assert presence.idle_time(1, 60.5) == 0.5
    presence.enter(2)
    assert presence.idle_time(1, 61.0) == 1.0  # another thread does not speak for it
    presence.enter(1)
    assert presence.idle_time(1, 70.0) == 0.0


def test_it_is_stopped_when_the_program_hangs(robot: Robot, desk: Desk) -> None:
    task = robot.motion.speedl.start(DOWN, a=1.0, time=None)
    eventually(lambda: "stop" in desk.commands)  # this thread makes no call meanwhile
    with pytest.raises(TaskStopped) as caught:
        task.wait()
    assert "robot.sleep" in caught.value.__notes__[0]
    assert not desk.moving()


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


def test_calls_and_sleep_hold_it(robot: Robot, desk: Desk) -> None:
    with robot.motion.speedl.start(DOWN, a=1.0, time=None):
        robot.sleep(0.5)  # beyond the limit of 0.2 s
        for _ in range(20):
            robot.state.get_tcp_pose()
    assert desk.commands == ["speedl", "speed_stop"]


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


def test_the_limits_are_checked(desk: Desk) -> None:
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(ParameterError):
            aioduco.sync.connect(desk.host, desk.port, hold_limit=wrong)
        with pytest.raises(ParameterError):
            aioduco.sync.connect(desk.host, desk.port, program_limit=wrong)
