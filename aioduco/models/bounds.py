"""The one rule of bounds, for numbers and for arrays.

Controllers, cameras and ROS send many numbers in binary32 (IEEE 754), which rounds them: a joint
that stands at 2π is read as 6.2831855, above the limit. So a number is within a bound if the
number before that rounding may be; what is sent or stored is then the bound itself. A bound that is
printed lies within the bounds: it can be typed back.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from aioduco.models.numpy_on_use import np

if TYPE_CHECKING:
    from numpy.typing import NDArray


ROUNDING = 2.0**-24
"""Largest relative error of a number that was rounded to binary32."""


def least(low: float) -> float:
    """The smallest number that is within a lower bound, an infinite one included."""
    return low - abs(low) * ROUNDING


def most(high: float) -> float:
    """The largest number that is within an upper bound, an infinite one included."""
    return high + abs(high) * ROUNDING


def clipped(values: Any, low: Any, high: Any) -> NDArray[np.float64]:
    """Numbers with those that rounding led beyond a bound at that bound; others are unchanged."""
    given = np.asarray(values, dtype=np.float64)
    near = np.clip(given, low, high)
    found: NDArray[np.float64] = np.where(abs(given - near) <= abs(near) * ROUNDING, near, given)
    return found


def outside(values: Any, low: Any, high: Any) -> NDArray[np.bool_]:
    """Which numbers are beyond their bounds by more than rounding; NaN is."""
    near = clipped(values, low, high)
    beyond: NDArray[np.bool_] = ~((near >= low) & (near <= high))
    return beyond


def shown(bound: float, *, low: bool = False, digits: int = 4) -> str:
    """Format a bound with so many digits, rounded to the side of the allowed numbers.

    Args:
        bound: the bound.
        low: whether it is a lower bound.
        digits: number of significant digits.
    """
    if not math.isfinite(bound) or bound == int(bound):
        return f"{bound:.0f}"
    text = f"{bound:.{digits}g}"
    if float(text) < bound if low else float(text) > bound:
        step = 10.0 ** (math.floor(math.log10(abs(bound))) + 1 - digits)
        text = f"{bound + (step if low else -step) / 2:.{digits}g}"
    return text
