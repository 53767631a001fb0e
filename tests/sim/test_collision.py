"""Collisions: found in the torques, by level; the arm stands, says so, and can be led away."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from for_each import for_each

import aioduco
from aioduco.errors import SceneError
from aioduco.kinematics import Arm, arm, models
from aioduco.models.enums import RobotState, SafetyState, TaskState
from aioduco.sim.controller.monitoring import LEVELS, SMOOTHING, CollisionDetector
from aioduco.sim.physics.world import World
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.planner.segments import joint_move
from aioduco.sim.scene import Box
from aioduco.sim.simulator import READY, Simulator

from .conftest import Connect, Program, Started

PAGE = Path(__file__).parents[2] / "docs" / "scene.md"
HOME = np.array(READY)
FIVE = arm("gcr5_910")
EFFORT = np.array([100.0, 100.0, 100.0, 50.0, 50.0, 50.0])
#: in the way of the forearm when joint 1 turns from zero to the left
WALL = Box(at=(0.45, 0.5, 0.3), size=(0.4, 0.1, 0.6))
LEFT = (1.2, *READY[1:])


# -- the observer ------------------------------------------------------------------------------


def observed(observer: CollisionDetector, external: list[float], cycles: int) -> list[int]:
    start = 0.0 if observer._time is None else observer._time  # where the last torques ended
    return [
        observer.update(start + 0.001 * i, np.array(external)) for i in range(1, cycles + 1)
    ]  # fmt: skip


@for_each("level", [1, 2, 3, 4, 5])
def test_a_torque_beyond_the_levels_share_is_a_collision(level: int) -> None:
    observer = CollisionDetector(EFFORT)
    assert observer.level == 3
    observer.level = level
    below, above = 0.95 * LEVELS[level], 1.2 * LEVELS[level]
    assert not any(observed(observer, [0, 0, 0, 0, -50.0 * below, 0], 200))
    found = observed(observer, [0, 0, 0, 0, -50.0 * above, 0], 200)
    assert set(found) == {0, 5}
    assert found.index(5) < 4 * SMOOTHING / 0.001


def test_levels_are_more_sensitive_one_after_the_other_as_the_page_says() -> None:
    assert sorted(LEVELS) == [0, 1, 2, 3, 4, 5]
    assert list(LEVELS.values()) == sorted(LEVELS.values(), reverse=True)
    told = re.search(r"\| share \| off \|(.*)\|", PAGE.read_text("utf-8"))
    assert told is not None
    shares = [float(share.strip(" %")) / 100 for share in told[1].split("|")]
    assert shares == list(LEVELS.values())[1:]


def test_level_0_sees_torques_and_no_collision() -> None:
    observer = CollisionDetector(EFFORT)
    observer.level = 0
    assert not any(observed(observer, [1e3] * 6, 100))
    assert observer.torque == pytest.approx([1e3] * 6, rel=1e-3)
    observer.reset()
    assert observer.torque == pytest.approx([0.0] * 6)


def test_a_blow_of_a_cycle_is_smoothed() -> None:
    observer = CollisionDetector(EFFORT)
    observer.level = 5
    assert not any(observed(observer, [0.0] * 6, 10))
    assert observed(observer, [50.0] * 6, 1) == [0]


# -- torques of the simulated arm --------------------------------------------------------------


@pytest.mark.parametrize("model", models())
def test_ordinary_motions_are_no_collision_at_the_most_sensitive_level(model: str) -> None:
    any_arm: Arm = arm(model)
    world, mover = World(any_arm, q=HOME), Mover(any_arm, HOME)
    world.load(0.5 * float(model.partition("_")[0][3:]), (0.0, 0.02, 0.08))
    v, a = max(any_arm.velocity), max(any_arm.acceleration)
    goal = HOME + np.array([1.0, 0.3, -0.4, 0.8, 1.0, 1.5])
    mover.append(1, lambda q: joint_move(any_arm, q, goal, v, a, 0.1))
    mover.append(2, lambda q: joint_move(any_arm, q, HOME, v, a))
    effort = np.array(any_arm.effort)
    most = 0.0
    while mover.moving:
        world.step(mover.tick().setpoint)
        most = max(most, float((np.abs(world.reading().external_torque) / effort).max()))
    assert most < 0.1 * LEVELS[5]
    assert np.abs(world.reading().torque).max() > 1.0


@pytest.mark.parametrize("load", [0.0, 3.0], ids=["bare", "loaded"])
def test_a_push_is_observed_as_the_torques_it_makes(load: float) -> None:
    world = World(FIVE, q=HOME)
    world.load(load, (0.05, 0.0, 0.1))
    push = np.array([20.0, -10.0, 5.0, 0.5, 1.0, -0.5])
    world.push(push.tolist())
    for _ in range(1000):
        world.step(JointSetPoint.at_rest(HOME))
    made = FIVE.jacobian(world.q).T @ push
    np.testing.assert_allclose(world.reading().external_torque, made, atol=5e-3)
    # At rest the target is the weight, and the drives give what is left.
    np.testing.assert_allclose(
        world.reading().target_torque - made, world.reading().torque, atol=5e-3
    )


def test_a_load_that_was_not_told_is_a_torque_from_outside() -> None:
    world = World(FIVE, q=HOME)
    world.carry(2.0)
    for _ in range(1000):
        world.step(JointSetPoint.at_rest(HOME))
    weight = np.array([0.0, 0.0, -2.0 * 9.81, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(
        world.reading().external_torque, FIVE.jacobian(HOME).T @ weight, atol=0.1
    )
    sagged = np.abs(world.q - HOME).max()
    assert 1e-4 < sagged < 0.02
    world.set_modelled_load(2.0)
    for _ in range(1000):
        world.step(JointSetPoint.at_rest(HOME))
    np.testing.assert_allclose(world.reading().external_torque, np.zeros(6), atol=0.01)
    assert np.abs(world.q - HOME).max() < 1e-5


# -- over the wire -----------------------------------------------------------------------------


@pytest.fixture
def cell() -> Iterator[Simulator]:
    with Simulator(speed=math.inf, scene=[WALL]) as sim:
        yield sim


@pytest.mark.slow
async def test_an_arm_that_runs_into_a_box_stands_and_is_led_away(cell: Simulator) -> None:
    async with aioduco.connect(cell.host, cell.port) as robot:
        await robot.recover()
        await robot.motion.movej2(READY, v=1.0, a=2.0)
        with pytest.raises(aioduco.TaskFailed, match=r"Joint \d 检测到碰撞"):
            await robot.motion.movej2(LEFT, v=0.5, a=2.0)
        stood = cell.joints[0]
        assert 0.05 < stood < 1.1
        status = await robot.state.getRobotStatus()
        assert status.collision
        assert status.collision_axis in range(1, 7)
        assert status.state is RobotState.ENABLE
        states = await robot.state.get_robot_state()
        assert states.safety is SafetyState.STOP2
        assert any("检测到碰撞" in error for error in await robot.state.get_last_error())
        # It yields where it stands: what still pushes is less than what was a collision.
        most = LEVELS[3] * np.array(cell.arm.effort)
        assert (np.abs(await robot.state.get_ext_torque()) < most).all()
        with pytest.raises(aioduco.TaskIllegal):
            await robot.motion.movej2(READY, v=0.5, a=2.0)
        await robot.settings.collision_detection_reset()
        assert not (await robot.state.getRobotStatus()).collision
        await robot.recover()
        await robot.motion.movej2(READY, v=0.5, a=2.0)
        assert cell.joints == pytest.approx(READY, abs=1e-3)


@pytest.mark.slow
def test_without_detection_it_pushes_until_the_position_deviates(
    cell: Simulator, connect: Connect
) -> None:
    robot = connect(cell)
    robot.bring_up()
    assert robot.collision_detect(0) == TaskState.FINISHED
    assert robot.to(*LEFT, v=0.5) == TaskState.ERROR
    assert robot.get_robot_state()[:3] == [RobotState.POWER_OFF, 0, SafetyState.STOP0]
    assert "position deviation" in robot.get_last_error()[-1]
    assert robot.collision_detect(3) == TaskState.FINISHED
    assert robot.power_off(True) == TaskState.FINISHED
    robot.bring_up()
    assert robot.to(*READY) == TaskState.FINISHED


@pytest.mark.slow
@pytest.mark.usefixtures("real_cycle")
def test_a_wrong_load_is_an_offset_and_at_a_sensitive_level_a_collision(started: Started) -> None:
    sim, robot = started()
    sim.load(5.0)
    weight = [0.0, 0.0, -5.0 * 9.81, 0.0, 0.0, 0.0]
    offset = sim.arm.jacobian(sim.joints).T @ weight
    # the arm sways at first
    sim.wait_until(lambda: robot.get_ext_torque() == pytest.approx(offset, abs=0.5))
    assert robot.set_load_data([5.0, 0.0, 0.0, 0.0]) == TaskState.FINISHED
    sim.wait_until(lambda: robot.get_ext_torque() == pytest.approx([0.0] * 6, abs=0.1))
    sim.wait_until(
        lambda: (
            robot.get_target_joints_torque()
            == pytest.approx(robot.get_actual_joints_torque(), abs=0.3)
        )
    )
    robot.set_load_data([0.0] * 4)
    robot.collision_detect(5)
    sim.wait_until(lambda: sim.view.collision_axis == 4)
    with pytest.raises(ValueError, match="mass is -1"):
        sim.load(-1.0)


# -- the floor ---------------------------------------------------------------------------------


def below(robot: Program, z: float) -> int:
    """Straight down to a height in the base frame [m]."""
    here = robot.get_tcp_pose()
    return robot.line([*here[:2], z, *here[3:]], block=False)


def test_a_collision_names_the_floor(sim: Simulator, robot: Program) -> None:
    id_ = below(robot, -0.2)
    sim.wait_until(lambda: robot.get_noneblock_taskstate(id_) == TaskState.ERROR, 60.0)
    (text,) = robot.get_last_error()
    assert re.fullmatch(
        r"Joint \d 检测到碰撞 \(simulator: .*the flange touches the floor.*\)", text
    )


@pytest.mark.slow
def test_an_arm_on_a_pedestal_reaches_below_its_base(started: Started) -> None:
    sim, robot = started(pedestal=0.5)
    id_ = below(robot, -0.2)
    sim.wait_until(lambda: robot.get_noneblock_taskstate(id_) == TaskState.FINISHED, 60.0)
    assert robot.get_tcp_pose()[2] == pytest.approx(-0.2, abs=1e-3)
    id_ = below(robot, -0.6)  # and there is a floor, half a metre down
    sim.wait_until(lambda: robot.get_noneblock_taskstate(id_) == TaskState.ERROR, 60.0)
    assert "the floor" in robot.get_last_error()[-1]
    assert robot.get_tcp_pose()[2] == pytest.approx(-0.51, abs=0.005)


def test_a_pedestal_is_for_an_arm_on_the_floor() -> None:
    with pytest.raises(SceneError, match="give the height by mounting"):
        Simulator(mounting="wall", pedestal=0.5)
    for height in (-0.5, 0.01, math.nan):
        with pytest.raises(SceneError, match="pedestal is"):
            Simulator(pedestal=height)
