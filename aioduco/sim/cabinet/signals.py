"""Inputs, outputs and registers of the cabinet and of the tool (manual 1.3.7)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from aioduco.models.rules import is_whole

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


T = TypeVar("T")
_SHORTEST = 1e-3  # shorter pulses switch the output off [s]


class Bank(Generic[T]):
    """Signals of one kind, numbered from 1 as in the manual.

    An element is read or written in one atomic step, so readers need no lock.
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

    def __iter__(self) -> Iterator[T]:
        return iter(self._values.copy())

    def __getitem__(self, num: int) -> T:
        self._require(num)
        return self._values[num - 1]

    def read(self, num: int) -> T:
        """What a client reads: zero for a number that does not exist (manual 1.3.7)."""
        return self._values[num - 1] if num in self else self._zero

    def _require(self, num: int) -> None:
        if not is_whole(num) or num not in self:
            raise IndexError(f"there is no signal {num!r}; there are 1 to {len(self._values)}")

    def __setitem__(self, num: int, value: T) -> None:
        self._require(num)
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"signal {num} would be {value}, but must be a finite number")
        self._values[num - 1] = value

    def all(self) -> list[T]:
        """A copy of all signals."""
        return self._values.copy()


@dataclass(frozen=True, slots=True)
class Pulses:
    """A train of pulses while the output is set.

    Attributes:
        frequency: pulses a second, 1 to 100 [Hz]; 0 for a level.
        duty: part of the period in which the output is high, 1 to 100 [%].
    """

    frequency: int
    duty: int

    def level(self, time: float) -> bool:
        """Whether the output is high at a time [s], while it is set."""
        if not self.frequency:
            return True
        if self.duty < _SHORTEST * 100.0 * self.frequency:
            return False
        # A nanosecond as an allowance for the rounding of a sum of cycles.
        return (time + 1e-9) * self.frequency % 1.0 < self.duty / 100.0


LEVEL = Pulses(0, 100)


class Outputs(Bank[bool]):
    """Outputs that are levels or pulses.

    A new kind takes effect when the output is set next, as the manual says.
    """

    __slots__ = ("_chosen", "_used")

    def __init__(self, size: int) -> None:
        super().__init__(size, False)
        self._chosen = [LEVEL] * size
        self._used = [LEVEL] * size

    def __setitem__(self, num: int, value: bool) -> None:
        super().__setitem__(num, value)
        self._used[num - 1] = self._chosen[num - 1]

    def choose(self, num: int, pulses: Pulses) -> None:
        """Choose the kind of one output; its pulses apply to all, which share one generator."""
        self._chosen[num - 1] = pulses
        if pulses is not LEVEL:
            for kinds in (self._chosen, self._used):
                kinds[:] = [pulses if kind is not LEVEL else LEVEL for kind in kinds]

    def level(self, num: int, time: float) -> bool:
        """Whether an output is high at a time [s]; False for one that does not exist."""
        return self.read(num) and self._used[num - 1].level(time)

    def levels(self, time: float) -> list[bool]:
        """Every output at a time [s]."""
        return [on and kind.level(time) for on, kind in zip(self.all(), self._used, strict=True)]


class Signals:
    """Every signal of a controller.

    The cabinet has 16 general inputs and outputs and 8 function inputs and outputs. The tool has 2
    inputs and outputs and the buttons T and S. The manual says nothing about configurable inputs:
    their number, 8, is an assumption.

    Attributes:
        events: actions of triggers' events, by the event's name (用户自定义事件, manual 1.3.5).
            They are called within the controller's cycle, so they must not block.
    """

    def __init__(self) -> None:
        self.events: dict[str, Callable[[], None]] = {}
        self.standard_in: Bank[bool] = Bank(16, False)
        self.standard_out: Outputs = Outputs(16)
        self.function_in: Bank[bool] = Bank(8, False)
        self.function_out: Bank[bool] = Bank(8, False)
        self.config_in: Bank[bool] = Bank(8, False)
        self.tool_in: Bank[bool] = Bank(2, False)
        self.tool_out: Bank[bool] = Bank(2, False)
        self.tool_buttons: Bank[bool] = Bank(2, False)
        self.voltage_in: Bank[float] = Bank(4, 0.0)
        self.voltage_out: Bank[float] = Bank(4, 0.0)
        self.current_in: Bank[float] = Bank(4, 0.0)
        self.current_out: Bank[float] = Bank(4, 0.0)
        self.analog_mode: Bank[int] = Bank(4, 0)
        self.tool_voltage_in: Bank[float] = Bank(2, 0.0)
        self.function_reg_in: Bank[bool] = Bank(16, False)
        self.function_reg_out: Bank[bool] = Bank(16, False)
        self.bool_in: Bank[bool] = Bank(64, False)
        self.bool_out: Bank[bool] = Bank(64, False)
        self.word_in: Bank[int] = Bank(32, 0)
        self.word_out: Bank[int] = Bank(32, 0)
        self.float_in: Bank[float] = Bank(32, 0.0)
        self.float_out: Bank[float] = Bank(32, 0.0)
