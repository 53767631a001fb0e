"""Registers and system values (manual 1.3.7)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeVar

from aioduco.sim.handlers.base import Section, mismatch
from aioduco.sim.values import UndefinedValue

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.sim.bank import Bank
    from aioduco.sim.controller import Controller

T = TypeVar("T")

_WORDS = (-0x8000, 0xFFFF)  # a register of 16 bits, written signed or unsigned
_NOT_SET = 1  # any answer but 0 means that a system value was not set


class RegisterHandlers(Section):
    """write_bool_reg to get_system_value_lists.

    Reading a register that does not exist gives False or 0; writing one changes nothing.
    """

    def write_bool_reg(self, num: int, value: bool) -> int:
        """内部 bool 寄存器, 1 to 64."""
        return self._write("write_bool_reg", self._signals.bool_out, num, value)

    def write_word_reg(self, num: int, value: int) -> int:
        """内部 word 寄存器, 1 to 32."""
        fits = _WORDS[0] <= value <= _WORDS[1]
        return self._write("write_word_reg", self._signals.word_out, num, value, fits)

    def write_float_reg(self, num: int, value: float) -> int:
        """内部 float 寄存器, 1 to 32."""
        finite = math.isfinite(value)
        return self._write("write_float_reg", self._signals.float_out, num, value, finite)

    def read_bool_reg(self, num: int) -> bool:
        """内部 bool 寄存器, 1 to 64."""
        return self._signals.bool_out[num]

    def read_word_reg(self, num: int) -> int:
        """内部 word 寄存器, 1 to 32."""
        return self._signals.word_out[num]

    def read_float_reg(self, num: int) -> float:
        """内部 float 寄存器, 1 to 32."""
        return self._signals.float_out[num]

    def get_function_reg_in(self, num: int) -> bool:
        """功能输入寄存器, 1 to 16."""
        return self._signals.function_reg_in[num]

    def get_function_reg_out(self, num: int) -> bool:
        """功能输出寄存器, 1 to 16."""
        return self._signals.function_reg_out[num]

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
        return self._defined(
            "get_system_value_bool", False, lambda: self._cabinet.values.get(name, bool)
        )

    def get_system_value_double(self, name: str) -> float:
        """系统变量."""
        return self._defined(
            "get_system_value_double", 0.0, lambda: self._cabinet.values.get(name, float)
        )

    def get_system_value_str(self, name: str) -> str:
        """系统变量."""
        return self._defined(
            "get_system_value_str", "", lambda: self._cabinet.values.get(name, str)
        )

    def get_system_value_list(self, name: str) -> list[float]:
        """系统变量."""
        return self._defined(
            "get_system_value_list", [], lambda: self._cabinet.values.numbers(name)
        )

    def get_system_value_lists(self, name: str) -> list[list[float]]:
        """A list of poses; on the wire, in manual 4.3."""
        return self._defined("get_system_value_lists", [], lambda: self._cabinet.values.lists(name))

    def _set_value(self, function: str, name: str, value: bool | float | str | list[float]) -> int:
        with self._runtime.command() as controller:
            try:
                self._cabinet.values.set(name, value)
            except (UndefinedValue, ValueError) as exc:
                controller.note_error(f"{function}: {exc}")
                return _NOT_SET
        return 0

    def _write(self, name: str, bank: Bank[T], num: int, value: T, fits: bool = True) -> int:
        def command(controller: Controller) -> int:
            if num not in bank:
                raise mismatch(f"there is no register {num}; there are 1 to {len(bank)}")
            if not fits:
                raise mismatch(f"{value} does not fit into the register")
            bank[num] = value
            return controller.finish(name)

        return self._task(name, True, command)

    def _defined(self, function: str, nothing: T, read: Callable[[], T]) -> T:
        try:
            return read()
        except UndefinedValue as exc:
            return self._senseless(function, exc, nothing)
