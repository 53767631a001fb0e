"""The track pool over the wire."""

from __future__ import annotations

import math

import pytest

from aioduco._wire.rpc import Op, PointOp
from aioduco.models.enums import TaskState
from aioduco.models.pose import Joints, Pose
from aioduco.sim.simulator import READY, Simulator

from .conftest import Program


def turned(angle: float) -> list[float]:
    return [angle, *READY[1:]]


def test_a_pool_of_joints_is_followed_until_it_is_dry(sim: Simulator, robot: Program) -> None:
    points = [turned(0.01 * i) for i in range(1, 101)]
    assert robot.trackClearQueue() == TaskState.FINISHED
    assert robot.trackEnqueue(points[:60], True) == TaskState.FINISHED
    assert robot.trackEnqueue(points[60:], True) == TaskState.FINISHED
    assert robot.getQueueSize() == 100
    begin = sim.time
    assert robot.trackJointMotion(1.0, 4.0, True) == TaskState.FINISHED
    assert 1.48 < sim.time - begin < 2.5
    assert robot.getQueueSize() == 0
    sim.wait_until(lambda: not sim.moving)
    assert sim.joints.almost_equal(Joints.of(points[-1]), 1e-3)


@pytest.mark.slow
def test_a_pool_of_poses_is_followed_in_the_work_object(sim: Simulator, robot: Program) -> None:
    assert robot.set_wobj("bench", [0.1, 0.0, 0.0, 0.0, 0.0, 0.5]) == TaskState.FINISHED
    start = Pose.of(robot.get_tcp_pose_coord("", "bench"))
    goals = [list(start.shifted(x=0.002 * i)) for i in range(1, 51)]
    assert robot.trackEnqueue(goals, True) == TaskState.FINISHED
    assert robot.trackCartMotion(0.1, 1.0, True, "", "bench", 0.005) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    there = Pose.of(robot.get_tcp_pose_coord("", "bench"))
    assert there.almost_equal(Pose.of(goals[-1]), position=1e-3, rotation=2e-3)


def test_a_full_pool_answers_minus_one_and_takes_nothing_in_part(robot: Program) -> None:
    assert robot.trackEnqueue([turned(0.1)] * 999, False) >= 1000
    assert robot.trackEnqueue([turned(0.1)] * 2, False) == -1
    assert robot.trackEnqueue([turned(0.1)], True) == TaskState.FINISHED
    assert robot.trackEnqueueOp([PointOp(turned(0.1), Op())], True) == -1
    assert robot.getQueueSize() == 1000
    assert robot.trackClearQueue() == TaskState.FINISHED
    assert robot.getQueueSize() == 0


def test_a_dry_pool_is_done_at_once_and_a_filled_one_is_followed_again(
    sim: Simulator, robot: Program
) -> None:
    assert robot.trackJointMotion(1.0, 4.0, True) == TaskState.FINISHED
    assert robot.trackEnqueue([turned(0.1)], True) == TaskState.FINISHED
    assert abs(sim.joints[0]) < 1e-3
    assert robot.trackJointMotion(1.0, 4.0, True) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    assert sim.joints[0] == pytest.approx(0.1, abs=1e-3)


def test_points_set_outputs(robot: Program) -> None:
    op = Op(time_or_dist_1=1, trig_io_1=3, trig_value_1=True)
    register = Op(time_or_dist_1=2, trig_io_1=105, trig_value_1=True)
    points = [PointOp(turned(0.1), op), PointOp(turned(0.2), register)]
    assert robot.trackEnqueueOp(points, True) == TaskState.FINISHED
    assert not robot.get_standard_digital_out(3)
    assert robot.trackJointMotion(1.0, 4.0, True) == TaskState.FINISHED
    assert robot.get_standard_digital_out(3)
    assert robot.getRobotIOStatus().boolRegisterOutputs[4]


def test_a_stop_ends_it_and_the_points_stay(sim: Simulator, robot: Program) -> None:
    assert robot.trackEnqueue([turned(0.02 * i) for i in range(1, 101)], True) == 4
    id_ = robot.trackJointMotion(0.05, 1.0, False)
    sim.wait_until(lambda: sim.joints[0] > 0.05, 60.0)
    assert robot.stop(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(id_) == TaskState.STOPPED
    assert 0 < robot.getQueueSize() < 100


def test_wrong_parameters(strict: Program) -> None:
    assert strict.trackJointMotion(0.0, 1.0, True) == TaskState.PARAMETER_MISMATCH
    assert strict.trackJointMotion(1.0, 40.0, True) == TaskState.PARAMETER_MISMATCH
    assert strict.trackCartMotion(0.1, math.nan, True, "", "", 0.0) == TaskState.PARAMETER_MISMATCH
    assert strict.trackCartMotion(0.1, 1.0, True, "saw", "", 0.0) == TaskState.ILLEGAL
    for wrong in ([0.0] * 5, [math.nan] * 6, [7.0] * 6):
        assert strict.trackEnqueue([wrong], True) == TaskState.PARAMETER_MISMATCH
    event = Op(time_or_dist_1=1, trig_event_1="weld")
    assert strict.trackEnqueueOp([PointOp(turned(0.1), event)], True) == 8
    nowhere = Op(time_or_dist_1=1, trig_io_1=17)
    assert strict.trackEnqueueOp([PointOp(turned(0.1), nowhere)], True) == 8
    assert strict.getQueueSize() == 0
