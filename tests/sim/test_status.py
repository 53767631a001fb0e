"""Both status structs field by field: each is live, and agrees with the functions that read it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, fields
from typing import Any, TypeAlias

import numpy as np
import pytest
from for_each import for_each

from aioduco._wire.rpc import IOStatus, Op, RobotStatus
from aioduco.models.enums import RobotState
from aioduco.sim.physics.drives import AMBIENT, Temperatures
from aioduco.sim.simulator import READY, Simulator

from .conftest import Connect, Program, advance_until, let_pass, standing_time

TOOL = [0.02, 0.0, 0.15, 0.0, 0.3, 0.0]


# -- the arm -------------------------------------------------------------------------------------


def test_each_field_of_the_robots_status_is_live(cell: Simulator, program: Program) -> None:
    program.set_tool_data("gripper", TOOL, [0.0] * 4, [])
    seen = [program.getRobotStatus()]
    with standing_time(cell):
        program.movej2([1.0, 0.3, 1.2, 0.3, -1.2, 0.3], 0.5, 0.5, 0.0, False, Op(), False)
        advance_until(cell, lambda: cell.joints[0] > 0.1)
        seen.append(program.getRobotStatus())
        cell.collide(4)
        seen.append(program.getRobotStatus())
    cell.wait_until(lambda: not cell.moving)
    cell.emergency_stop()
    seen.append(program.getRobotStatus())
    cell.release_emergency_stop()
    for field in fields(RobotStatus):
        values = [getattr(status, field.name) for status in seen]
        assert any(value != values[0] for value in values), field.name
        if isinstance(values[0], list):
            assert {len(value) for value in values} == {6}
            # Each of the six numbers, not one of them.
            assert all(len(set(column)) > 1 for column in zip(*values, strict=True)), field.name
    assert [(s.collision, s.collisionAxis) for s in seen[1:3]] == [(False, 0), (True, 4)]
    assert [s.emcStopSignal for s in seen] == [False, False, False, True]
    assert [s.robotError for s in seen] == [0, 0, 1, 1]
    assert [s.robotState for s in seen] == [RobotState.ENABLE] * 3 + [RobotState.POWER_OFF]
    assert [s.slaveReady for s in seen] == [[True] * 6] * 3 + [[False] * 6]


#: field of the status, the function that reads the same
READERS = [
    ("jointExpectPosition", "get_target_joints_position"),
    ("jointExpectVelocity", "get_target_joints_speed"),
    ("jointExpectAccelera", "get_target_joints_acceleration"),
    ("jointActualPosition", "get_actual_joints_position"),
    ("jointActualVelocity", "get_actual_joints_speed"),
    ("jointActualAccelera", "get_actual_joints_acceleration"),
    ("cartActualPosition", "get_tcp_pose"),
    ("cartActualVelocity", "get_tcp_speed"),
    ("cartActualAccelera", "get_tcp_acceleration"),
]


def test_the_status_agrees_with_the_functions(cell: Simulator, program: Program) -> None:
    program.movej2([0.5, *READY[1:]], 1.0, 2.0, 0.0, True, Op(), False)
    let_pass(cell, 0.5)  # nothing is left to do then, and all reads are of one time
    status = program.getRobotStatus()
    for field, function in READERS:
        assert getattr(status, field) == pytest.approx(getattr(program, function)(), abs=1e-9)
    assert status.robotState == program.get_robot_state()[0]
    share = np.array(program.get_actual_joints_torque()) / cell.arm.effort
    assert status.jointActualCurrent == pytest.approx((1000.0 * share).tolist(), abs=1e-6)


def test_lists_may_be_empty_just_after_connecting(cell: Simulator, program: Program) -> None:
    cell.cabinet.empty_statuses = 2
    seen = [program.getRobotStatus() for _ in range(3)]
    assert [len(status.jointActualPosition) for status in seen] == [0, 0, 6]
    assert [status.robotState for status in seen] == [RobotState.ENABLE] * 3


# -- temperatures --------------------------------------------------------------------------------


def test_temperatures_follow_the_load_slowly() -> None:
    effort = [100.0, 100.0, 50.0, 10.0, 10.0, 10.0]
    warmth = Temperatures(effort)
    torque = np.array([100.0, 50.0, 0.0, 0.0, 0.0, -10.0])
    warmth.tick(600.0, torque, powered=True)
    rise = 1.0 - math.exp(-1.0)
    expected = [40.0 * rise, 10.0 * rise, 0.0, 0.0, 0.0, 40.0 * rise]
    assert warmth.joints - AMBIENT == pytest.approx(expected)
    assert warmth.boards[0] - AMBIENT == pytest.approx(25.0, abs=0.5)
    assert warmth.boards[2] - AMBIENT == pytest.approx(5.0, abs=0.1)
    # Steps make no difference, and it cools down as it warmed up.
    steps = Temperatures(effort)
    for _ in range(600):
        steps.tick(1.0, torque, powered=True)
    assert steps.joints == pytest.approx(warmth.joints)
    warmth.tick(6000.0, np.zeros(6), powered=False)
    assert warmth.joints == pytest.approx([AMBIENT] * 6, abs=0.01)
    assert warmth.boards == pytest.approx([AMBIENT] * 6, abs=0.01)


@pytest.mark.slow
def test_a_loaded_arm_becomes_warm(cell: Simulator, program: Program) -> None:
    before = program.getRobotStatus()
    program.movej2([0.0, 1.2, 1.0, 0.0, -1.5, 0.0], 1.0, 2.0, 0.0, True, Op(), False)
    let_pass(cell, 0.1)
    now = program.getRobotStatus()
    # Joint 2 carries the arm that is stretched out; joint 6 carries nothing.
    warmer = np.array(now.jointTemperature) - before.jointTemperature
    assert warmer[1] > 0.0
    assert warmer[1] > 10.0 * abs(warmer[5])
    assert all(board > AMBIENT for board in now.driverTemperature)
    program.movej2(list(READY), 1.0, 2.0, 0.0, True, Op(), False)


# -- signals and registers -----------------------------------------------------------------------

Act: TypeAlias = Callable[[Simulator, Program, int, Any], object]


def put(name: str) -> Act:
    """The world sets a signal, by a method of the simulator."""
    return lambda sim, _, num, value: getattr(sim, name)(num, value)


def bank(name: str) -> Act:
    """The world sets a signal."""
    return lambda sim, _, num, value: getattr(sim.signals, name).__setitem__(num, value)


def call(name: str, *rest: bool) -> Act:
    """The program sets a signal, by a function that takes its number and the value."""
    return lambda _, program, num, value: getattr(program, name)(num, value, *rest)


SET_OUTPUT = call("set_standard_digital_out", True)
#: field, how many signals it has, how one of them comes to be, its number, its value; the function
#: that reads the same, if there is one
SIGNALS: list[tuple[str, int, Act, int, Any, str]] = [
    ("analogCurrentOutputs", 4, call("set_standard_analog_current_out", True), 2, 12.0, ""),
    ("analogVoltageOutputs", 4, call("set_standard_analog_voltage_out", True), 3, 7.5, ""),
    ("analogCurrentInputs", 4, bank("current_in"), 4, 20.0, "get_standard_analog_current_in"),
    ("analogVoltageInputs", 4, bank("voltage_in"), 1, 9.5, "get_standard_analog_voltage_in"),
    ("digitalInputs", 16, put("set_digital_input"), 16, True, "get_standard_digital_in"),
    ("digitalOutputs", 16, SET_OUTPUT, 5, True, "get_standard_digital_out"),
    ("toolIOIn", 2, put("set_tool_digital_input"), 2, True, "get_tool_digital_in"),
    ("toolIOOut", 2, call("set_tool_digital_out", True), 1, True, "get_tool_digital_out"),
    ("toolButton", 2, bank("tool_buttons"), 1, True, ""),
    ("funRegisterInputs", 16, bank("function_reg_in"), 16, True, "get_function_reg_in"),
    ("funRegisterOutputs", 16, bank("function_reg_out"), 3, True, "get_function_reg_out"),
    ("boolRegisterInputs", 64, bank("bool_in"), 64, True, ""),
    ("boolRegisterOutputs", 64, call("write_bool_reg"), 63, True, "read_bool_reg"),
    ("wordRegisterInputs", 32, bank("word_in"), 32, 65535, ""),
    ("wordRegisterOutputs", 32, call("write_word_reg"), 31, 65535, "read_word_reg"),
    ("floatRegisterInputs", 32, bank("float_in"), 9, 0.5, ""),
    ("floatRegisterOutputs", 32, call("write_float_reg"), 8, 2.5, "read_float_reg"),
]


@for_each("row", SIGNALS)
def test_each_field_of_the_signals_status_is_live(
    cell: Simulator, connect: Connect, row: tuple[Any, ...]
) -> None:
    field, size, act, num, value, reader = row
    program = connect(cell)
    before = asdict(program.getRobotIOStatus())
    act(cell, program, num, value)
    now = asdict(program.getRobotIOStatus())
    assert len(now[field]) == size
    told = -1 if value == 65535 else value  # words are signed in the status
    assert now[field][num - 1] == told != before[field][num - 1]
    before[field][num - 1] = told
    assert now == before
    if reader:
        assert getattr(program, reader)(num) == value


def test_no_field_of_the_signals_is_forgotten() -> None:
    assert [row[0] for row in SIGNALS] == [field.name for field in fields(IOStatus)]
