"""Motions and tasks: each call returns when it is carried out."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import pytest
from api.desk import Desk

import aioduco
import aioduco.sync
from aioduco import (
    MotionCarriedOut,
    Outcome,
    ParameterError,
    TaskState,
    TaskStopped,
)
from sync.conftest import HOME


def test_a_motion_returns_when_it_has_ended(robot: aioduco.sync.Robot, desk: Desk) -> None:
    assert robot.motion.movej2(HOME, v=1.0, a=2.0, r=0.01) is Outcome.FINISHED
    (task,) = desk.tasks.values()
    assert task.state is TaskState.FINISHED
    assert desk.received("movej2")[0].args[:5] == (list(HOME), 1.0, 2.0, 0.01, False)


def test_a_refused_argument_never_reaches_the_socket(robot: aioduco.sync.Robot, desk: Desk) -> None:
    for function in (
        robot.motion.movej2,
        robot.motion.movej2.start,
        robot.motion.movej2.prepare,
    ):
        with pytest.raises(ParameterError):
            function(HOME, v=99.0, a=1.0)
    with pytest.raises(ParameterError):
        robot.io.get_standard_digital_out(99)
    not_a_motion: Any = HOME
    with pytest.raises(ParameterError):
        robot.motion.run(not_a_motion)
    assert desk.commands == []


def test_a_started_motion_is_a_task(robot: aioduco.sync.Robot, desk: Desk) -> None:
    desk.motion_time = 30.0
    task = robot.motion.movej2.start(HOME, v=1.0, a=1.0)
    assert (task.name, task.motion, task.done, task.outcome) == ("movej2", True, False, None)
    assert task.id in desk.tasks
    assert robot.tasks == (task,)
    with pytest.raises(TimeoutError):
        task.wait(timeout=0.01)
    assert not task.done  # a wait that was too short does nothing to the arm
    task.pause()
    task.resume()
    assert task.cancel() is Outcome.STOPPED
    assert task.errors == ()
    with pytest.raises(TaskStopped):
        task.result()
    with pytest.raises(TaskStopped):
        task.wait()
    assert desk.commands == ["movej2", "pause", "resume", "stop"]
    assert len(robot.tasks) == 0


@pytest.mark.parametrize("ended", [Outcome.FINISHED, Outcome.STOPPED])
def test_the_end_of_a_task_is_known_after_the_robot_was_left(desk: Desk, ended: Outcome) -> None:
    desk.motion_time = 0.0 if ended is Outcome.FINISHED else 30.0
    with aioduco.sync.connect(desk.host, desk.port) as robot:
        task = robot.motion.movej2.start(HOME, v=1.0, a=1.0)
        if ended is Outcome.FINISHED:
            task.wait()
    if ended is Outcome.FINISHED:
        assert task.wait() is task.wait(timeout=0) is ended
    else:
        with pytest.raises(TaskStopped), task:
            assert task.outcome is ended


def test_each_state_of_a_task(robot: aioduco.sync.Robot, desk: Desk) -> None:
    task = robot.motion.movej2.start(HOME, v=1.0, a=1.0)
    states = list(task.states())
    assert states[-1] is TaskState.FINISHED
    assert len(set(states)) == len(states) >= 2
    assert task.wait(timeout=5.0) is task.result() is Outcome.FINISHED
    assert task.duration > 0.0


def test_a_block_waits_for_a_motion(robot: aioduco.sync.Robot, desk: Desk) -> None:
    with robot.motion.movej2.start(HOME, v=1.0, a=1.0) as task:
        assert not task.done
    assert task.outcome is Outcome.FINISHED


def test_a_block_that_raises_stops_the_arm(robot: aioduco.sync.Robot, desk: Desk) -> None:
    desk.motion_time = 30.0
    with pytest.raises(KeyError), robot.motion.movej2.start(HOME, v=1.0, a=1.0) as task:
        raise KeyError
    assert task.outcome is Outcome.STOPPED
    assert not desk.moving()


@pytest.mark.slow
def test_motions_made_beforehand_blend(robot: aioduco.sync.Robot, desk: Desk) -> None:
    legs = [robot.motion.movej2.prepare(HOME, v=1.0, a=1.0, r=r) for r in (0.02, 0.0)]
    assert desk.commands == []
    assert robot.motion.run(*legs) == (Outcome.BLENDED, Outcome.FINISHED)
    assert legs[1].run() is Outcome.FINISHED
    assert len(desk.received("movej2")) == 3


def test_one_that_was_never_used_warns(robot: aioduco.sync.Robot) -> None:
    with pytest.warns(RuntimeWarning, match="the arm did not move"):
        robot.motion.movej2.prepare(HOME, v=1.0, a=1.0)


def test_calls_return_values_and_raise_what_the_awaited_ones_do(
    robot: aioduco.sync.Robot, desk: Desk
) -> None:
    assert robot.state.get_tcp_pose().x == 0.5
    assert robot.bring_up().states.robot is aioduco.RobotState.ENABLE
    desk.answer("get_tcp_pose", [1.0])
    with pytest.raises(aioduco.StaleState):
        robot.state.get_tcp_pose()
    with pytest.raises(aioduco.ControllerError):
        robot.program.get_current_project()


@pytest.mark.slow
def test_a_path_blends_and_ends_with_its_block(robot: aioduco.sync.Robot, desk: Desk) -> None:
    desk.lead("movej2", 3)
    legs = [robot.motion.movej2.prepare(HOME, v=1.0, a=1.0, r=r) for r in (0.02, 0.02, 0.0)]
    with robot.motion.path() as path:
        for leg in legs:
            assert not path.add(leg).done
    assert path.outcomes == (Outcome.BLENDED, Outcome.BLENDED, Outcome.FINISHED)
    assert path.ahead == 2
    desk.motion_time = 30.0
    path = robot.motion.path()
    tasks: list[aioduco.sync.Task] = []

    def raising() -> None:
        with path:
            tasks.append(path.add(legs[0]))
            assert not tasks[0].done
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        raising()
    assert tasks[0].outcome is Outcome.STOPPED
    assert repr(path) == "<MotionPath of 1 motions, 0 ended>"


def test_a_motion_of_no_robot_says_so(robot: aioduco.sync.Robot) -> None:
    with pytest.raises(TypeError, match="movej2 is a motion of a robot"):
        type(robot.motion).movej2(HOME, v=1.0, a=1.0)


def test_the_outcome_taken_for_the_motion_says_that_the_arm_has_moved(
    robot: aioduco.sync.Robot,
) -> None:
    outcome: Any = robot.motion.movej2(HOME, v=1.0, a=1.0)
    with pytest.raises(AttributeError, match=r"'start': .*the arm has moved.*movel\.start\("):
        outcome.start()
    with pytest.raises(MotionCarriedOut, match=r"the arm has moved.*movel\.start\("), outcome:
        raise AssertionError("entered")
    with pytest.raises(AttributeError, match=r"'Outcome' object has no attribute 'started'$"):
        _ = outcome.started
    assert not hasattr(outcome, "wait")
    assert copy.deepcopy(outcome) is pickle.loads(pickle.dumps(outcome)) is Outcome.FINISHED
