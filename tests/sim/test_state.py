"""What the simulated controller tells of the arm, its tools and its signals."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st
from kinematics.bias import bias_acceleration

import aioduco
from aioduco._wire.rpc import Op
from aioduco.kinematics import arm, models
from aioduco.kinematics.forward import fkine, jacobian
from aioduco.models.enums import TaskState
from aioduco.models.pose import Pose
from aioduco.sim.cabinet.tools import FrameTable
from aioduco.sim.force.sensor import SensorNoise
from aioduco.sim.handlers.state import tip_motion
from aioduco.sim.refusal import Rejected
from aioduco.sim.simulator import READY, Simulator
from aioduco.testing import eventually

from .conftest import (
    OUT_OF_RANGE,
    Connect,
    Program,
    Started,
    let_pass,
)

ANGLES = st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6).map(np.array)


@given(q=ANGLES, qd=ANGLES, qdd=ANGLES, model=st.sampled_from(models()))
def test_a_tip_moves_as_the_jacobian_says(
    q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, model: str
) -> None:
    geometry = arm(model).geometry
    found = tip_motion(geometry, q, qd, qdd, np.eye(4))
    jacobian_ = jacobian(geometry, q)
    assert Pose.of(found.pose).almost_equal(Pose.from_matrix(fkine(geometry, q)))
    assert found.speed == pytest.approx(jacobian_ @ qd, abs=1e-9)
    expected = jacobian_ @ qdd + bias_acceleration(geometry, q, qd)
    assert found.acceleration == pytest.approx(expected, abs=1e-9)


@given(q=ANGLES, qd=ANGLES, qdd=ANGLES)
def test_a_tip_beside_the_flange_moves_as_differences_say(
    q: np.ndarray, qd: np.ndarray, qdd: np.ndarray
) -> None:
    geometry, offset, h = (
        arm("gcr5_910").geometry,
        Pose(0.1, -0.05, 0.2, 0.3, 0.4, 0.5).matrix,
        1e-4,
    )

    def at(t: float) -> np.ndarray:
        pose: np.ndarray = fkine(geometry, q + qd * t + qdd * t * t / 2) @ offset
        return pose[:3, 3]

    found = tip_motion(geometry, q, qd, qdd, offset)
    assert found.pose[:3] == pytest.approx(at(0.0), abs=1e-12)
    assert found.speed[:3] == pytest.approx((at(h) - at(-h)) / (2 * h), abs=1e-4)
    bent = (at(h) - 2 * at(0.0) + at(-h)) / h**2
    assert found.acceleration[:3] == pytest.approx(bent, abs=1e-3)


def test_a_standing_robot_is_where_its_joints_put_it(sim: Simulator, robot: Program) -> None:
    let_pass(sim, 0.5)  # the brakes let go of the weight, and the arm settles
    flange = sim.arm.fkine(sim.joints)
    assert Pose.of(robot.get_flange_pose()).almost_equal(Pose.from_matrix(flange), position=1e-5)
    tip_pose = Pose.of(robot.get_tcp_pose())
    assert tip_pose.almost_equal(Pose.of(robot.get_flange_pose()), position=1e-5, rotation=1e-5)
    for name in ("joints_speed", "joints_acceleration"):
        for which in ("actual", "target"):
            assert getattr(robot, f"get_{which}_{name}")() == pytest.approx([0.0] * 6, abs=0.05)
    for name in ("get_tcp_speed", "get_tcp_acceleration", "get_flange_speed"):
        assert getattr(robot, name)() == pytest.approx([0.0] * 6, abs=0.05)
    assert robot.get_flange_acceleration() == pytest.approx([0.0] * 6, abs=0.05)
    assert robot.get_target_joints_position() == pytest.approx(list(sim.joints), abs=1e-4)
    # Joint 2 and 3 carry the forearm, joint 1 turns about the vertical.
    torque = robot.get_actual_joints_torque()
    assert abs(torque[1]) > 1.0
    assert abs(torque[0]) < 0.1


def turned(sim: Simulator) -> bool:
    return sim.joints[0] > 0.05


def test_one_status_is_of_one_instant_wherever_the_arm_is_mounted(started: Started) -> None:
    for mounting in ("floor", "wall", (0.5, -0.2, 0.8, 0.3, 0.2, 1.0)):
        sim, robot = started(mounting=mounting)
        robot.speedj([0.3] * 6, 5.0, -1, False)
        sim.wait_until(partial(turned, sim))
        status = robot.getRobotStatus()
        robot.stop(True)
        for kind in ("Expect", "Actual"):
            q = np.array(getattr(status, f"joint{kind}Position"))
            qd = np.array(getattr(status, f"joint{kind}Velocity"))
            pose = sim.mounting @ Pose.from_matrix(sim.arm.fkine(q))
            assert Pose.of(getattr(status, f"cart{kind}Position")).almost_equal(pose)
            turn = sim.mounting.matrix[:3, :3]
            speed = (np.reshape(sim.arm.jacobian(q) @ qd, (2, 3)) @ turn.T).ravel()
            assert getattr(status, f"cart{kind}Velocity") == pytest.approx(speed)


# -- tools and work objects ----------------------------------------------------------------------


def test_a_tool_is_used_once_it_is_set(sim: Simulator, robot: Program) -> None:
    offset = Pose(0.0, 0.01, 0.15, 0.0, 0.0, 0.5)
    assert robot.set_tool_data("gripper", list(offset), [1.5, 0.0, 0.0, 0.05], [0.0] * 6) == 4
    assert robot.get_tcp_offset() == list(offset)
    assert robot.get_tool_load() == [1.5, 0.0, 0.0, 0.05]
    flange = Pose.of(robot.get_flange_pose())
    assert Pose.of(robot.get_tcp_pose()).almost_equal(flange @ offset, position=1e-5, rotation=1e-5)
    goal = Pose.of(robot.get_tcp_pose()).shifted(z=-0.05)
    assert robot.line(list(goal)) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    assert Pose.of(robot.get_tcp_pose()).almost_equal(goal, position=1e-3, rotation=2e-3)

    def told_alike() -> bool:
        in_flange = Pose.of(robot.get_tcp_pose_coord("default", "default"))
        return in_flange.almost_equal(
            Pose.of(robot.get_flange_pose()), position=1e-5, rotation=1e-5
        )

    eventually(told_alike)  # the arm settles between the two calls


def test_poses_are_in_the_work_object_in_use(sim: Simulator, robot: Program) -> None:
    frame = Pose(0.3, 0.1, 0.2, 0.0, 0.0, math.pi / 2)
    assert robot.set_wobj("pallet", list(frame)) == TaskState.FINISHED
    assert robot.get_wobj() == pytest.approx(list(frame))
    here = Pose.of(robot.get_tcp_pose_coord("", "pallet"))
    base = Pose.of(robot.get_tcp_pose())
    assert (frame @ here).almost_equal(base, position=1e-5, rotation=1e-5)
    assert robot.line(list(here.shifted(x=0.05))) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    moved = Pose.of(robot.get_tcp_pose())
    # The object's x axis is the base's y axis.
    assert moved.almost_equal(base.shifted(y=0.05), position=1e-3, rotation=2e-3)
    assert robot.set_wobj_offset([0.0, 0.0, 0.1, 0.0, 0.0, 0.0], True) == TaskState.FINISHED
    assert robot.get_wobj() == pytest.approx(list(frame.shifted(z=0.1)))
    assert robot.set_wobj_offset([], False) == TaskState.FINISHED
    assert robot.get_wobj() == pytest.approx(list(frame))


@for_each(
    "name, offset, payload, inertia",
    [
        ("", [0.0] * 6, [0.0] * 4, []),
        ("x" * 33, [0.0] * 6, [0.0] * 4, []),
        ("工" * 11, [0.0] * 6, [0.0] * 4, []),
        ("tool", [0.0] * 5, [0.0] * 4, []),
        ("tool", [math.nan] * 6, [0.0] * 4, []),
        ("tool", [0.0] * 6, [0.0] * 3, []),
        ("tool", [0.0] * 6, [math.inf] * 4, []),
        ("tool", [0.0] * 6, [0.0] * 4, [0.0] * 5),
    ],
)
def test_a_tool_that_makes_no_sense_changes_nothing(
    strict: Program, name: str, offset: list[float], payload: list[float], inertia: list[float]
) -> None:
    before = strict.get_tcp_offset()
    assert strict.set_tool_data(name, offset, payload, inertia) == OUT_OF_RANGE
    assert strict.get_tcp_offset() == before
    assert strict.get_tcp_pose_coord("tool", "") == []
    assert "no tool 'tool'" in strict.get_last_error()[-1]


def test_names_that_are_not_defined_list_those_that_are() -> None:
    frames = FrameTable()
    with pytest.raises(Rejected, match="there are: default"):
        frames.tool("gripper")
    with pytest.raises(Rejected, match="there are: default"):
        frames.wobj("pallet")


def test_kinematics_of_the_controller(sim: Simulator, robot: Program) -> None:
    q = [0.3, 0.1, 1.4, 0.2, -1.3, 0.5]
    tool, wobj = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0, 0.0, 1.0]
    pose = robot.cal_fkine(q, tool, wobj)
    expected = Pose.of(wobj).inverse() @ Pose.from_matrix(sim.arm.fkine(q)) @ Pose.of(tool)
    assert Pose.of(pose).almost_equal(expected)
    assert robot.cal_ikine(pose, q, tool, wobj) == pytest.approx(q, abs=1e-6)
    # Empty lists mean what is in use, and the joints where the arm is.
    here = Pose.of(robot.cal_fkine(list(sim.joints), [], []))
    assert here.almost_equal(Pose.of(robot.get_tcp_pose()), position=1e-5, rotation=1e-5)
    assert robot.cal_ikine(here, [], [], []) == pytest.approx(list(sim.joints), abs=1e-5)


async def test_the_work_object_of_cal_ikine_is_in_the_world_frame() -> None:
    """That of cal_fkine is in the base frame: at a wall the two differ."""
    q = [0.3, -0.2, 1.4, 0.1, -1.3, 0.2]
    near_q, nothing, wobj = [each + 0.05 for each in q], [0.0] * 6, Pose(0.5, 0.1, 0.4, 0, 0, 0.3)
    with Simulator(mounting="wall", speed=math.inf) as sim:
        async with aioduco.connect(sim.host, sim.port) as robot:
            tip = await robot.kinematics.cal_fkine(q, tool=nothing, wobj=nothing)
            pose = wobj.inverse() @ sim.mounting @ tip
            cal_ikine = partial(robot.kinematics.cal_ikine, q_near=near_q, tool=nothing, wobj=wobj)
            assert await cal_ikine(pose) == pytest.approx(q, abs=1e-5)
            other = await cal_ikine(wobj.inverse() @ tip)
            assert np.abs(np.subtract(other, q)).max() > 0.1


def test_an_unreachable_pose_gives_the_reference_joints_back(robot: Program) -> None:
    q = [0.3, 0.1, 1.4, 0.2, -1.3, 0.5]
    assert robot.cal_ikine([5.0, 0.0, 0.0, 0.0, 0.0, 0.0], q, [], []) == q


def test_kinematics_of_what_makes_no_sense_gives_nothing(strict: Program) -> None:
    assert strict.cal_fkine([0.0] * 5, [], []) == []
    assert strict.get_last_error()[-1].startswith("cal_fkine: joints_position has 5 numbers")
    for wrong in ([0.0] * 3, [math.nan] * 6, [1e300] * 6, [0.5, 0.0, 0.5, 7.0, 0.0, 0.0]):
        assert strict.cal_ikine(wrong, [], [], []) == []
        assert strict.get_last_error()[-1].startswith("cal_ikine: p ")


# -- signals -------------------------------------------------------------------------------------


@pytest.mark.parametrize("num", [0, 17, -1, 32767, -32768])
def test_signals_that_do_not_exist_read_false_and_are_not_set(robot: Program, num: int) -> None:
    assert robot.set_standard_digital_out(num, True, True) == OUT_OF_RANGE
    assert robot.set_tool_digital_out(num, True, True) == OUT_OF_RANGE
    assert not robot.get_standard_digital_out(num)
    assert not robot.get_standard_digital_in(num)
    assert not robot.get_tool_digital_in(num)
    assert robot.getRobotIOStatus().digitalOutputs == [False] * 16


# -- what the robot is ---------------------------------------------------------------------------


def test_the_robot_says_what_it_is(robot: Program) -> None:
    assert robot.get_robot_type() == ["GCR5", "910", "", "SIM00000000"]
    assert "aioduco" in robot.get_robot_version()
    rows = robot.get_origin_DH()
    assert robot.get_calib_DH() == rows
    assert rows[0] == pytest.approx([0.0, -math.pi / 2, 0.122, 0.0])
    assert len(rows) == 6


def test_a_motion_op_without_a_trigger_is_none(robot: Program) -> None:
    assert robot.movej2(READY, 1.0, 1.0, 0.0, True, Op(trig_io_1=3), False) == TaskState.FINISHED


def of_32_bits(numbers: list[float]) -> bool:
    return bool(np.array(numbers, np.float32).tolist() == numbers)


@pytest.mark.parametrize("real", [True, False])
def test_readings_are_of_single_precision_on_request(started: Started, real: bool) -> None:
    sim, robot = started(real_readings=real)
    assert robot.to(0.1, 0.2, 1.3, 0.1, -1.4, 0.3) == 4
    sim.wait_until(lambda: sim.view.standing)
    status = robot.getRobotStatus()
    joints, pose = robot.get_actual_joints_position(), robot.get_tcp_pose()
    readings = [joints, pose, status.jointActualPosition, status.cartActualPosition]
    assert [of_32_bits(each) for each in readings] == [real] * 4
    # it goes on to settle by some micrometres
    assert joints == pytest.approx(tuple(sim.joints), abs=1e-4)


@pytest.mark.slow
def test_a_force_sensor_at_rest_shows_an_offset_and_noise_until_it_is_tared(
    connect: Connect,
) -> None:
    with Simulator(speed=math.inf, real_readings=True, seed=3) as sim:
        robot = connect(sim)
        offset = SensorNoise(3).offset
        untared = forces(sim, robot)
        assert all(map(of_32_bits, untared))
        noise = np.abs(np.array(untared) - offset)[:, :3]
        # A draw of twice what three standard deviations are comes once in a hundred million.
        assert 0.05 < noise.max() < 1.0
        assert np.abs(offset[:3]).max() > 1.0
        robot.bring_up()  # which tares it, by what it shows at that instant
        assert np.abs(np.array(forces(sim, robot)))[:, :3].max() < 2.0


def forces(sim: Simulator, robot: Program) -> list[list[float]]:
    """Fifty different readings of the force sensor."""
    shown: list[list[float]] = []

    def enough() -> bool:
        force = robot.fc_get_ft()
        if force not in shown:
            shown.append(force)
        return len(shown) >= 50

    sim.wait_until(enough, 1e6)
    return shown


def test_the_same_seed_gives_the_same_noise() -> None:
    rows = [[SensorNoise(seed)(np.zeros(6)).tolist() for _ in range(3)] for seed in (1, 1, 2)]
    assert rows[0] == rows[1] != rows[2]
