"""Checks of arguments. A wrong one ends the task in the same state as on the real controller."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco.errors import ParameterError
from aioduco.models.bounds import least, most, shown
from aioduco.models.load import Load
from aioduco.models.pose import Pose
from aioduco.sim.refusal import Forgiving, illegal, mismatch

if TYPE_CHECKING:
    from collections.abc import Container, Sequence


#: the largest distance in a pose [m]: far beyond every arm, but still safe to compute with
_FARTHEST = 1000.0
#: the largest load, the payload of the largest arm [kg], and its largest distance along an axis [m]
_HEAVIEST, _ARM = 35.0, 10.0
#: the largest angle in a pose (manual 1.3.5) [rad]
_TURNS = 2.0 * math.pi


def number(name: str, value: float, low: float, high: float, unit: str) -> float:
    """Check that a number is within a range, but for rounding; NaN never is."""
    if not least(low) <= value <= most(high):
        raise mismatch(f"{name} is {value}, but must be {_range(low, high)} {unit}")
    return min(max(value, low), high)


def choice(name: str, value: int, allowed: Container[int], words: str) -> None:
    """Check that a number is one of some, which `words` names."""
    if value not in allowed:
        raise mismatch(f"{name} is {value}, but must be {words}")


def _range(low: float, high: float) -> str:
    return f"from {shown(low, low=True, digits=6)} to {shown(high, digits=6)}"


def at_most(
    forgiving: Forgiving, kind: str, name: str, value: float, low: float, high: float, unit: str
) -> float:
    """Check that a number is within a range; a larger one is cut to `high` if that is forgiven."""
    if most(high) < value < math.inf:
        forgiving.forgive(kind, f"{name} is {value}, but must be {_range(low, high)} {unit}")
        return high
    return number(name, value, low, high, unit)


def positive(name: str, value: float, high: float, unit: str) -> float:
    """Check that a number is above zero and at most `high`."""
    if not value > 0.0:
        raise mismatch(f"{name} is {value}, but must be above 0 {unit}")
    return number(name, value, 0.0, high, unit)


def numbers(name: str, values: Sequence[float], length: int) -> tuple[float, ...]:
    """Check that there are `length` numbers, all of them finite."""
    if len(values) != length or not all(map(math.isfinite, values)):
        raise mismatch(f"{name} must be {length} finite numbers")
    return tuple(values)


def six(
    name: str, values: Sequence[float], most: float, unit: str, turning: float | None = None
) -> tuple[float, ...]:
    """Check six numbers of which no amount is above `most`; for the last three, `turning`."""
    limits = [most] * 3 + [most if turning is None else turning] * 3
    given = zip(numbers(name, values, 6), limits, strict=True)
    return tuple(number(name, value, -limit, limit, unit) for value, limit in given)


def pose(name: str, values: Sequence[float]) -> Pose:
    """Check a pose [m, rad]: positions within a kilometre, angles from -2π to 2π."""
    try:
        given = Pose.of(list(values))
    except ParameterError as exc:
        raise mismatch(f"{name} must be {exc.expected}") from None
    place = [number(name, each, -_FARTHEST, _FARTHEST, "m") for each in given[:3]]
    return Pose(*place, *(number(name, each, -_TURNS, _TURNS, "rad") for each in given[3:]))


def load(name: str, values: Sequence[float]) -> Load:
    """Check a load: mass up to the largest arm's payload [kg], and centre of gravity [m]."""
    mass, *centre = numbers(name, values, 4)
    number(name, mass, 0.0, _HEAVIEST, "kg")
    return Load(mass, *(number(name, one, -_ARM, _ARM, "m") for one in centre))


def joints(name: str, values: Sequence[float]) -> tuple[float, ...]:
    """Check six joint angles [rad], each from -2π to 2π.

    As on the controller, a wrong count of angles is ILLEGAL and a wrong value PARAMETER_MISMATCH.
    """
    if len(values) != 6:
        raise illegal(f"{name} has {len(values)} numbers, but must have 6")
    return tuple(number(name, value, -_TURNS, _TURNS, "rad") for value in values)


def name_of(name: str, value: str, max_bytes: int) -> str:
    """Check that a name is not empty and not too long."""
    if not 0 < len(value.encode()) <= max_bytes:
        raise mismatch(f"{name} must have 1 to {max_bytes} bytes")
    return value
