"""Many numbers of a path in one block of memory.

A list of a hundred thousand numbers is as many objects: the garbage collector visits each while the
list is young, and all of them are freed at one go, for milliseconds in which no other thread runs.
An `array` is one object. Reading a number of it takes no longer than of a list, unlike NumPy's.
"""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from aioduco.models.rotation import Array


def numbers(values: Array) -> array[float]:
    """Give the numbers of a NumPy array. Shape (n,)."""
    return array("d", values.tobytes())


def joined(*parts: Iterable[float]) -> array[float]:
    """Give the numbers of some parts, one part behind the other."""
    result = array("d")
    for part in parts:
        result.extend(part)
    return result


def shifted(values: Sequence[float], by: float) -> array[float]:
    """Give numbers that are greater by a number."""
    return numbers(np.asarray(values) + by)
