"""The load that is held, and the forces at the tool."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest

from aioduco.models.enums import TaskState

from .conftest import OUT_OF_RANGE

if TYPE_CHECKING:
    from aioduco.sim.simulator import Simulator

    from .conftest import Program

NOTHING = [0.0] * 6


def settle(sim: Simulator) -> None:
    """Let the drives come to rest."""
    end = sim.time + 1.0
    sim.wait_until(lambda: sim.time >= end)


def test_a_load_is_carried_and_its_weight_is_not_felt(sim: Simulator, robot: Program) -> None:
    settle(sim)
    before = robot.get_actual_joints_torque()
    assert robot.set_load_data([3.0, 0.0, 0.02, 0.05]) == TaskState.FINISHED
    settle(sim)
    after = robot.get_actual_joints_torque()
    reach = math.hypot(*robot.get_flange_pose()[:2])
    assert abs(after[1] - before[1]) > 0.5 * 3.0 * 9.81 * reach
    assert robot.get_tcp_force() == pytest.approx(NOTHING, abs=0.05)
    for wrong in ([36.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [1.0], [math.nan] * 4):
        assert robot.set_load_data(wrong) == OUT_OF_RANGE
    assert robot.set_load_data([0.0] * 4) == TaskState.FINISHED
    settle(sim)
    assert robot.get_actual_joints_torque() == pytest.approx(before, abs=0.05)


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
