"""Velocities, jogs and hand guiding over the wire."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from for_each import for_each

from aioduco._wire.rpc import MoveJogTaskParam
from aioduco.models.enums import TaskState
from aioduco.models.jog import JogFrame
from aioduco.models.pose import Pose
from aioduco.sim.simulator import READY, Simulator

from .conftest import Program, Started, let_pass, standing_time

STILL = [0.0] * 6


def test_joints_turn_until_the_time_is_over(sim: Simulator, robot: Program) -> None:
    begin = sim.time
    speeds = [0.4, 0.0, -0.2, 0.0, 0.0, 0.0]
    assert robot.speedj(speeds, 2.0, 1000, True) == TaskState.FINISHED
    # 0.2 s to speed, then until 1 s, then 0.2 s to stand
    assert 1.19 < sim.time - begin < 2.0
    sim.wait_until(lambda: not sim.moving)
    assert sim.joints[0] == pytest.approx(0.4, abs=5e-3)
    assert sim.joints[2] - READY[2] == pytest.approx(-0.2, abs=5e-3)


def test_speed_stop_ends_it_in_good_order(sim: Simulator, robot: Program) -> None:
    # So slow that the end of the joint is far beyond whatever a busy machine takes.
    id_ = robot.speedj([0.01, *STILL[1:]], 1.0, -1, False)
    sim.wait_until(lambda: sim.joints[0] > 0.01, 60.0)
    assert robot.get_noneblock_taskstate(id_) == TaskState.RUNNING
    assert robot.to(*READY) == TaskState.ILLEGAL
    assert robot.speed_stop(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(id_) == TaskState.FINISHED
    assert not sim.moving
    assert robot.speed_stop(True) == TaskState.FINISHED
    assert robot.to(*READY) == TaskState.FINISHED


@pytest.mark.slow
def test_what_comes_after_speed_stop_waits_until_the_arm_stands(
    sim: Simulator, robot: Program
) -> None:
    first = robot.speedj([0.2, *STILL[1:]], 1.0, -1, False)
    sim.wait_until(lambda: sim.joints[0] > 0.1, 60.0)
    ending = robot.speed_stop(False)
    again = robot.speedj([-0.2, *STILL[1:]], 1.0, -1, False)
    assert robot.to(*READY) == TaskState.ILLEGAL  # a speed has no end
    sim.wait_until(lambda: sim.joints[0] < 0.05, 60.0)
    for id_, state in ((first, 4), (ending, 4), (again, 1)):
        assert robot.get_noneblock_taskstate(id_) == state
    robot.speed_stop(False)
    assert robot.to(*READY) == TaskState.FINISHED
    assert sim.joints[0] == pytest.approx(READY[0], abs=1e-3)
    robot.speedj([0.2, *STILL[1:]], 1.0, -1, False)
    sim.wait_until(lambda: sim.joints[0] > 0.1, 60.0)
    with standing_time(sim):
        robot.speed_stop(False)
        never = robot.speedj([0.2, *STILL[1:]], 1.0, -1, False)
        ending = robot.speed_stop(False)
    sim.wait_until(lambda: robot.get_noneblock_taskstate(ending) == TaskState.FINISHED)
    assert robot.get_noneblock_taskstate(never) == TaskState.STOPPED


@pytest.mark.slow
def test_a_second_velocity_takes_over(sim: Simulator, robot: Program) -> None:
    first = robot.speedj([0.2, *STILL[1:]], 1.0, -1, False)
    sim.wait_until(lambda: sim.joints[0] > 0.05, 60.0)
    second = robot.speedj([-0.2, *STILL[1:]], 1.0, -1, False)
    assert robot.get_noneblock_taskstate(first) == TaskState.INTERRUPT
    sim.wait_until(lambda: sim.joints[0] < 0.0, 60.0)
    assert robot.speedl([0.1, *STILL[1:]], 1.0, -1, True) == TaskState.ILLEGAL
    assert robot.stop(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(second) == TaskState.STOPPED


@pytest.mark.slow
def test_the_tool_moves_along_its_own_axes(sim: Simulator, robot: Program) -> None:
    start = Pose.of(robot.get_tcp_pose())
    assert robot.speedl([0.0, 0.0, 0.1, 0.0, 0.0, 0.0], 1.0, 1000, True) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    goal = start @ Pose(0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
    assert Pose.of(robot.get_tcp_pose()).almost_equal(goal, position=1e-3, rotation=1e-3)
    assert robot.speedl([0.0, 0.0, 0.0, 0.0, 0.0, 0.5], 5.0, 1000, True) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    turned = goal @ Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.5)
    assert Pose.of(robot.get_tcp_pose()).almost_equal(turned, position=1e-3, rotation=3e-3)


@pytest.mark.slow
def test_the_end_of_the_reach_ends_it(sim: Simulator, robot: Program) -> None:
    assert robot.speedl([0.0, 0.0, -0.3, 0.0, 0.0, 0.0], 1.0, -1, True) == TaskState.ERROR
    assert robot.get_last_error()
    sim.wait_until(lambda: not sim.moving)
    assert robot.get_robot_state() == [6, 0, 5, 1]
    assert robot.speedj([0.0, 0.0, 0.0, 0.0, 0.0, 2.0], 5.0, -1, True) == TaskState.ERROR
    assert "joint 6" in robot.get_last_error()[-1]
    assert sim.joints[5] <= 2 * math.pi + 1e-3


@pytest.mark.slow
def test_the_global_speed_scales_it(sim: Simulator, robot: Program) -> None:
    assert robot.speed(10.0) == TaskState.FINISHED
    assert robot.speedj([0.5, *STILL[1:]], 5.0, 1000, True) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    assert sim.joints[0] == pytest.approx(0.05, abs=5e-3)
    robot.trackEnqueue([[0.5, *READY[1:]]], True)
    for begin in (
        lambda: robot.move_jog(jog(vel=100.0), False),  # 0.5 rad/s
        lambda: robot.trackJointMotion(0.5, 5.0, False),
    ):
        assert steady(sim, begin, robot.get_target_joints_speed) == pytest.approx(0.05, rel=1e-6)
        robot.stop(True)


def steady(sim: Simulator, begin: Callable[[], int], speeds: Callable[[], list[float]]) -> float:
    """The speed of a motion a second after its begin, the largest of some numbers."""
    with standing_time(sim):
        assert begin() >= 1000
        sim.advance(1000)
        return max(map(abs, speeds()))


@pytest.mark.slow
@pytest.mark.usefixtures("real_cycle")
def test_how_fast_a_jog_is(sim: Simulator, robot: Program) -> None:
    for kind, fastest in ((2, 0.5), (1, 0.25)):
        speeds = robot.get_target_joints_speed if kind == 2 else tip_speed(robot)
        begun = partial(robot.move_jog, jog(jog_type=kind, vel=100.0), False)
        assert steady(sim, begun, speeds) == pytest.approx(fastest, rel=1e-3)
        assert robot.stop_manual_move(True) == TaskState.FINISHED


def tip_speed(robot: Program) -> Callable[[], list[float]]:
    return lambda: list(robot.getRobotStatus().cartExpectVelocity[:3])


def test_pause_and_resume(sim: Simulator, robot: Program) -> None:
    id_ = robot.speedl([0.05, *STILL[1:]], 1.0, -1, False)
    sim.wait_until(lambda: sim.moving)
    assert robot.pause(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(id_) == TaskState.PAUSED
    assert robot.resume(True) == TaskState.FINISHED
    assert robot.speed_stop(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(id_) == TaskState.FINISHED


def test_wrong_velocities(strict: Program) -> None:
    assert strict.speedj([4.0, *STILL[1:]], 1.0, 100, True) == TaskState.PARAMETER_MISMATCH
    assert strict.speedj([0.1] * 5, 1.0, 100, True) == TaskState.PARAMETER_MISMATCH
    assert strict.speedj([math.nan] * 6, 1.0, 100, True) == TaskState.PARAMETER_MISMATCH
    assert strict.speedj([0.1] * 6, 0.0, 100, True) == TaskState.PARAMETER_MISMATCH
    assert strict.speedj([0.1] * 6, 1.0, 0, True) == TaskState.PARAMETER_MISMATCH
    assert strict.speedl([6.0, *STILL[1:]], 1.0, 100, True) == TaskState.PARAMETER_MISMATCH


# -- jogs ----------------------------------------------------------------------------------------


def jog(**given: Any) -> MoveJogTaskParam:
    settings = {"jog_direction": 1, "jog_type": 2, "axis_num": 0, "vel": 50.0, "jog_coordinate": 1}
    return MoveJogTaskParam(**(settings | given))


def test_a_jog_goes_on_until_it_is_ended(sim: Simulator, robot: Program) -> None:
    id_ = robot.move_jog(jog(jog_direction=-1, axis_num=5), False)
    sim.wait_until(lambda: sim.joints[5] < -0.1, 60.0)
    assert robot.stop_manual_move(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(id_) == TaskState.FINISHED
    assert not sim.moving
    assert robot.stop_manual_move(True) == TaskState.FINISHED


@pytest.mark.slow
@pytest.mark.parametrize("frame", [0, 1, 2, 3])
def test_a_cartesian_jog_follows_the_axes_of_its_frame(
    sim: Simulator, robot: Program, frame: int
) -> None:
    assert robot.set_wobj("bench", [0.1, 0.0, 0.0, 0.0, 0.0, 0.5]) == TaskState.FINISHED
    start = Pose.from_matrix(sim.arm.fkine(sim.joints))
    step = jog(jog_type=1, jog_coordinate=frame, use_step=True, step_cartvalue=0.05)
    assert robot.move_jog(step, True) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    moved = sim.arm.fkine(sim.joints)[:3, 3] - start.matrix[:3, 3]
    axes = {2: start.matrix[:3, 0].tolist(), 3: [math.cos(0.5), math.sin(0.5), 0.0]}
    axis: list[float] = axes.get(frame, [1.0, 0.0, 0.0])
    assert moved == pytest.approx([0.05 * a for a in axis], abs=1e-3)
    robot.move_jog(jog(jog_type=1, jog_coordinate=frame, jog_direction=-1), False)
    there = sim.arm.fkine(sim.joints)[:3, 3]
    sim.wait_until(
        lambda: float(sum((sim.arm.fkine(sim.joints)[:3, 3] - there) ** 2)) > 0.02**2, 60.0
    )
    assert robot.stop_manual_move(True) == TaskState.FINISHED
    back = sim.arm.fkine(sim.joints)[:3, 3] - there
    assert back @ [-a for a in axis] == pytest.approx(float(sum(back**2)) ** 0.5, rel=0.02)


@pytest.mark.slow
def test_a_jog_along_the_world_of_an_arm_at_a_wall(started: Started) -> None:
    step = jog(jog_type=1, axis_num=2, use_step=True, step_cartvalue=0.05)
    moved: list[np.ndarray] = []
    for frame in (JogFrame.WORLD, JogFrame.BASE):
        sim, robot = started(mounting="wall")
        start = sim.arm.fkine(sim.joints)[:3, 3]
        assert robot.move_jog(replace(step, jog_coordinate=frame), True) == TaskState.FINISHED
        way = sim.arm.fkine(sim.joints)[:3, 3] - start
        moved.append(sim.mounting.matrix[:3, :3] @ way)
    world, base = moved
    assert world == pytest.approx([0.0, 0.0, 0.05], abs=1e-3)  # up
    assert abs(base[2]) < 1e-3  # away from the wall


@pytest.mark.slow
def test_the_teaching_speed_scales_jogs(sim: Simulator, robot: Program) -> None:
    assert robot.set_teach_speed(40) == TaskState.FINISHED
    robot.move_jog(jog(vel=50.0), False)  # of 0.5 rad/s for a joint
    fastest = 0.0

    def far() -> bool:
        nonlocal fastest
        fastest = max(fastest, robot.get_target_joints_speed()[0])
        return bool(sim.joints[0] > 0.3)

    sim.wait_until(far, 60.0)
    assert robot.stop_manual_move(True) == TaskState.FINISHED
    assert fastest == pytest.approx(0.5 * 0.5 * 0.4, rel=1e-6)
    begun = sim.time
    step = jog(vel=50.0, use_step=True, step_jointValue=0.1)
    assert robot.move_jog(step, True) == TaskState.FINISHED
    assert sim.time - begun > 0.1 / (0.5 * 0.5 * 0.4)


def test_a_step_can_be_ended(sim: Simulator, robot: Program) -> None:
    id_ = robot.move_jog(jog(use_step=True, step_jointValue=3.0, vel=10.0), False)
    sim.wait_until(lambda: sim.joints[0] > 0.05, 60.0)
    assert robot.stop_manual_move(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(id_) == TaskState.STOPPED
    assert sim.joints[0] < 3.0


def test_a_jog_begins_only_where_nothing_else_runs(sim: Simulator, robot: Program) -> None:
    robot.to(2.0, *READY[1:], v=0.02, block=False)
    sim.wait_until(lambda: sim.moving)
    assert robot.move_jog(jog(), True) == TaskState.ILLEGAL
    assert robot.move_jog(jog(use_step=True, step_jointValue=0.1), True) == TaskState.ILLEGAL
    assert robot.teach_mode(True) == TaskState.ILLEGAL
    assert robot.stop(True) == TaskState.FINISHED


@for_each(
    "wrong",
    [
        {"jog_direction": 0},
        {"jog_type": 3},
        {"axis_num": 6},
        {"jog_coordinate": 4},
        {"vel": 0.0},
        {"vel": math.nan},
        {"use_step": True, "step_jointValue": 0.0},
    ],
)
def test_wrong_jogs(strict: Program, wrong: dict[str, Any]) -> None:
    assert strict.move_jog(jog(**wrong), True) == TaskState.PARAMETER_MISMATCH


# -- hand guiding --------------------------------------------------------------------------------


@pytest.mark.slow
def test_hand_guiding_holds_the_arm_and_lets_it_be_pushed(sim: Simulator, robot: Program) -> None:
    assert robot.teach_mode(True) == TaskState.FINISHED
    assert robot.to(*READY) == TaskState.ILLEGAL
    let_pass(sim, 2.0)
    assert max(abs(a - b) for a, b in zip(sim.joints, READY, strict=True)) < 5e-3
    sim.push([0.0, 30.0, 0.0, 0.0, 0.0, 0.0])
    sim.wait_until(lambda: sim.joints[0] > 0.2, 20.0)
    sim.push(STILL)
    let_pass(sim, 2.0)
    assert robot.end_teach_mode(True) == TaskState.FINISHED
    assert robot.get_robot_state() == [6, 0, 5, 1]
    rest = sim.joints
    assert robot.to(*READY) == TaskState.FINISHED
    assert rest[0] > 0.2


def test_a_stop_ends_hand_guiding(sim: Simulator, robot: Program) -> None:
    assert robot.teach_mode(True) == TaskState.FINISHED
    assert robot.stop(True) == TaskState.FINISHED
    assert robot.end_teach_mode(True) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    assert robot.to(*READY) == TaskState.FINISHED
