"""The arm in MuJoCo: it follows its set-points, obeys mechanics, and stands when braked."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest

from aioduco.kinematics import Arm, arm
from aioduco.kinematics.bodies import ROTOR, bodies
from aioduco.models.pose import Pose
from aioduco.models.rotation import Array
from aioduco.sim.physics.world import World
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.planner.segments import joint_move

from .calibration.made import hidden_geometry

mujoco: Any = importlib.import_module("mujoco")  # compiled, without types
HOME = np.radians([0, 0, 90, 0, -90, 0])
FIVE = arm("gcr5_910")
GRAVITY = 9.81


def follow(world: World, mover: Mover) -> tuple[Array, Array]:
    """Run to rest. Set-points and joints [rad]. Shape (n, 6) each."""
    wanted, reached = [], []
    while mover.moving:
        setpoint = mover.tick().setpoint
        world.step(setpoint)
        wanted.append(setpoint.q)
        reached.append(world.q)
    return np.array(wanted), np.array(reached)


def stand(world: World, cycles: int = 400) -> None:
    setpoint = JointSetPoint.at_rest(world.q)
    for _ in range(cycles):
        world.step(setpoint)


def energy(model_arm: Arm, q: Array, qd: Array) -> tuple[float, float]:
    """Kinetic and potential energy from the links' masses [J], without MuJoCo."""
    frame = np.eye(4)
    omega, velocity = np.zeros(3), np.zeros(3)
    kinetic, potential = 0.5 * ROTOR * float(np.array(model_arm.effort) @ qd**2), 0.0
    for i, body in enumerate(bodies(model_arm)):
        before = frame[:3, 3]
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = body.rotation, body.position
        if i:
            c, s = np.cos(q[i - 1]), np.sin(q[i - 1])
            turn = np.eye(4)
            turn[:2, :2] = [[c, -s], [s, c]]
            step = step @ turn
        frame = frame @ step
        velocity = velocity + np.cross(omega, frame[:3, 3] - before)
        if i:
            omega = omega + frame[:3, 2] * qd[i - 1]
        arm_of_mass = frame[:3, :3] @ body.centre
        of_mass = velocity + np.cross(omega, arm_of_mass)
        spin = frame[:3, :3].T @ omega
        kinetic += 0.5 * body.mass * float(of_mass @ of_mass)
        kinetic += 0.5 * float(spin @ body.inertia @ spin)
        potential += body.mass * GRAVITY * float(frame[2, 3] + arm_of_mass[2])
    return kinetic, potential


def test_joints_follow_at_full_speed_and_acceleration(any_arm: Arm) -> None:
    world, mover = World(any_arm, q=HOME), Mover(any_arm, HOME)
    v, a = max(any_arm.velocity), max(any_arm.acceleration)
    there = HOME + np.array([1.5, 0.3, -0.4, 1.0, 2.0, 3.0])
    back = HOME + np.array([-1.5, -0.4, 0.2, 0.5, -1.0, 0.0])
    mover.append(1, lambda q: joint_move(any_arm, q, there, v, a, 0.1))
    mover.append(2, lambda q: joint_move(any_arm, q, back, v, a))
    wanted, reached = follow(world, mover)
    assert np.abs(reached - wanted).max() < 2e-3
    assert np.abs(reached[-1] - wanted[-1]).max() < 1e-4
    assert world.data.time == pytest.approx(0.001 * len(wanted))


@pytest.mark.slow
def test_work_of_the_drives_is_the_gain_of_energy(any_arm: Arm) -> None:
    world, mover = World(any_arm, q=HOME), Mover(any_arm, HOME)
    goal = HOME + np.array([1.0, -0.5, 0.6, 0.5, 1.0, 1.0])
    mover.append(1, lambda q: joint_move(any_arm, q, goal, 1.5, 5.0))
    stand(world)
    work, began = 0.0, sum(energy(any_arm, world.q, world.qd))
    most = 0.0
    while mover.moving:
        for _ in range(10):
            before = world.qd
            world.step(mover.tick().setpoint)
            # Torques are those of the step that led here.
            work += float(world.reading().torque @ (0.5e-3 * (world.qd + before)))
        kinetic, potential = energy(any_arm, world.q, world.qd)
        most = max(most, kinetic)
        assert work == pytest.approx(kinetic + potential - began, abs=0.02 * most + 0.05)
    assert most > 1.0


def test_torques_at_rest_carry_the_weight(any_arm: Arm) -> None:
    q = np.array([0.3, 0.9, 0.7, -0.4, 1.0, 0.2])
    world = World(any_arm, q=q)
    stand(world)
    step = 1e-6
    carried = [
        (energy(any_arm, q + step * axis, np.zeros(6))[1]
        - energy(any_arm, q - step * axis, np.zeros(6))[1]) / (2 * step)
        for axis in np.eye(6)
    ]  # fmt: skip
    np.testing.assert_allclose(world.reading().torque, carried, atol=1e-3)


def test_accelerations_of_the_arms_are_what_their_torques_allow(any_arm: Arm) -> None:
    world = World(any_arm)
    effort = np.array(any_arm.effort)
    for q in np.random.default_rng(4).uniform(-np.pi, np.pi, (200, 6)):
        world.data.qpos[:] = q
        mujoco.mj_forward(world.model, world.data)
        own = np.empty(6)
        for joint, axis in enumerate(np.eye(6)):
            product = np.empty(6)
            mujoco.mj_mulM(world.model, world.data, product, axis)
            own[joint] = product[joint]
        room = (effort - np.abs(world.data.qfrc_bias)) / own
        assert (np.array(any_arm.acceleration) <= 0.75 * room).all()


@pytest.mark.parametrize("model", [FIVE, hidden_geometry(np.random.default_rng(1)).arm])
def test_the_flange_is_where_the_kinematics_put_it(model: Arm) -> None:
    world = World(model, q=HOME, mounting=Pose(0.1, 0.2, 1.0, 0.4, -0.7, 2.0))
    mover = Mover(model, HOME)
    mover.append(1, lambda q: joint_move(model, q, HOME + 0.3, 1.0, 2.0))
    for _ in range(200):
        world.step(mover.tick().setpoint)
        np.testing.assert_allclose(world.flange(), model.fkine(world.q), atol=1e-9)


def test_brakes_hold_the_arm_without_power(any_arm: Arm) -> None:
    q = np.array([0.3, 0.9, 0.7, -0.4, 1.0, 0.2])
    world = World(any_arm, q=q)
    world.brake(True)
    elsewhere = JointSetPoint.at_rest(HOME)
    for _ in range(1500):
        world.step(elsewhere)
    assert np.abs(world.q - q).max() < 1e-6
    np.testing.assert_array_equal(world.reading().torque, np.zeros(6))
    world.brake(False)
    stand(world)
    assert np.abs(world.q - q).max() < 1e-5


def test_brakes_stop_a_moving_arm() -> None:
    world, mover = World(FIVE, q=HOME), Mover(FIVE, HOME)
    mover.append(1, lambda q: joint_move(FIVE, q, HOME + 1.0, 2.0, 10.0))
    while np.abs(world.qd).max() < 1.9:
        world.step(mover.tick().setpoint)
    at = world.q
    world.brake(True)
    standing = 0
    while np.abs(world.qd).max() > 1e-4:
        world.step(mover.setpoint)
        standing += 1
        assert standing < 500
    # 2 rad/s against half of the torques.
    assert 0.001 < np.abs(world.q - at).max() < 0.2
    stood = world.q
    for _ in range(1000):
        world.step(mover.setpoint)
    np.testing.assert_allclose(world.q, stood, atol=1e-6)


def test_reset_stands_elsewhere_at_once() -> None:
    world = World(FIVE, q=HOME)
    world.push([5.0] * 6)
    stand(world, 10)
    world.reset(np.zeros(6))
    assert world.data.time == 0.0
    np.testing.assert_array_equal(world.q, np.zeros(6))
    np.testing.assert_array_equal(world.qd, np.zeros(6))


def test_what_is_drawn_differs_only_in_what_is_seen(any_arm: Arm) -> None:
    """Looks instead of the bodies that collide: they touch nothing, and all is where it was."""
    world = World(any_arm, scene="<mujoco><worldbody><geom size='.1'/></worldbody></mujoco>")
    drawn = world.drawn()
    for size in ("nq", "nv", "nbody", "nsite", "nu"):
        assert getattr(drawn, size) == getattr(world.model, size)
    np.testing.assert_array_equal(drawn.body_mass, world.model.body_mass)
    touching = drawn.geom_contype | drawn.geom_conaffinity
    assert np.count_nonzero(touching) == world.model.ngeom
    for geom in range(drawn.ngeom):
        of_arm = drawn.body(drawn.geom_bodyid[geom]).name.startswith(("base", "link", "flange"))
        hidden = drawn.geom_group[geom] > 2  # MuJoCo draws the groups 0 to 2
        assert hidden == bool(of_arm and touching[geom])
    assert not (world.model.geom_type == mujoco.mjtGeom.mjGEOM_MESH).any()
