"""The functions of force control on the wire, with invalid arguments as well."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest
from for_each import for_each

from aioduco.models.enums import TaskState
from aioduco.sim.simulator import Simulator

from .conftest import Program, a_program

FINE, ILLEGAL, WRONG = TaskState.FINISHED, TaskState.ILLEGAL, TaskState.PARAMETER_MISMATCH
NAN, INF = math.nan, math.inf
SIX, FIVE = [0.0] * 6, [0.0] * 5
ON, OFF = [True] * 6, [False] * 6
DAMP = [1000.0] * 3 + [57.0] * 3
CONFIG = {
    "direction": ON,
    "ref_ft": SIX,
    "damp": DAMP,
    "max_vel": [0.05] * 6,
    "number_list": SIX,
    "tool": "",
    "wobj": "",
    "value": 0,
}
GUARD = {"direction": ON, "ref_ft": DAMP, "tool": "", "wobj": "", "type": 0, "force_property": 0}
WAIT = {"middle": SIX, "range": SIX, "absolute": True, "duration": 100, "timeout": 1000}
TARE = {"direction": ON, "ref_ft": SIX}

CALLS: list[tuple[str, dict[str, Any], dict[str, Any], TaskState]] = [
    ("fc_config", CONFIG, {}, FINE),
    ("fc_config", CONFIG, {"max_vel": [-0.05] * 6, "number_list": [-1.0] * 6}, FINE),
    ("fc_config", CONFIG, {"ref_ft": [1000.0, -1000.0] * 3, "value": 1}, FINE),
    ("fc_config", CONFIG, {"direction": OFF, "damp": [0.0] * 6}, FINE),
    ("fc_config", CONFIG, {"tool": "default", "wobj": "default"}, FINE),
    ("fc_config", CONFIG, {"direction": [True] * 5}, WRONG),
    ("fc_config", CONFIG, {"direction": []}, WRONG),
    ("fc_config", CONFIG, {"ref_ft": [1000.1, *FIVE]}, WRONG),
    ("fc_config", CONFIG, {"ref_ft": [NAN, *FIVE]}, WRONG),
    ("fc_config", CONFIG, {"ref_ft": FIVE}, WRONG),
    ("fc_config", CONFIG, {"damp": [0.0, *DAMP[1:]]}, WRONG),
    ("fc_config", CONFIG, {"damp": [-1.0, *DAMP[1:]]}, WRONG),
    ("fc_config", CONFIG, {"damp": [INF, *DAMP[1:]]}, WRONG),
    ("fc_config", CONFIG, {"damp": FIVE}, WRONG),
    ("fc_config", CONFIG, {"max_vel": [5.1, *FIVE]}, WRONG),
    ("fc_config", CONFIG, {"max_vel": [NAN, *FIVE]}, WRONG),
    ("fc_config", CONFIG, {"number_list": [-1001.0, *FIVE]}, WRONG),
    ("fc_config", CONFIG, {"number_list": []}, WRONG),
    ("fc_config", CONFIG, {"tool": "saw"}, ILLEGAL),
    ("fc_config", CONFIG, {"wobj": "moon"}, ILLEGAL),
    ("fc_config", CONFIG, {"value": 2}, WRONG),
    ("fc_guard_act", GUARD, {}, FINE),
    ("fc_guard_act", GUARD, {"force_property": 1, "type": 1}, FINE),
    ("fc_guard_act", GUARD, {"direction": [True] * 7}, WRONG),
    ("fc_guard_act", GUARD, {"ref_ft": [-1.0, *FIVE]}, WRONG),
    ("fc_guard_act", GUARD, {"ref_ft": [NAN, *FIVE]}, WRONG),
    ("fc_guard_act", GUARD, {"ref_ft": FIVE}, WRONG),
    ("fc_guard_act", GUARD, {"tool": "saw"}, ILLEGAL),
    ("fc_guard_act", GUARD, {"wobj": "moon"}, ILLEGAL),
    ("fc_guard_act", GUARD, {"type": -1}, WRONG),
    ("fc_guard_act", GUARD, {"force_property": 2}, WRONG),
    ("fc_guard_deact", {}, {}, FINE),
    ("fc_force_set_value", TARE, {}, FINE),
    ("fc_force_set_value", TARE, {"direction": [True]}, WRONG),
    ("fc_force_set_value", TARE, {"ref_ft": [INF, *FIVE]}, WRONG),
    ("fc_wait_pos", WAIT, {}, FINE),
    ("fc_wait_vel", WAIT, {}, FINE),
    ("fc_wait_ft", WAIT, {}, FINE),
    ("fc_wait_pos", WAIT, {"middle": FIVE}, WRONG),
    ("fc_wait_pos", WAIT, {"middle": [INF, *FIVE]}, WRONG),
    ("fc_wait_vel", WAIT, {"middle": [5.1, *FIVE]}, WRONG),
    ("fc_wait_vel", WAIT, {"middle": [*FIVE, 6.2]}, FINE),
    ("fc_wait_vel", WAIT, {"middle": [*FIVE, 6.3]}, WRONG),
    ("fc_wait_vel", WAIT, {"range": [*FIVE, -1.0]}, FINE),
    ("fc_wait_ft", WAIT, {"middle": [1001.0, *FIVE]}, WRONG),
    ("fc_wait_ft", WAIT, {"range": [NAN, *FIVE]}, WRONG),
    ("fc_wait_ft", WAIT, {"range": []}, WRONG),
    ("fc_wait_ft", WAIT, {"duration": -1}, WRONG),
    ("fc_wait_ft", WAIT, {"timeout": -1}, WRONG),
    ("fc_wait_logic", {"value": [1, 2, 0]}, {}, FINE),
    ("fc_wait_logic", {"value": [1, 2, 3]}, {}, WRONG),
    ("fc_wait_logic", {"value": [0, 0]}, {}, WRONG),
    ("fc_wait_logic", {"value": []}, {}, WRONG),
    ("fc_start", {}, {}, FINE),
    ("fc_start", {}, {}, FINE),
    ("fc_stop", {}, {}, FINE),
    ("fc_stop", {}, {}, FINE),
]


@pytest.fixture(scope="module")
def program(cell: Simulator) -> Iterator[Program]:
    with a_program(cell) as program:
        program.bring_up()
        yield program


@pytest.fixture
def robot(program: Program) -> Iterator[Program]:
    """An enabled arm without force control, whose sensor reads nothing."""
    yield program
    for function, args in (
        ("fc_stop", ()),
        ("fc_guard_deact", ()),
        ("fc_force_set_value", (ON, SIX)),
    ):
        assert program.ended(getattr(program, function)(*args)) == FINE


@for_each("name, usual, change, state", CALLS)
def test_what_a_call_ends_as(
    robot: Program, name: str, usual: dict[str, Any], change: dict[str, Any], state: TaskState
) -> None:
    arguments = {**usual, **change}
    assert robot.ended(robot.connection.call(name, tuple(arguments.values()))) == state


def test_what_was_wrong_changes_nothing(robot: Program) -> None:
    assert robot.ended(robot.fc_wait_logic([0, 0, 1])) == FINE
    for bad in ({"value": 7}, {"damp": [0.0] * 6}):
        arguments = {**CONFIG, **bad}
        robot.connection.call("fc_config", tuple(arguments.values()))
    assert not robot.fc_mode_is_active()
    assert robot.fc_get_ft() == pytest.approx(SIX, abs=1e-3)


def test_a_negative_range_is_its_absolute_value(robot: Program, strict: Program) -> None:
    for program, state in ((robot, FINE), (strict, WRONG)):
        id_ = program.fc_wait_pos(SIX, [-1.0] * 6, False, 0, 60_000)
        assert program.ended(id_) == state
    assert robot.ended(robot.connection.call("fc_config", tuple(CONFIG.values()))) == FINE
    assert robot.ended(robot.fc_start()) == FINE
    assert robot.ended(robot.fc_wait_logic([1, 0, 0])) == FINE
    assert robot.fc_move(True) == FINE  # at once


def test_force_control_needs_an_enabled_arm_and_a_sensor(cell: Simulator, robot: Program) -> None:
    assert robot.fc_move(True) == ILLEGAL  # it is off
    assert robot.disable(True) == FINE
    assert robot.ended(robot.fc_start()) == ILLEGAL
    assert robot.enable(True) == FINE
    cell.cabinet.force_sensor = False
    try:
        assert robot.ended(robot.fc_start()) == TaskState.ERROR
        assert "no force sensor" in robot.get_last_error()[-1]
        assert robot.ended(robot.fc_force_set_value(ON, SIX)) == TaskState.ERROR
        assert robot.fc_get_ft() == robot.get_tcp_force() == robot.get_tcp_force_tool("") == []
    finally:
        cell.cabinet.force_sensor = True
    assert not robot.fc_mode_is_active()


def test_a_reading_is_set(robot: Program) -> None:
    values = [1.0, -2.0, 3.0, 0.1, -0.2, 0.3]
    assert robot.ended(robot.fc_force_set_value([True] * 3 + [False] * 3, values)) == FINE
    assert robot.fc_get_ft() == pytest.approx([1.0, -2.0, 3.0, 0.0, 0.0, 0.0], abs=1e-3)
    assert robot.ended(robot.fc_force_set_value(ON, SIX)) == FINE
    assert robot.fc_get_ft() == pytest.approx(SIX, abs=1e-3)
