"""Servo motions over the wire: chains, what waits, what is refused, what faults."""

from __future__ import annotations

import math
from typing import Any

import pytest
from for_each import for_each

from aioduco.models.enums import TaskState
from aioduco.models.pose import Joints, Pose
from aioduco.sim.planner.servo_follower import ServoFollower, ServoTuning
from aioduco.sim.simulator import READY, Simulator

from .conftest import Program, standing_time

GAINS = (200.0, 25.0, 10.0, 1.0)


def turned(angle: float) -> list[float]:
    return [angle, *READY[1:]]


def servoj(robot: Program, joints: Any, v: float = 1.0, a: float = 5.0, *gains: float) -> int:
    return robot.servoj(joints, v, a, False, *(gains or GAINS))


def test_the_latest_target_counts(sim: Simulator, robot: Program) -> None:
    first = servoj(robot, turned(2.0), 0.01)
    second = servoj(robot, turned(-0.2), 1.0)
    assert robot.get_noneblock_taskstate(first) == TaskState.INTERRUPT
    assert robot.ended(second) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    assert sim.joints.almost_equal(Joints.of(turned(-0.2)), 1e-3)


@pytest.mark.slow
def test_another_type_waits_until_the_running_one_has_ended(sim: Simulator, robot: Program) -> None:
    start = Pose.of(robot.get_tcp_pose())
    with standing_time(sim):
        first = servoj(robot, turned(0.5))
        dropped = robot.servo_tcp([0, 0, 0.3, 0, 0, 0], 1.0, 5.0, "", False, *GAINS)
        second = robot.servo_tcp([0, 0, 0.02, 0, 0, 0], 1.0, 5.0, "", False, *GAINS)
    assert robot.ended(second) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(first) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(dropped) == TaskState.INTERRUPT
    sim.wait_until(lambda: not sim.moving)
    turn = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.5)
    goal = turn @ start @ Pose(0.0, 0.0, 0.02, 0.0, 0.0, 0.0)
    assert Pose.of(robot.get_tcp_pose()).almost_equal(goal, position=1e-3, rotation=2e-3)


@pytest.mark.slow
def test_motions_wait_for_it_and_it_waits_for_them(sim: Simulator, robot: Program) -> None:
    moved = robot.to(*turned(0.2), block=False)
    servo = servoj(robot, turned(0.4))
    behind = robot.to(*turned(0.1), block=False)
    states = [robot.ended(id_) for id_ in (moved, servo, behind)]
    assert states == [TaskState.FINISHED] * 3
    sim.wait_until(lambda: not sim.moving)
    assert sim.joints.almost_equal(Joints.of(turned(0.1)), 1e-3)


@pytest.mark.parametrize("name", ["servoj_pose", "servol"])
def test_poses(sim: Simulator, robot: Program, name: str) -> None:
    goal = Pose.of(robot.get_tcp_pose()).shifted(x=0.05, z=-0.1)
    call = getattr(robot, name)
    assert call(list(goal), 1.0, 5.0, [], "", "", True, *GAINS) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    assert Pose.of(robot.get_tcp_pose()).almost_equal(goal, position=1e-3, rotation=2e-3)
    away = list(goal.shifted(x=5.0))
    assert call(away, 1.0, 5.0, [], "", "", True, *GAINS) == TaskState.ERROR
    assert "reach" in robot.get_last_error()[-1]
    assert call(list(goal), 1.0, 5.0, [], "saw", "", True, *GAINS) == TaskState.ILLEGAL
    assert call(list(goal), 1.0, 5.0, [1.0], "", "", True, *GAINS) == TaskState.ILLEGAL


def test_servo_tcp_goes_on_from_its_target(sim: Simulator, robot: Program) -> None:
    start = Pose.of(robot.get_tcp_pose())
    step = [0.0, 0.0, 0.01, 0.0, 0.0, 0.0]
    ids = [robot.servo_tcp(step, 1.0, 5.0, "", False, *GAINS) for _ in range(5)]
    assert robot.ended(ids[-1]) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    way = Pose.of(robot.get_tcp_pose()).distance(start)[0]
    # The simulation runs while the calls come: some may have ended before the next one came.
    assert way == pytest.approx(0.05, abs=2e-3)


def test_a_pause_and_a_stop_work_at_once(sim: Simulator, robot: Program) -> None:
    id_ = servoj(robot, turned(3.0), 0.05)
    sim.wait_until(lambda: sim.joints[0] > 0.01, 20.0)
    assert robot.pause(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(id_) == TaskState.PAUSED
    assert robot.get_robot_state() == [6, 3, 5, 1]
    assert robot.resume(True) == TaskState.FINISHED
    paused = sim.joints[0]
    sim.wait_until(lambda: sim.joints[0] > paused + 0.01, 20.0)
    assert robot.stop(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(id_) == TaskState.STOPPED
    assert sim.joints[0] < 3.0
    assert robot.get_robot_state() == [6, 0, 5, 1]


@pytest.mark.slow
def test_too_large_a_step_at_too_large_an_acceleration_is_a_position_deviation(
    sim: Simulator, robot: Program
) -> None:
    stretched = (0.0, math.pi / 2, -0.1, 0.0, -1.5, 0.0)
    assert robot.set_load_data([5.0, 0.0, 0.0, 0.0]) == TaskState.FINISHED
    assert robot.to(*stretched) == TaskState.FINISHED
    gentle = servoj(robot, (1.0, *stretched[1:]), 2.0, 2.0)
    assert robot.ended(gentle) == TaskState.FINISHED
    id_ = servoj(robot, (-2.0, *stretched[1:]), 3.9, math.inf, 1000.0, 60.0, 1.0, 0.0)
    assert robot.ended(id_) == TaskState.ERROR
    assert any("position deviation" in text for text in robot.get_last_error())
    assert robot.get_robot_state()[2] != 5


@for_each(
    "joints, numbers, state",
    [
        (READY[:5], (1.0, 5.0, *GAINS), TaskState.ILLEGAL),
        ((math.nan, *READY[1:]), (1.0, 5.0, *GAINS), TaskState.PARAMETER_MISMATCH),
        ((7.0, *READY[1:]), (1.0, 5.0, *GAINS), TaskState.PARAMETER_MISMATCH),
        (READY, (4.0, 5.0, *GAINS), TaskState.PARAMETER_MISMATCH),
        (READY, (0.0, 5.0, *GAINS), TaskState.PARAMETER_MISMATCH),
        (READY, (1.0, math.nan, *GAINS), TaskState.PARAMETER_MISMATCH),
        (READY, (1.0, 5.0, 0.0, 25.0, 10.0, 1.0), TaskState.PARAMETER_MISMATCH),
        (READY, (1.0, 5.0, 200.0, 25.0, 101.0, 1.0), TaskState.PARAMETER_MISMATCH),
        (READY, (1.0, 5.0, 200.0, 25.0, 10.0, 1.1), TaskState.PARAMETER_MISMATCH),
    ],
)
def test_wrong_parameters(strict: Program, joints: Any, numbers: Any, state: TaskState) -> None:
    v, a, *gains = numbers
    assert strict.servoj(joints, v, a, True, *gains) == state


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("numbers", "taken"),
    [
        pytest.param((1.0, 5.0, *GAINS[:2], 0.0, 0.0), (*GAINS[:3], 0.0), id="no smoothing"),
        pytest.param((3.5, 3.5, 400.0, 80.0, 5.0, 2.0), (400.0, 80.0, 5.0, 1.0), id="a ROS driver"),
        pytest.param((1.0, 5.0, 0.0, 25.0, 500.0, -1.0), (200.0, 25.0, 100.0, 0.0), id="far out"),
        pytest.param((30.0, 5.0, *GAINS), GAINS, id="speed"),
    ],
)
def test_smoothing_and_gains_left_out_or_out_of_their_range_are_taken(
    sim: Simulator, robot: Program, monkeypatch: pytest.MonkeyPatch, numbers: Any, taken: Any
) -> None:
    tunings: list[ServoTuning] = []
    aim = ServoFollower.aim

    def spy(self: ServoFollower, target: Any, tuning: ServoTuning) -> None:
        tunings.append(tuning)
        aim(self, target, tuning)

    monkeypatch.setattr(ServoFollower, "aim", spy)
    v, a, *gains = numbers
    assert robot.servoj(turned(0.2), v, a, True, *gains) == TaskState.FINISHED
    assert [gains_of(each) for each in tunings] == [taken]
    assert tunings[0].v == min(v, 1.25 * math.pi)
    assert sum(sim.forgiven.values()) >= 1
    assert robot.servoj(turned(0.0), 1.0, 5.0, True, *(math.nan,) * 4) == 8
    assert robot.servoj(turned(0.0), 1.0, 5.0, True, 0.0, 0.0, 0.0, 0.0) == TaskState.FINISHED
    assert gains_of(tunings[-1]) == GAINS  # those that are left out are the vendor's


def gains_of(tuning: ServoTuning) -> tuple[float, ...]:
    return tuning.kp, tuning.kd, tuning.smooth_vel, tuning.smooth_acc


@pytest.mark.slow
def test_the_global_speed_does_not_scale_it(sim: Simulator, robot: Program) -> None:
    begin = sim.time
    assert robot.ended(servoj(robot, turned(0.5))) == TaskState.FINISHED
    fast = sim.time - begin
    assert robot.speed(10.0) == TaskState.FINISHED
    begin = sim.time
    assert robot.ended(servoj(robot, turned(0.0))) == TaskState.FINISHED
    assert sim.time - begin < 3.0 * fast
