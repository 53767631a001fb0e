"""System values: the global variables of the controller (系统变量, manual 1.3.7)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, TypeVar

from aioduco.errors import ParameterError
from aioduco.models.numpy_on_use import is_array, is_number, is_scalar

if TYPE_CHECKING:
    Value = bool | float | str | Sequence[float] | Sequence[Sequence[float]]


T = TypeVar("T")
_Stored = bool | float | str | list[float] | list[list[float]]


class UndefinedValue(Exception):
    """There is no variable of this name and type."""


class SystemValues:
    """The variables by name; each keeps its type.

    On a controller they are defined at the pendant, here by `Simulator(values=…)` or `define`.

    Args:
        values: the variables at the start, by name; "domain.name" for one in a domain.
    """

    def __init__(self, values: Mapping[str, Value] | None = None) -> None:
        self._values: dict[str, _Stored] = {}
        for name, value in (values or {}).items():
            self.define(name, value)

    def define(self, name: str, value: Value) -> None:
        """Define a variable, or change its type and value.

        Args:
            name: its name.
            value: bool, number, text, list of numbers, or list of such lists.

        Raises:
            ValueError: The name is empty, or a number is not finite.
        """
        if not name:
            raise ValueError("the name of a system value must not be empty")
        self._values[name] = _stored(value)

    def get(self, name: str, kind: type[T]) -> T:
        """The value of a variable.

        Raises:
            UndefinedValue: There is no variable of this name and type.
        """
        return _checked(name, self._values.get(name), kind)

    def set(self, name: str, value: bool | float | str | Sequence[float]) -> None:
        """Set a variable to another value of its type.

        Raises:
            UndefinedValue: There is no variable of this name and type.
            ValueError: A number is not finite.
        """
        stored = _stored(value)
        _checked(name, self._values.get(name), type(stored))
        if isinstance(stored, list):
            nested = any(isinstance(row, list) for row in stored)
            (self.lists if nested else self.numbers)(name)
        self._values[name] = stored

    def lists(self, name: str) -> list[list[float]]:
        """The value of a variable that is a list of lists.

        Raises:
            UndefinedValue: There is no variable of this name and type.
        """
        return self._items(name, list, "a list, not a list of lists")

    def numbers(self, name: str) -> list[float]:
        """The value of a variable that is a list of numbers.

        Raises:
            UndefinedValue: There is no variable of this name and type.
        """
        return self._items(name, float, "a list of lists, not a list")

    def _items(self, name: str, kind: type[T], other: str) -> list[T]:
        value = self.get(name, list)
        found = [each for each in value if isinstance(each, kind)]
        if len(found) != len(value):
            raise UndefinedValue(f"the system value {name!r} is {other}")
        return found


def _stored(value: Value) -> _Stored:
    if is_array(value) or is_scalar(value):
        value = value.tolist()
    if isinstance(value, bool | str):
        return value
    if isinstance(value, int | float):
        return _finite(value)
    _require_list(value)
    plain = [row.tolist() if is_array(row) or is_scalar(row) else row for row in value]
    rows = [row if isinstance(row, int | float) else _numbers(row) for row in plain]
    nested = [row for row in rows if isinstance(row, list)]
    if nested:
        if len(nested) != len(rows):
            raise ValueError("a list holds numbers or lists, not both")
        return nested
    return [_finite(row) for row in rows if not isinstance(row, list)]


def _require_list(value: object) -> None:
    if not isinstance(value, Sequence) or isinstance(value, (str, bytes)):
        kinds = "a bool, a number, a text, a list of numbers, or a list of such lists"
        raise ParameterError("a system value", value, kinds)


def _numbers(row: Sequence[float]) -> list[float]:
    _require_list(row)
    return [_finite(number) for number in row]


def _finite(value: float) -> float:
    number = math.nan
    if is_number(value):
        with suppress(OverflowError):
            number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"a system value holds finite numbers, not {value}")
    return number


def _checked(name: str, value: object, kind: type[T]) -> T:
    if value is None:
        raise UndefinedValue(f"there is no system value {name!r}")
    if not isinstance(value, kind):
        raise UndefinedValue(
            f"the system value {name!r} is a {type(value).__name__}, not a {kind.__name__}"
        )
    return value
