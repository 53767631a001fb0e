"""numpy, loaded when it is first used: opening a robot and stopping it needs none of it.

Here is also told what of it is a number, and what is not; and what a value is in JSON.
"""

from __future__ import annotations

import dataclasses
import enum
import importlib
import math
import numbers
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeGuard

from aioduco.errors import Described, ParameterError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
else:

    class _NumpyOnUse:
        """Loads numpy for the first attribute, and keeps each for the next time."""

        def __getattr__(self, name: str) -> Any:
            value = getattr(importlib.import_module("numpy"), name)
            setattr(self, name, value)
            return value

    np = _NumpyOnUse()

#: what counts as a number: also those of numpy, and fractions
_REAL: Any = numbers.Real

__all__ = ["is_array", "is_number", "is_scalar", "json_value", "np", "number_array", "plain"]


def is_array(value: object) -> TypeGuard[NDArray[Any]]:
    """Whether a value is an array of numpy, which is not loaded for it."""
    return isinstance(value, _kinds("ndarray"))


def is_scalar(value: object) -> TypeGuard[np.generic[Any] | NDArray[Any]]:
    """Whether a value is a scalar of numpy, or an array without dimensions."""
    return isinstance(value, _kinds("generic")) or (is_array(value) and value.ndim == 0)


def plain(value: object) -> Any:
    """A scalar of numpy, or an array without dimensions, as Python has it.

    A time of numpy becomes None: it counts as a whole number there, in a unit of its own. So does
    what is masked, which is missing: its number is 0.
    """
    if not is_scalar(value):
        return value
    missing = value.dtype.kind in "mM" or getattr(value, "mask", False)
    return None if missing else value.item()


def json_value(value: Any, *, recorded: bool = False) -> Any:
    """A value in the types of JSON; a number that is not finite becomes None.

    Args:
        value: the value.
        recorded: whether it is as in a recording, where named tuples have the names of their fields
            and bytes are hexadecimal digits, not numbers.
    """
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, str | bool | int | None):
        return value
    return _json_parts(value, recorded)


def _json_parts(value: Any, recorded: bool) -> Any:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    elif recorded and (named := getattr(value, "_asdict", None)) is not None:
        value = named()
    if isinstance(value, dict):
        return {str(key): json_value(each, recorded=recorded) for key, each in value.items()}
    if recorded and isinstance(value, bytes | bytearray):
        return value.hex()
    if isinstance(value, list | tuple | set | frozenset | bytes | bytearray):
        return [json_value(each, recorded=recorded) for each in value]
    listed = getattr(value, "tolist", None)
    return str(value) if listed is None else json_value(listed())


def is_number(value: object) -> bool:
    """Whether it is a real number, also one of numpy; True, False and times are none."""
    number = plain(value)
    return isinstance(number, _REAL) and not isinstance(number, bool)


def number_array(
    name: str, value: Any, expected: str = "an array of numbers", *, finite: bool = True
) -> NDArray[np.float64]:
    """A new array of numbers.

    Texts are none, although numpy converts them, nor are times, which have another unit than the
    argument, nor truth values. What is masked is missing: it counts as not finite.

    Args:
        name: the argument's name.
        value: the argument.
        expected: what it must be.
        finite: whether all of them must be finite.

    Raises:
        ParameterError: it is no such array.
    """
    told = value
    found = None
    with suppress(TypeError, ValueError, OverflowError):
        given = np.asarray(value)
        if is_array(value):
            told = Described(f"an array of shape {given.shape} and type {given.dtype}")
        kind = given.dtype.kind
        if kind in "fiu" or (kind == "O" and all(map(is_number, given.flat))):
            found = given.astype(np.float64)
    if found is None:
        raise ParameterError(name, told, expected)
    if np.ma.is_masked(value):
        found[np.ma.getmaskarray(value)] = np.nan
    if finite and not np.isfinite(found).all():
        raise ParameterError(name, told, f"{expected}, all of them finite")
    return found


def _kinds(name: str) -> tuple[type, ...]:
    """The class of numpy with this name; none before numpy is loaded, perhaps by another thread."""
    kind = getattr(sys.modules.get("numpy"), name, None)
    return () if kind is None else (kind,)
