"""Every arm: it comes up, moves by joints and along a line, and ends where it should."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aioduco._wire.rpc import Op
from aioduco.kinematics import models
from aioduco.models.enums import TaskState
from aioduco.models.pose import Pose
from aioduco.sim.simulator import READY, Simulator

from .conftest import a_program


@pytest.mark.parametrize("model", models())
def test_each_arm_moves_by_joints_and_along_a_line(model: str) -> None:
    with Simulator(model, speed=math.inf) as sim, a_program(sim) as robot:
        robot.bring_up()
        series, _, name = model.upper().partition("_")
        assert robot.get_robot_type()[:2] == [series, name]
        goal = np.array(READY) + np.array([0.4, 0.1, -0.2, 0.1, 0.3, -0.5])
        assert robot.to(*goal, v=2.0) == TaskState.FINISHED
        sim.wait_until(lambda: not sim.moving)
        assert np.abs(np.array(sim.joints) - goal).max() < 1e-4
        target = Pose.of(robot.get_tcp_pose()).shifted(x=-0.02, y=0.05, z=0.03)
        answer = robot.movel(list(target), 0.25, 2.0, 0.0, [], "", "", True, Op(), False)
        assert answer == TaskState.FINISHED
        sim.wait_until(lambda: not sim.moving)
        there = Pose.of(robot.get_tcp_pose())
        assert there.almost_equal(target, position=2e-4, rotation=2e-4)
        assert robot.get_last_error() == []
