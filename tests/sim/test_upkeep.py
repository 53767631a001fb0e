"""Files, settings of pendant and collisions, reach, and service."""

from __future__ import annotations

import logging
import math

import pytest
from for_each import for_each

from aioduco._wire import idl
from aioduco.errors import ControllerError
from aioduco.models.enums import OperationMode, TaskState
from aioduco.models.pose import Pose
from aioduco.sim.handlers import NOT_PUBLIC
from aioduco.sim.refusal import Forgiving, Rejected
from aioduco.sim.simulator import READY, Simulator

from .conftest import OUT_OF_RANGE, Program, advance_until, standing_time

#: how near its end a set-point may be in the cycle before the last one [rad]
END = 1e-5


@for_each("name", sorted(NOT_PUBLIC))
def test_what_is_not_public_is_refused(strict: Program, name: str) -> None:
    nothing = tuple(zero() for zero in idl.functions()[name].zeros)
    with pytest.raises(ControllerError, match=f"{name} is not simulated: the vendor does not"):
        strict.connection.call(name, nothing)


def test_files_are_those_of_the_project(sim: Simulator, robot: Program) -> None:
    sim.cabinet.project.files |= {"program/pick.lua", "program/parts/a.lua", "notes.txt"}
    root = robot.get_current_project()
    assert robot.get_files_list(root + "program") == {"pick.lua": 1, "parts": 0}
    assert robot.get_files_list("") == {"program": 0, "notes.txt": 1}
    assert robot.get_files_list("program/parts/..") == {"pick.lua": 1, "parts": 0}
    for path in ("..", "/", "/etc", root + "../..", "program/../..", "/project2"):
        assert robot.get_files_list(path) == {}
        assert "not in the project" in robot.get_last_error()[-1]
    assert robot.get_files_list("nothing") == {}
    assert "no folder" in robot.get_last_error()[-1]


def test_settings_keep_to_their_range(sim: Simulator, robot: Program) -> None:
    assert robot.set_teach_speed(30) == TaskState.FINISHED
    wrong = [robot.set_teach_speed(0), robot.set_teach_speed(101)]
    wrong += [robot.collision_detect(-1), robot.collision_detect(6)]
    assert wrong == [OUT_OF_RANGE] * 4
    assert robot.get_teach_speed() == 30
    assert robot.set_teach_pendant(False) == TaskState.FINISHED
    assert not sim.cabinet.pendant_enabled
    sim.cabinet.encoder_count = -5_000_000_000
    assert robot.read_encoder_count() == -5_000_000_000


def test_collisions_are_not_detected_at_level_0(sim: Simulator, robot: Program) -> None:
    assert robot.collision_detect(0) == TaskState.FINISHED
    sim.collide(2)
    assert not robot.getRobotStatus().collision
    assert robot.collision_detect(5) == TaskState.FINISHED
    sim.collide(2)
    assert robot.getRobotStatus().collisionAxis == 2


def test_a_switch_at_the_cabinet_decides_the_mode(sim: Simulator, robot: Program) -> None:
    with standing_time(sim):
        robot.to(1.0, *READY[1:], v=0.2, block=False)
        advance_until(sim, robot.robotmoving)
        sim.switch_mode(OperationMode.REMOTE)
    sim.wait_until(lambda: sim.view.standing)
    assert robot.get_robot_state() == [6, 3, 5, 2]
    robot.stop(True)
    sim.cabinet.mode_switch = True
    assert robot.switch_mode(1) == TaskState.ILLEGAL
    assert "a switch at the cabinet" in robot.get_last_error()[-1]
    assert robot.get_robot_state() == [6, 0, 5, 2]
    sim.switch_mode(OperationMode.AUTO)
    assert robot.get_robot_state() == [6, 0, 5, 1]


@pytest.mark.slow
def test_a_dry_run_leaves_the_arm_where_it_is(sim: Simulator, robot: Program) -> None:
    robot.to(0.4, *READY[1:])
    there = sim.joints.array
    assert robot.simulation(True, True) == TaskState.FINISHED
    assert sim.view.simulation
    goal = [-0.6, 0.2, *READY[2:]]
    assert robot.to(*goal) == TaskState.FINISHED
    assert robot.get_actual_joints_position() == pytest.approx(goal, abs=END)
    assert robot.get_target_joints_position() == pytest.approx(goal, abs=END)
    flange = sim.arm.fkine(goal)
    assert list(robot.get_tcp_pose()) == pytest.approx(list(Pose.from_matrix(flange)), abs=END)
    assert sim.joints.array == pytest.approx(there, abs=1e-4)
    # Power goes on and off as it does with the real arm.
    assert robot.disable(True) == robot.enable(True) == TaskState.FINISHED
    assert robot.get_actual_joints_position() == pytest.approx(goal, abs=END)
    assert robot.get_actual_joints_torque() == robot.get_ext_torque() == [0.0] * 6
    sim.set_digital_input(3, True)
    assert robot.get_standard_digital_in(3)
    assert robot.set_standard_digital_out(4, True, True) == TaskState.FINISHED
    assert sim.get_digital_output(4)

    assert robot.simulation(False, True) == TaskState.FINISHED
    # At once, and what motions begin from: the arm does not jump to where the dry run ended.
    assert robot.get_actual_joints_position() == pytest.approx(there, abs=1e-3)
    assert robot.get_target_joints_position() == pytest.approx(there, abs=1e-3)
    assert robot.robotmoving() is False
    speeds: list[float] = []

    def watched() -> bool:
        speeds.append(max(map(abs, robot.get_actual_joints_speed())))
        return not sim.moving and len(speeds) > 20

    sim.wait_until(watched)
    assert max(speeds) < 0.05
    assert robot.to(*goal) == TaskState.FINISHED
    assert sim.joints.array == pytest.approx(goal, abs=1e-3)


def test_simulation_is_switched_at_rest_only(sim: Simulator, robot: Program) -> None:
    for there in (True, False):  # into it, and back
        with standing_time(sim):
            robot.to(1.0, *READY[1:], v=0.2, block=False)
            advance_until(sim, robot.robotmoving)
            assert robot.simulation(there, True) == TaskState.ILLEGAL
            assert robot.get_last_error()[-1] == "simulation: the robot moves"
            robot.pause(False)
        sim.wait_until(lambda: not robot.robotmoving())
        assert robot.simulation(there, True) == TaskState.ILLEGAL
        assert robot.get_last_error()[-1] == "simulation: motions are under way or wait"
        robot.stop(True)
        assert robot.simulation(there, True) == TaskState.FINISHED
        assert robot.simulation(there, True) == TaskState.FINISHED  # already so
        assert sim.view.simulation is there
        assert robot.to(*READY) == TaskState.FINISHED


def test_nothing_pushes_at_a_simulated_arm(sim: Simulator, robot: Program) -> None:
    robot.set_load_data([3.0, 0.0, 0.0, 0.1])
    robot.simulation(True, True)
    sim.push((0.0, 0.0, -400.0, 0.0, 0.0, 0.0))
    assert robot.to(0.3, 0.3, *READY[2:]) == TaskState.FINISHED
    assert robot.get_tcp_force() == pytest.approx([0.0] * 6, abs=1e-6)
    assert robot.get_robot_state() == [6, 0, 5, 1]


@pytest.mark.slow
def test_a_controller_that_starts_again_has_the_real_arm(sim: Simulator, robot: Program) -> None:
    robot.simulation(True, True)
    robot.to(0.3, *READY[1:])
    robot.connection.call("restart", (False,))
    sim.wait_until(lambda: not sim.view.simulation, 60.0)
    assert sim.joints.array == pytest.approx(READY, abs=1e-3)


def test_reach_is_checked_from_any_mounting(sim: Simulator, robot: Program) -> None:
    q = [0.3, 0.1, 1.4, 0.2, -1.3, 0.5]
    base = Pose(1.0, 2.0, 0.5, 0.1, 0.2, 0.3)
    wobj, tool = Pose(1.2, 2.0, 0.4, 0.0, 0.0, 1.0), Pose(0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
    point = wobj.inverse() @ base @ Pose.from_matrix(sim.arm.fkine(q)) @ tool
    found = robot.reach_check(list(base), list(wobj), list(tool), q, [list(point)])
    assert found.result
    assert found.joints_pos == [pytest.approx(q, abs=1e-6)]
    far = [5.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    answer = robot.reach_check(list(base), list(wobj), list(tool), q, [list(point), far])
    assert (answer.result, answer.joints_pos) == (False, [])
    assert not robot.reach_check(list(base), list(wobj), list(tool), q[:5], []).result
    assert robot.get_last_error()[-1].startswith("reach_check: ref_pos has 5 numbers")


def test_dynamic_calibration_is_kept(robot: Program) -> None:
    assert robot.get_dynamic_calibration_params() == []
    assert robot.set_dynamic_calibration_params([[1.0, 2.0], []]) == TaskState.FINISHED
    assert robot.set_dynamic_calibration_params([[math.nan]]) == TaskState.PARAMETER_MISMATCH
    assert robot.get_dynamic_calibration_params() == [[1.0, 2.0], []]


def test_what_is_forgiven_is_said_once_for_each_kind_and_counted(
    caplog: pytest.LogCaptureFixture,
) -> None:
    forgiving = Forgiving()
    with caplog.at_level(logging.WARNING, "aioduco.sim.refusal"):
        for smoothing in (0.0, 200.0):
            forgiving.forgive("servo smoothing", f"smooth_vel is {smoothing}")
        forgiving.forgive("speed", "v is 30")
    assert [record.getMessage() for record in caplog.records] == [
        "forgiven, said once for servo smoothing: smooth_vel is 0.0",
        "forgiven, said once for speed: v is 30",
    ]
    assert forgiving.counts == {"servo smoothing": 2, "speed": 1}


def test_a_strict_simulator_forgives_nothing() -> None:
    forgiving = Forgiving(strict=True)
    with pytest.raises(Rejected, match="v is 30") as refused:
        forgiving.forgive("speed", "v is 30")
    assert refused.value.state is TaskState.PARAMETER_MISMATCH
    assert forgiving.counts == {}
