"""Conversion to SI units: `deg`, `mm`."""

from __future__ import annotations

import math
from typing import overload

__all__ = ["deg", "mm"]


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
    """
    if more:
        return tuple(math.radians(angle) for angle in (value, *more))
    return math.radians(value)


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
    """
    if more:
        return tuple(length / 1000.0 for length in (value, *more))
    return value / 1000.0
