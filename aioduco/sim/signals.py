"""Inputs and outputs of the cabinet and of the tool (manual 1.3.7)."""

from __future__ import annotations

from typing import Generic, TypeVar

T = TypeVar("T")


class Bank(Generic[T]):
    """Signals of one kind, numbered from 1 as in the manual.

    One element is read and written at once, so readers need no lock.
    """

    __slots__ = ("_values", "_zero")

    def __init__(self, size: int, zero: T) -> None:
        self._zero = zero
        self._values = [zero] * size

    def __len__(self) -> int:
        return len(self._values)

    def __contains__(self, num: int) -> bool:
        """Whether there is a signal of this number."""
        return 1 <= num <= len(self._values)

    def __getitem__(self, num: int) -> T:
        """One signal; zero for a number that does not exist, as the manual says (1.3.7)."""
        return self._values[num - 1] if num in self else self._zero

    def __setitem__(self, num: int, value: T) -> None:
        if num not in self:
            raise IndexError(f"there is no signal {num}; there are 1 to {len(self._values)}")
        self._values[num - 1] = value

    def all(self) -> list[T]:
        """Every signal, a copy."""
        return self._values.copy()


class Signals:
    """Every signal of a controller.

    The cabinet has 16 general inputs and outputs and 8 function inputs and outputs, the tool 2
    of each and the buttons T and S. Of the 8 configurable inputs the manual says nothing: their
    number is an assumption.
    """

    def __init__(self) -> None:
        self.standard_in = Bank(16, False)
        self.standard_out = Bank(16, False)
        self.function_in = Bank(8, False)
        self.function_out = Bank(8, False)
        self.config_in = Bank(8, False)
        self.tool_in = Bank(2, False)
        self.tool_out = Bank(2, False)
        self.tool_buttons = Bank(2, False)
        self.voltage_in = Bank(4, 0.0)
        self.voltage_out = Bank(4, 0.0)
        self.current_in = Bank(4, 0.0)
        self.current_out = Bank(4, 0.0)
        self.tool_voltage_in = Bank(2, 0.0)
        self.function_reg_in = Bank(16, False)
        self.function_reg_out = Bank(16, False)
        self.bool_in = Bank(64, False)
        self.bool_out = Bank(64, False)
        self.word_in = Bank(32, 0)
        self.word_out = Bank(32, 0)
        self.float_in = Bank(32, 0.0)
        self.float_out = Bank(32, 0.0)
