"""Analog signals, kinds of outputs, registers and system values (manual 1.3.7)."""

from __future__ import annotations

import math
from typing import Any

import pytest
from for_each import for_each

from aioduco.models.enums import TaskState
from aioduco.sim.cabinet.signals import LEVEL, Outputs, Pulses
from aioduco.sim.cabinet.values import SystemValues, UndefinedValue
from aioduco.sim.simulator import Simulator

from .conftest import OUT_OF_RANGE, Connect, Program

#: writer, reader, highest number, a value, zero
ROWS = [
    ("write_bool_reg", "read_bool_reg", 64, True, False),
    ("write_word_reg", "read_word_reg", 32, 65535, 0),
    ("write_word_reg", "read_word_reg", 32, -32768, 0),
    ("write_float_reg", "read_float_reg", 32, -1.5e30, 0.0),
]
INPUTS = [
    ("get_standard_analog_voltage_in", "voltage_in", 4, 7.5, 0.0),
    ("get_standard_analog_current_in", "current_in", 4, 12.5, 0.0),
    ("get_tool_analog_voltage_in", "tool_voltage_in", 2, 3.5, 0.0),
    ("get_function_reg_in", "function_reg_in", 16, True, False),
    ("get_function_reg_out", "function_reg_out", 16, True, False),
    ("get_standard_digital_in", "standard_in", 16, True, False),
    ("get_tool_digital_in", "tool_in", 2, True, False),
    ("get_config_digital_in", "config_in", 8, True, False),
    ("get_function_digital_in", "function_in", 8, True, False),
    ("get_function_digital_out", "function_out", 8, True, False),
]
VOLTAGE, CURRENT = "set_standard_analog_voltage_out", "set_standard_analog_current_out"


@pytest.fixture
def program(sim: Simulator, connect: Connect) -> Program:
    """A program whose robot has no power: none of this needs any."""
    return connect(sim)


@pytest.mark.parametrize(("write", "read", "highest", "value", "zero"), ROWS)
def test_registers_are_read_back(
    program: Program, write: str, read: str, highest: int, value: Any, zero: Any
) -> None:
    assert getattr(program, write)(highest, value) == TaskState.FINISHED
    assert getattr(program, read)(highest) == value
    for num in (0, highest + 1, -1):
        assert getattr(program, write)(num, value) == OUT_OF_RANGE
        assert getattr(program, read)(num) == zero
    assert getattr(program, read)(1) == zero


@pytest.mark.parametrize(
    ("write", "value"),
    [("write_word_reg", 65536), ("write_word_reg", -32769), ("write_float_reg", math.nan)],
)
def test_what_does_not_fit_into_a_register_is_not_written(
    program: Program, write: str, value: Any
) -> None:
    assert getattr(program, write)(1, value) == OUT_OF_RANGE
    assert (program.read_word_reg(1), program.read_float_reg(1)) == (0, 0.0)


@pytest.mark.parametrize(("read", "bank", "highest", "value", "zero"), INPUTS)
def test_what_the_world_puts_on_the_inputs_is_read(
    sim: Simulator, program: Program, read: str, bank: str, highest: int, value: Any, zero: Any
) -> None:
    getattr(sim.signals, bank)[highest] = value
    assert getattr(program, read)(highest) == value
    assert [getattr(program, read)(num) for num in (1, 0, highest + 1)] == [zero] * 3


@pytest.mark.parametrize(("write", "value", "wrong"), [(VOLTAGE, 10.0, 10.1), (CURRENT, 4.0, 3.9)])
def test_analog_outputs_keep_to_their_range(
    sim: Simulator, program: Program, write: str, value: float, wrong: float
) -> None:
    assert getattr(program, write)(4, value, True) == TaskState.FINISHED
    for num, setting in ((4, wrong), (4, math.nan), (5, value), (0, value)):
        answer = getattr(program, write)(num, setting, True)
        assert answer == OUT_OF_RANGE
    status = program.getRobotIOStatus()
    outputs = status.analogVoltageOutputs if write == VOLTAGE else status.analogCurrentOutputs
    assert outputs == [0.0, 0.0, 0.0, value]
    assert program.set_analog_output_mode(4, 1, True) == TaskState.FINISHED
    assert program.set_analog_output_mode(4, 2, True) == OUT_OF_RANGE
    assert sim.signals.analog_mode[4] == 1


# -- kinds of outputs ----------------------------------------------------------------------------


def test_pulses_begin_when_the_output_is_set() -> None:
    outputs = Outputs(3)
    outputs[1] = True
    outputs.choose(1, Pulses(10, 30))
    assert outputs.levels(0.05) == [True, False, False]  # a level until it is set again
    outputs[1] = True
    cycle = [outputs.level(1, time / 1000) for time in range(100)]
    assert cycle == [time < 30 for time in range(100)]
    assert outputs.level(1, 0.102)
    outputs[1] = False
    assert not outputs.level(1, 0.0)
    assert not outputs.level(4, 0.0)


@for_each("frequency, duty, pulses", [(100, 10, 1), (100, 9, 0), (1, 1, 10)])
def test_pulses_shorter_than_a_millisecond_switch_the_output_off(
    frequency: int, duty: int, pulses: int
) -> None:
    outputs = Outputs(1)
    outputs.choose(1, Pulses(frequency, duty))
    outputs[1] = True
    period = 1000 // frequency
    assert sum(outputs.level(1, time / 1000) for time in range(period)) == pulses


def test_there_is_one_generator_of_pulses() -> None:
    outputs = Outputs(2)
    outputs.choose(1, Pulses(10, 50))
    outputs[1] = True
    outputs.choose(2, Pulses(20, 50))
    outputs[2] = True
    assert outputs.levels(0.03) == [False, False]
    outputs.choose(1, LEVEL)
    outputs[1] = True
    assert outputs.levels(0.03) == [True, False]


WRONG_KINDS = [
    (0, 1, 10, 50),
    (17, 1, 10, 50),
    (1, 2, 10, 50),
    (1, 1, 0, 50),
    (1, 1, 101, 50),
    (1, 1, 10, 0),
    (1, 1, 10, 101),
]


@pytest.mark.parametrize("wrong", WRONG_KINDS)
def test_kinds_of_outputs_keep_to_their_range(
    sim: Simulator, program: Program, wrong: tuple[int, int, int, int]
) -> None:
    assert program.set_digital_output_mode(*wrong) == OUT_OF_RANGE
    assert program.set_digital_output_mode(2, 1, 1, 100) == TaskState.FINISHED
    assert program.set_standard_digital_out(2, True, True) == TaskState.FINISHED
    assert program.get_standard_digital_out(2)
    assert program.set_digital_output_mode(2, 0, 0, 0) == TaskState.FINISHED


# -- system values -------------------------------------------------------------------------------

VALUES: dict[str, Any] = {"bool": True, "double": 2.5, "str": "抓取", "list": [1.0, 2.0]}


#: what an undefined one reads
NOTHING: dict[str, Any] = {"bool": False, "double": 0.0, "str": "", "list": []}


@pytest.mark.parametrize("kind", VALUES)
def test_system_values_keep_their_type(connect: Connect, kind: str) -> None:
    with Simulator(values={**VALUES, "cell.poses": [[1, 2], [3]]}) as sim:
        program = connect(sim)
        new = {"bool": False, "double": -1.0, "str": "", "list": []}
        assert getattr(program, f"get_system_value_{kind}")(kind) == VALUES[kind]
        assert getattr(program, f"set_system_value_{kind}")(kind, new[kind]) == 0
        assert getattr(program, f"get_system_value_{kind}")(kind) == new[kind]
        for other in (name for name in (*VALUES, "nothing") if name != kind):
            assert getattr(program, f"set_system_value_{kind}")(other, new[kind]) != 0
            assert sim.view.errors[-1].startswith(f"set_system_value_{kind}: ")
            assert getattr(program, f"get_system_value_{kind}")(other) == NOTHING[kind]
            assert sim.view.errors[-1].startswith(f"get_system_value_{kind}: ")
        assert program.get_system_value_lists("cell.poses") == [[1.0, 2.0], [3.0]]


def test_system_values_are_finite_and_of_one_type() -> None:
    values = SystemValues({"rows": [[1.0]], "numbers": [1.0], "number": 1})
    mixed: Any = [[1.0], 2.0]
    for wrong in (math.nan, [math.inf], mixed):
        with pytest.raises(ValueError, match=r"finite|both"):
            values.define("wrong", wrong)
    for no_value in (None, {"a": 1.0}, b"text", [None], ["text"], [[None]], [[1.0], b"x"]):
        with pytest.raises(ValueError, match="a system value"):
            values.define("wrong", no_value)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="empty"):
        values.define("", 1.0)
    for refused in (lambda: values.numbers("rows"), lambda: values.set("rows", [2.0])):
        with pytest.raises(UndefinedValue, match="a list of lists, not a list"):
            refused()
    assert values.lists("rows") == [[1.0]]
    with pytest.raises(UndefinedValue, match="a list, not a list of lists"):
        values.lists("numbers")
    assert values.get("number", float) == 1.0
