"""Inputs, outputs, registers and system values (manual 1.3.7)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeVar

from aioduco._wire.rpc import IOStatus
from aioduco.models.enums import OutputMode
from aioduco.sim.cabinet.signals import LEVEL, Bank, Pulses
from aioduco.sim.cabinet.values import SystemValues, UndefinedValue
from aioduco.sim.handlers.arguments import choice, number
from aioduco.sim.handlers.base import HandlerSection, task
from aioduco.sim.refusal import mismatch

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.sim.controller.state_machine import Controller


T = TypeVar("T")
_WORDS = (-0x8000, 0xFFFF)  # a register of 16 bits, written signed or unsigned
_NOT_SET = 1  # any answer but 0 means that a system value was not set


class SignalHandlers(HandlerSection):
    """Signals of the cabinet and the tool, registers, system values.

    Reading a signal or register that does not exist returns False or 0 (manual 1.3.7); setting one
    changes nothing.
    """

    @task()
    def set_standard_digital_out(self, _: Controller, num: int, value: bool) -> None:
        """通用 IO 输出."""
        _bank(self._signals.standard_out, num)[num] = value

    @task()
    def set_tool_digital_out(self, _: Controller, num: int, value: bool) -> None:
        """末端 IO 输出."""
        _bank(self._signals.tool_out, num)[num] = value

    def get_standard_digital_out(self, num: int) -> bool:
        """通用 IO 输出."""
        return self._signals.standard_out.level(num, self._runtime.snapshot.time)

    def get_standard_digital_in(self, num: int) -> bool:
        """通用 IO 输入."""
        return self._signals.standard_in.read(num)

    def get_tool_digital_out(self, num: int) -> bool:
        """末端 IO 输出."""
        return self._signals.tool_out.read(num)

    def get_tool_digital_in(self, num: int) -> bool:
        """末端 IO 输入."""
        return self._signals.tool_in.read(num)

    def get_function_digital_in(self, num: int) -> bool:
        """功能 IO 输入."""
        return self._signals.function_in.read(num)

    def get_function_digital_out(self, num: int) -> bool:
        """功能 IO 输出."""
        return self._signals.function_out.read(num)

    def get_config_digital_in(self, num: int) -> bool:
        """Configurable input; on the wire, not in the manual."""
        return self._signals.config_in.read(num)

    def getRobotIOStatus(self) -> IOStatus:  # noqa: N802 - the name on the wire
        """All signals and registers."""
        signals = self._signals
        return IOStatus(
            analogCurrentOutputs=signals.current_out.all(),
            analogVoltageOutputs=signals.voltage_out.all(),
            analogCurrentInputs=signals.current_in.all(),
            analogVoltageInputs=signals.voltage_in.all(),
            digitalInputs=signals.standard_in.all(),
            digitalOutputs=signals.standard_out.levels(self._runtime.snapshot.time),
            toolIOIn=signals.tool_in.all(),
            toolIOOut=signals.tool_out.all(),
            toolButton=signals.tool_buttons.all(),
            funRegisterInputs=signals.function_reg_in.all(),
            funRegisterOutputs=signals.function_reg_out.all(),
            boolRegisterInputs=signals.bool_in.all(),
            boolRegisterOutputs=signals.bool_out.all(),
            wordRegisterInputs=[signed16(word) for word in signals.word_in.all()],
            wordRegisterOutputs=[signed16(word) for word in signals.word_out.all()],
            floatRegisterInputs=signals.float_in.all(),
            floatRegisterOutputs=signals.float_out.all(),
        )

    @task()
    def set_digital_output_mode(
        self,
        _: Controller,
        num: int,
        type: int,  # noqa: A002 - the name on the wire
        freq: int,
        duty_cycle: int,
    ) -> None:
        """Make a general output a level (0) or pulses (1)."""
        outputs = _bank(self._signals.standard_out, num)
        choice("type", type, tuple(OutputMode), "0 or 1")
        pulses = LEVEL
        if type == OutputMode.PULSES:
            number("freq", freq, 1, 100, "Hz")
            number("duty_cycle", duty_cycle, 1, 100, "%")
            pulses = Pulses(freq, duty_cycle)
        outputs.choose(num, pulses)

    # -- analog --------------------------------------------------------------------------------

    def get_standard_analog_voltage_in(self, num: int) -> float:
        """控制柜上的模拟电压输入 [V]."""
        return self._signals.voltage_in.read(num)

    def get_standard_analog_current_in(self, num: int) -> float:
        """控制柜上的模拟电流输入 [mA]."""
        return self._signals.current_in.read(num)

    def get_tool_analog_voltage_in(self, num: int) -> float:
        """机械臂末端的模拟电压输入 [V]."""
        return self._signals.tool_voltage_in.read(num)

    @task()
    def set_standard_analog_voltage_out(self, _: Controller, num: int, value: float) -> None:
        """控制柜上的模拟电压输出, 0 to 10 V."""
        outputs = _bank(self._signals.voltage_out, num)
        number("value", value, 0.0, 10.0, "V")
        outputs[num] = value

    @task()
    def set_standard_analog_current_out(self, _: Controller, num: int, value: float) -> None:
        """控制柜上的模拟电流输出, 4 to 20 mA."""
        outputs = _bank(self._signals.current_out, num)
        number("value", value, 4.0, 20.0, "mA")
        outputs[num] = value

    @task()
    def set_analog_output_mode(self, _: Controller, num: int, mode: int) -> None:
        """Set an analog output to voltage (0) or current (1); on the wire, not in the manual."""
        outputs = _bank(self._signals.analog_mode, num)
        number("mode", mode, 0, 1, "in whole numbers")
        outputs[num] = mode

    @task()
    def write_bool_reg(self, _: Controller, num: int, value: bool) -> None:
        """内部 bool 寄存器, 1 to 64."""
        _bank(self._signals.bool_out, num, "register")[num] = value

    @task()
    def write_word_reg(self, _: Controller, num: int, value: int) -> None:
        """内部 word 寄存器, 1 to 32."""
        registers = _bank(self._signals.word_out, num, "register")
        _check_fits(value, _WORDS[0] <= value <= _WORDS[1])
        registers[num] = value

    @task()
    def write_float_reg(self, _: Controller, num: int, value: float) -> None:
        """内部 float 寄存器, 1 to 32."""
        registers = _bank(self._signals.float_out, num, "register")
        _check_fits(value, math.isfinite(value))
        registers[num] = value

    def read_bool_reg(self, num: int) -> bool:
        """内部 bool 寄存器, 1 to 64."""
        return self._signals.bool_out.read(num)

    def read_word_reg(self, num: int) -> int:
        """内部 word 寄存器, 1 to 32."""
        return self._signals.word_out.read(num)

    def read_float_reg(self, num: int) -> float:
        """内部 float 寄存器, 1 to 32."""
        return self._signals.float_out.read(num)

    def get_function_reg_in(self, num: int) -> bool:
        """功能输入寄存器, 1 to 16."""
        return self._signals.function_reg_in.read(num)

    def get_function_reg_out(self, num: int) -> bool:
        """功能输出寄存器, 1 to 16."""
        return self._signals.function_reg_out.read(num)

    # -- system values -------------------------------------------------------------------------

    def set_system_value_bool(self, name: str, value: bool) -> int:
        """系统变量; 0 if it was set."""
        return self._set_value("set_system_value_bool", name, value)

    def set_system_value_double(self, name: str, value: float) -> int:
        """系统变量; 0 if it was set."""
        return self._set_value("set_system_value_double", name, value)

    def set_system_value_str(self, name: str, value: str) -> int:
        """系统变量; 0 if it was set."""
        return self._set_value("set_system_value_str", name, value)

    def set_system_value_list(self, name: str, value: Sequence[float]) -> int:
        """系统变量; 0 if it was set."""
        return self._set_value("set_system_value_list", name, list(value))

    def get_system_value_bool(self, name: str) -> bool:
        """系统变量."""
        return self._value("get_system_value_bool", False, lambda values: values.get(name, bool))

    def get_system_value_double(self, name: str) -> float:
        """系统变量."""
        return self._value("get_system_value_double", 0.0, lambda values: values.get(name, float))

    def get_system_value_str(self, name: str) -> str:
        """系统变量."""
        return self._value("get_system_value_str", "", lambda values: values.get(name, str))

    def get_system_value_list(self, name: str) -> list[float]:
        """系统变量."""
        return self._value("get_system_value_list", [], lambda values: values.numbers(name))

    def get_system_value_lists(self, name: str) -> list[list[float]]:
        """A list of poses; on the wire, in manual 4.3."""
        return self._value("get_system_value_lists", [], lambda values: values.lists(name))

    def _set_value(self, function: str, name: str, value: bool | float | str | list[float]) -> int:
        with self._runtime.command() as controller:
            try:
                self._cabinet.values.set(name, value)
            except (UndefinedValue, ValueError) as exc:
                controller.note_error(f"{function}: {exc}")
                return _NOT_SET
        return 0

    def _value(self, function: str, nothing: T, read: Callable[[SystemValues], T]) -> T:
        try:
            return read(self._cabinet.values)
        except UndefinedValue as exc:
            return self._invalid_arguments(function, exc, nothing)


B = TypeVar("B", bound="Bank[Any]")


def _bank(bank: B, num: int, kind: str = "output") -> B:
    """Check that a bank has an output or a register of a number."""
    if num not in bank:
        raise mismatch(f"there is no {kind} {num}; there are 1 to {len(bank)}")
    return bank


def _check_fits(value: float, fits: bool) -> None:
    if not fits:
        raise mismatch(f"{value} does not fit into the register")


def signed16(word: int) -> int:
    """Convert a register of 16 bits to the wire's i16."""
    return (word + 0x8000) % 0x10000 - 0x8000
