"""Conversion to SI units: `deg`, `mm`."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import TYPE_CHECKING, overload

from aioduco.errors import ParameterError
from aioduco.models.numpy_on_use import is_number

if TYPE_CHECKING:
    from collections.abc import Callable


@overload
def deg(value: float, /) -> float: ...
@overload
def deg(value: float, second: float, /, *more: float) -> tuple[float, ...]: ...
def deg(value: float, /, *more: float) -> float | tuple[float, ...]:
    """Convert degrees to radians: `deg(90)`, or several at once, `Pose(x, y, z, *deg(180, 0, 90))`.

    Args:
        value: an angle [deg].
        more: further angles [deg].

    Returns:
        The angle [rad], or a tuple of them when several were given.

    Raises:
        ParameterError: one of them is not a number.
    """
    return _each(math.radians, (value, *more), "a number of degrees")


@overload
def mm(value: float, /) -> float: ...
@overload
def mm(value: float, second: float, /, *more: float) -> tuple[float, ...]: ...
def mm(value: float, /, *more: float) -> float | tuple[float, ...]:
    """Convert millimetres to metres: `mm(50)`, or several at once, `Pose(*mm(692, 164, 660), …)`.

    Args:
        value: a length [mm].
        more: further lengths [mm].

    Returns:
        The length [m], or a tuple of them when several were given.

    Raises:
        ParameterError: one of them is not a number.
    """
    return _each(lambda length: length / 1000.0, (value, *more), "a number of millimetres")


def _each(
    convert: Callable[[float], float], values: tuple[float, ...], expected: str
) -> float | tuple[float, ...]:
    converted = []
    for value in values:
        with suppress(OverflowError):  # a number beyond all floats
            if is_number(value):
                converted.append(convert(value))
                continue
        raise ParameterError("value", value, f"{expected}; several are given one by one")
    return tuple(converted) if len(converted) > 1 else converted[0]
