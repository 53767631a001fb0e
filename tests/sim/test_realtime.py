"""Realtime control over the wire: the manual's steps and example, and what goes wrong."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import pytest
from example_modules import example

from aioduco._wire.rpc import RealTimeControlData
from aioduco.models.enums import TaskState
from aioduco.sim.planner.track_pool import CAPACITY
from aioduco.sim.simulator import READY, Simulator

from .conftest import Aside, Program, advance_until, standing_time

#: manual 3.8, 1.3.15, the example: joint velocities, a row for each millisecond [rad/s]
ROWS: list[list[float]] = example("manual/cabinet").JOINTS_VEL


def velocity(row: list[float]) -> RealTimeControlData:
    return RealTimeControlData(joint_vel_cmd=row, status=True)


# The manual's example, line by line, with its comments. Simulated time goes on in its `usleep`, on
# an absolute schedule, and stands otherwise, so that a busy machine makes it no slower.


def begin_the_manuals_example(duco_cobot: Program) -> None:
    """Steps 1 to 5, up to the loop."""
    # 机器人已经上电上使能
    # 清空实时数据队列
    assert duco_cobot.clear_realtime_data_queue() == TaskState.FINISHED
    assert duco_cobot.get_realtime_data_queue_size() == 0
    real_data_vec = []
    # 将关节速度赋值给实时数据结构体变量
    for i in range(len(ROWS)):
        rt_data = RealTimeControlData()
        rt_data.joint_vel_cmd = ROWS[i]
        # 数据更新状态为 true
        rt_data.status = True
        real_data_vec.append(rt_data)
    # 将数据传进队列
    assert duco_cobot.realtime_data_enqueue(real_data_vec, True) == TaskState.FINISHED
    assert duco_cobot.get_realtime_data_queue_size() == len(ROWS)
    # 以关节速度控制方式打开实时控制模式
    assert duco_cobot.start_realtime_mode(1, 100, 0.04) == TaskState.FINISHED


def feed_as_the_manual(
    duco_cobot: Program, sim: Simulator, stop_realtime_control: Callable[[], bool]
) -> int:
    """Step 6: how many points were sent."""
    sent, start = 0, sim.time
    # 不断地向队列填充数据
    while not stop_realtime_control():
        real_data_vec = []
        rt_data = RealTimeControlData()
        rt_data.joint_vel_cmd = ROWS[len(ROWS) - 1]
        rt_data.status = True
        real_data_vec.append(rt_data)
        assert duco_cobot.realtime_data_enqueue(real_data_vec, True) == TaskState.FINISHED
        sent += 1
        due = start + 0.001 * sent
        advance_until(sim, functools.partial(_has_come, sim, due))  # usleep(1000)
    return sent


def _has_come(sim: Simulator, due: float) -> bool:
    return sim.time >= due


def test_the_manuals_example_runs(sim: Simulator, robot: Program, aside: Aside) -> None:
    duco_cobot, start = robot, list(sim.joints)
    with standing_time(sim):
        end = sim.time + 0.2
        begin_the_manuals_example(duco_cobot)
        sent = feed_as_the_manual(duco_cobot, sim, lambda: sim.time >= end)
        assert duco_cobot.get_robot_state() == [6, 2, 5, 1]
        moved = [a - b for a, b in zip(sim.joints, start, strict=True)]
        # 关闭实时控制模式: the arm comes to rest in it, and points go on until it has been told
        ended = aside(sim, lambda other: other.end_realtime_mode())
        feed_as_the_manual(duco_cobot, sim, ended.done)
        assert ended.result() == TaskState.FINISHED
    assert duco_cobot.get_robot_state() == [6, 0, 5, 1]
    assert duco_cobot.get_last_error() == []
    # The first rows, which rise, are a tenth of it; the last ones may still be in the queue.
    assert moved[2] == pytest.approx(ROWS[-1][2] * 0.001 * (sent + len(ROWS)), rel=0.15)
    assert moved[1] / moved[2] == pytest.approx(ROWS[-1][1] / ROWS[-1][2], rel=0.05)


def test_a_starved_queue_stops_the_arm(sim: Simulator, robot: Program) -> None:
    robot.realtime_data_enqueue([velocity(ROWS[0])] * 5 + [velocity(ROWS[-1])] * 500, True)
    assert robot.start_realtime_mode(1, 100.0, 0.04) == TaskState.FINISHED
    sim.wait_until(lambda: robot.get_robot_state()[2] != 5)
    sim.wait_until(lambda: sim.view.standing)
    # STOP2: the power is on, and the way out is power off, power on, enable
    assert robot.get_robot_state() == [6, 0, 7, 1]
    assert "no data for 0.04 s" in robot.get_last_error()[-1]
    here, later = sim.joints, sim.time + 0.05
    robot.realtime_data_enqueue([velocity(ROWS[-1])] * 50, True)
    sim.wait_until(lambda: sim.time > later)
    assert sim.joints.almost_equal(here, 1e-4)  # no point that comes now moves it
    assert robot.start_realtime_mode(1, 100.0, 0.04) == TaskState.ILLEGAL
    assert robot.end_realtime_mode() == TaskState.FINISHED
    assert robot.power_off(True) == TaskState.FINISHED
    robot.bring_up()
    assert robot.to(*READY) == TaskState.FINISHED


@pytest.mark.slow
def test_positions_are_followed(sim: Simulator, robot: Program) -> None:
    count = 800
    points = [[0.05 * (1 - math.cos(math.pi * i / count)), *READY[1:]] for i in range(count)]
    data = [RealTimeControlData(joint_pos_cmd=point, status=True) for point in points]
    robot.clear_realtime_data_queue()
    robot.realtime_data_enqueue(data, True)
    assert robot.start_realtime_mode(0, 0.0, 10.0) == TaskState.FINISHED
    sim.wait_until(lambda: robot.get_realtime_data_queue_size() == 0)
    sim.wait_until(lambda: abs(sim.joints[0] - 0.1) < 1e-3)
    assert robot.end_realtime_mode() == TaskState.FINISHED


def test_a_first_point_elsewhere_is_a_fault_and_nothing_moves(
    sim: Simulator, robot: Program
) -> None:
    elsewhere = RealTimeControlData(joint_pos_cmd=[0.5, *READY[1:]], status=True)
    robot.realtime_data_enqueue([elsewhere], True)
    assert robot.start_realtime_mode(0, 100.0, 0.04) == TaskState.ERROR
    assert "first point" in robot.get_last_error()[-1]
    assert robot.get_robot_state() == [6, 0, 7, 1]
    assert abs(sim.joints[0]) < 1e-3


def test_other_motions_are_not_taken_meanwhile_nor_it_while_one_runs(
    sim: Simulator, robot: Program
) -> None:
    assert robot.start_realtime_mode(0, 100.0, 1000.0) == TaskState.FINISHED
    assert robot.to(*READY) == TaskState.ILLEGAL
    assert robot.start_realtime_mode(1, 100.0, 0.04) == TaskState.ILLEGAL
    assert robot.stop(True) == TaskState.FINISHED
    assert robot.get_robot_state() == [6, 0, 5, 1]
    robot.to(2.0, *READY[1:], v=0.02, block=False)
    sim.wait_until(lambda: sim.moving)
    assert robot.start_realtime_mode(0, 100.0, 0.04) == TaskState.ILLEGAL
    assert robot.stop(True) == TaskState.FINISHED


def test_wrong_parameters_and_wrong_points(strict: Program) -> None:
    assert strict.start_realtime_mode(5, 100.0, 0.04) == TaskState.PARAMETER_MISMATCH
    assert strict.start_realtime_mode(1, -1.0, 0.04) == TaskState.PARAMETER_MISMATCH
    assert strict.start_realtime_mode(1, 100.0, math.nan) == TaskState.PARAMETER_MISMATCH
    assert strict.start_realtime_mode(2, 100.0, 0.04) == TaskState.PARAMETER_MISMATCH
    assert "torques" in strict.get_last_error()[-1]
    for wrong in ([math.nan] * 6, [0.0] * 5):
        assert strict.realtime_data_enqueue([velocity(wrong)], True) == TaskState.PARAMETER_MISMATCH
    short = RealTimeControlData(joint_pos_cmd=[0.0] * 5, status=True)
    assert strict.realtime_data_enqueue([short], True) == TaskState.ILLEGAL
    assert strict.get_realtime_data_queue_size() == 0


def test_a_point_whose_status_is_false_is_passed_over(robot: Program) -> None:
    stale = RealTimeControlData(joint_vel_cmd=ROWS[0], status=False)
    assert robot.realtime_data_enqueue([stale, velocity(ROWS[0])], True) == TaskState.FINISHED
    assert robot.get_realtime_data_queue_size() == 1


def test_a_full_queue_takes_no_more_and_nothing_in_part(robot: Program) -> None:
    points = [velocity(ROWS[0])] * CAPACITY
    assert robot.realtime_data_enqueue(points[1:], True) == TaskState.FINISHED
    assert robot.realtime_data_enqueue(points[:2], True) == -1
    assert robot.get_realtime_data_queue_size() == CAPACITY - 1
    assert robot.realtime_data_enqueue(points[:1], True) == TaskState.FINISHED
    assert robot.clear_realtime_data_queue() == TaskState.FINISHED
    assert robot.get_realtime_data_queue_size() == 0
