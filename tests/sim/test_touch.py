"""Contacts of the arm with itself and the floor: it is blocked."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pytest

from aioduco.devices.grippers import gripper_model
from aioduco.kinematics import Arm, arm
from aioduco.models.rotation import Array
from aioduco.sim.physics.world import World
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.planner.segments import joint_move
from aioduco.sim.scene import Box, Table, mjcf_of
from aioduco.sim.simulator import READY

mujoco: Any = importlib.import_module("mujoco")  # compiled, without types
HOME = np.array(READY)


def touching(world: World, q: Array) -> list[tuple[str, str]]:
    world.data.qpos[:] = q
    mujoco.mj_fwdPosition(world.model, world.data)
    names = [world.model.geom(i).name for i in range(world.model.ngeom)]
    return [(names[contact.geom1], names[contact.geom2]) for contact in world.data.contact]


def test_nothing_touches_in_ordinary_poses(any_arm: Arm) -> None:
    """All around the base, at three heights and reaches, the flange down and forward."""
    world, near = World(any_arm), HOME
    assert touching(world, HOME) == []
    assert touching(world, np.zeros(6)) == []
    down = any_arm.fkine(HOME)[:3, :3]
    for turn in np.linspace(-3.0, 3.0, 5):
        for far in (0.45, 0.6, 0.8):
            for high in (0.2, 0.4, 0.6):
                for tilt in (0.0, 0.5 * np.pi):
                    pose = np.eye(4)
                    c, s = np.cos(tilt), np.sin(tilt)
                    pose[:3, :3] = down @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
                    pose[:3, 3] = [far * any_arm.reach, 0.0, high * any_arm.reach]
                    near = any_arm.ikine(pose, HOME)
                    near[0] += turn
                    assert touching(world, near) == [], (far, high, tilt)


STRETCHED = np.array([0.1, 0.2, 0.0, 2.2, -0.9, -0.4])
WAYS = {
    "itself": (STRETCHED, STRETCHED + 2.9 * np.eye(6)[2]),
    "the floor": (HOME, HOME + 1.5 * np.eye(6)[1]),
}


@pytest.mark.slow
@pytest.mark.parametrize("into", WAYS)
def test_an_arm_that_is_blocked_pushes_and_does_not_fly_apart(any_arm: Arm, into: str) -> None:
    start, goal = WAYS[into]
    world = World(any_arm)
    assert touching(world, start) == []
    world.reset(start)
    mover = Mover(any_arm, start)
    v = 0.5 * min(any_arm.velocity[1:3])
    mover.append(1, lambda q: joint_move(any_arm, q, goal, v, 5.0))
    fastest, touched = 0.0, 0
    setpoint = mover.setpoint
    for _ in range(4000):
        # What a controller does about it comes on top; here it goes on pushing.
        setpoint = mover.tick().setpoint
        world.step(setpoint)
        fastest = max(fastest, float(np.abs(world.qd).max()))
        touched += world.data.ncon > 0
    assert touched > 100
    assert np.abs(world.q - goal).max() > 0.05
    assert fastest < 3.0 * v
    assert np.abs(world.qd).max() < 0.05
    assert (np.abs(world.reading().torque) <= np.array(any_arm.effort) * (1 + 1e-9)).all()
    world.brake(True)
    for _ in range(500):
        world.step(JointSetPoint.at_rest(world.q))
    assert np.abs(world.qd).max() < 0.05


def test_contacts_are_those_of_the_arm_and_of_what_it_holds() -> None:
    """A part stands on a table between the fingers, and another one beside it."""
    gripper, five = gripper_model("parallel"), arm("gcr5_910")
    tip = five.fkine(HOME) @ np.array([0.0, 0.0, gripper.length, 1.0])
    x, y, z = (float(each) for each in tip[:3])
    scene = mjcf_of(
        [
            Table(at=(x, y, z - 0.02), size=(0.4, 0.4), name="table"),
            Box(at=(x, y, z), size=(0.03, 0.03, 0.04), mass=0.1, name="part"),
            Box(at=(x + 0.15, y, z), size=(0.03, 0.03, 0.04), mass=0.1, name="other"),
        ]
    )
    world = World(five, q=HOME, scene=scene, gripper=gripper)
    hand, still = world.hand, JointSetPoint.at_rest(HOME)
    assert hand is not None
    for _ in range(100):
        world.step(still)
    assert world.data.ncon > 0
    assert world.touched() == ""
    hand.command((0.0,), 0.1, 40.0)
    for _ in range(2000):
        world.step(still)
    assert hand.reading.caught == 1
    assert world.touched() == "part touches table, the tool grips part"
