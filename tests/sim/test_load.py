"""The load that is held, and the forces at the tool."""

from __future__ import annotations

import math

import pytest

from aioduco._wire.rpc import Op
from aioduco.kinematics import arm
from aioduco.models.enums import TaskState
from aioduco.sim.scene import Rod
from aioduco.sim.simulator import Simulator

from .conftest import OUT_OF_RANGE, Program, Started, advance_until, let_pass, standing_time

NOTHING = [0.0] * 6


def settle(sim: Simulator) -> None:
    """Let the drives come to rest."""
    let_pass(sim, 0.5)


@pytest.mark.parametrize("tared", [False, True])
def test_a_load_that_is_set_is_no_force_in_any_cycle(
    sim: Simulator, robot: Program, tared: bool
) -> None:
    """The sensor felt its weight a cycle later than it knew of it, and was tared in between."""
    with standing_time(sim):
        robot.set_load_data([2.0, 0.0, 0.02, 0.05])
        if tared:
            robot.fc_force_set_value([True] * 6, [0.0] * 6)
        for _ in range(20):
            assert robot.get_tcp_force() == pytest.approx(NOTHING, abs=0.5)
            sim.advance(1)
        sim.advance(300)
        weight = 0.0 if tared else 2.0 * 9.81
        assert robot.get_tcp_force() == pytest.approx(NOTHING, abs=0.05)
        assert robot.fc_get_ft()[2] == pytest.approx(weight, abs=0.05)


def test_a_push_is_felt_at_the_tip(sim: Simulator, robot: Program) -> None:
    robot.set_tool_data("probe", [0.0, 0.0, 0.2, 0.0, 0.0, math.pi / 2], [0.0] * 4, [0.0] * 6)
    sim.push([5.0, 0.0, -10.0, 0.0, 0.0, 0.0])
    settle(sim)
    force = robot.get_tcp_force()
    assert force[:3] == pytest.approx([5.0, 0.0, -10.0], abs=0.1)
    # The flange looks down: the tip is 0.2 m below it, and the push is at the flange.
    assert force[3:] == pytest.approx([0.0, 1.0, 0.0], abs=0.05)
    assert robot.get_tcp_force_tool("default")[2] == pytest.approx(10.0, abs=0.1)
    assert robot.get_tcp_force_tool("")[:3] != pytest.approx(force[:3], abs=1.0)
    sim.push(NOTHING)
    assert robot.get_tcp_force_tool("saw") == []
    assert "no tool 'saw'" in robot.get_last_error()[-1]


@pytest.mark.slow
def test_friction_is_felt_against_the_motion(sim: Simulator, robot: Program) -> None:
    dry = [6.0, 6.0, 6.0, 1.0, 1.0, 1.0]
    sim.drag(dry)
    op = Op()
    goal = [0.5, 0.2, 1.2, 0.3, -1.2, 0.4]
    with standing_time(sim):
        robot.movej2(goal, 0.5, 2.0, 0.0, False, op, False)
        advance_until(sim, lambda: min(map(abs, robot.get_actual_joints_speed())) > 0.05)
        speeds = robot.get_actual_joints_speed()
        felt = [-torque if speed > 0.0 else torque for torque, speed in zip(
            robot.get_ext_torque(), speeds, strict=True)]  # fmt: skip
        assert felt == pytest.approx(dry, rel=0.2)
        sim.drag([0.0] * 6)
        advance_until(sim, lambda: not sim.moving)
        robot.movej2(
            [0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0], 0.5, 2.0, 0.0, False, op, False
        )
        advance_until(sim, lambda: min(map(abs, robot.get_actual_joints_speed())) > 0.05)
        assert robot.get_ext_torque() == pytest.approx([0.0] * 6, abs=0.2)


def test_an_arm_may_have_lengths_of_its_own() -> None:
    with Simulator(arm("gcr5_910", a2=0.5)) as longer:
        assert longer.arm.geometry.a2 == 0.5
        assert longer.arm.name == "gcr5_910"


@pytest.mark.slow
def test_a_tool_is_carried_as_heavy_as_it_is_told_to_be(sim: Simulator, robot: Program) -> None:
    settle(sim)
    before = robot.get_actual_joints_torque()
    reach = math.hypot(*robot.get_flange_pose()[:2])
    tool = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]
    robot.set_tool_data("gripper", tool, [2.0, 0.0, 0.0, 0.05], [0.0] * 6)
    settle(sim)
    gripping = robot.get_actual_joints_torque()
    assert abs(gripping[1] - before[1]) == pytest.approx(2.0 * 9.81 * reach, rel=0.05)
    assert robot.set_load_data([1.0, 0.0, 0.0, 0.0]) == TaskState.FINISHED
    for wrong in ([36.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [1.0], [math.nan] * 4):
        assert robot.set_load_data(wrong) == OUT_OF_RANGE
    settle(sim)
    holding = robot.get_actual_joints_torque()
    assert abs(holding[1] - before[1]) == pytest.approx(3.0 * 9.81 * reach, rel=0.05)
    assert robot.get_tcp_force() == pytest.approx(NOTHING, abs=0.05)
    robot.to(0.3, 0.2, 1.2, 0.4, -0.8, 0.5)
    settle(sim)
    assert robot.get_tcp_force() == pytest.approx(NOTHING, abs=0.1)
    robot.set_load_data([0.0] * 4)
    robot.set_tool_data("default", [0.0] * 6, [0.0] * 4, [0.0] * 6)
    settle(sim)
    assert robot.get_tcp_force() == pytest.approx(NOTHING, abs=0.05)


@pytest.mark.slow
def test_a_tool_that_is_there_is_not_carried_twice(started: Started) -> None:
    sim, robot = started(tool=[Rod(length=0.1, mass=1.0)])
    settle(sim)
    before = robot.get_actual_joints_torque()
    # The flange looks down as it is tared; told of its tool, it knows its weight from then on.
    robot.set_tool_data("rod", [0.0, 0.0, 0.1, 0, 0, 0], [1.0, 0.0, 0.0, 0.05], [0.0] * 6)
    assert robot.fc_force_set_value([True] * 6, NOTHING) >= 1000
    settle(sim)
    assert robot.get_actual_joints_torque() == pytest.approx(before, abs=0.01)
    robot.to(0.0, 0.2, 1.2, 0.4, -0.8, 0.5)
    settle(sim)
    assert robot.get_tcp_force()[:3] == pytest.approx(NOTHING[:3], abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize(("told", "drifts"), [(2.0, False), (1.0, True)])
def test_a_wrong_load_drifts_where_the_arm_gives_way(
    sim: Simulator, robot: Program, told: float, drifts: bool
) -> None:
    sim.load(2.0)
    robot.set_load_data([told, 0.0, 0.0, 0.0])
    settle(sim)
    robot.fc_force_set_value([True] * 6, NOTHING)
    robot.to(0.0, 0.0, math.pi / 2, 1.2, -math.pi / 2, 0.0)  # the flange looks ahead
    settle(sim)
    assert robot.fc_get_ft()[:3] != pytest.approx(NOTHING[:3], abs=10.0)
    on, damping, cap = [True] * 3 + [False] * 3, [1000.0] * 3 + [57.0] * 3, [0.05] * 6
    robot.fc_config(on, NOTHING, damping, cap, NOTHING, "", "", 0)
    with standing_time(sim):
        robot.fc_start()
        here, begin = robot.get_tcp_pose(), sim.time
        robot.fc_move(False)
        advance_until(sim, lambda: sim.time > begin + 1.0)
        drift = math.dist(robot.get_tcp_pose()[:3], here[:3])
    # A kilogram that is not known of, and as much the other way that was tared.
    assert drift > 0.010 if drifts else drift < 0.001
    assert robot.stop(True) == TaskState.FINISHED
