"""External axes (外部轴, manual 1.3.14): their parameters, their schemes, their positions.

They have no mechanics: each follows its set-point exactly. Poses do not depend on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.errors import ParameterError
from aioduco.models.bounds import outside
from aioduco.models.ranges import FINITES
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.segments import ExternalAxesMove
from aioduco.sim.refusal import Rejected, illegal, mismatch

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


#: most axes of a scheme: positions on the wire have three numbers
_MOST = 3
#: numbers of an axis that must be given
_NEEDED = 4
#: numbers of axes and schemes are below this one
CAPACITY = 32


class Axis(NamedTuple):
    """An external axis, in radians if it turns, in metres if it slides.

    Attributes:
        lower: lower end of its range.
        upper: upper end of its range.
        velocity: highest speed [1/s].
        acceleration: acceleration of planned moves [1/s²].
        braking: highest deceleration of its drive, for a stop [1/s²]; 0 for `acceleration`.
        jog: speed of a jog at 100 % [1/s]; 0 for the highest speed.
    """

    lower: float
    upper: float
    velocity: float
    acceleration: float
    braking: float = 0.0
    jog: float = 0.0


@dataclass(slots=True)
class Scheme:
    """Up to three axes that are moved together.

    Attributes:
        name: name that motions use for it.
        axes: numbers of its axes.
        active: whether it has been enabled.
    """

    name: str
    axes: tuple[int, ...] = ()
    active: bool = False


class SchemeState(NamedTuple):
    """State of a scheme.

    Attributes:
        name: name that motions use for it.
        active: whether it has been enabled.
        position: position of its first axis [rad or m].
        speed: commanded speed of that axis [1/s].
        acceleration: its commanded acceleration [1/s²].
    """

    name: str
    active: bool
    position: float
    speed: float
    acceleration: float


class SimulatedExternalAxes:
    """The external axes of a controller.

    Args:
        schemes: the schemes that were set up at the pendant: the axes of each, by its name.

    Attributes:
        positions: position of each axis, by its number [rad or m]; the axes of `schemes` are
            numbered from 0, in their order.

    Raises:
        ValueError: the schemes are not valid.
    """

    def __init__(self, schemes: Mapping[str, Sequence[Sequence[float]]] | None = None) -> None:
        self.positions: dict[int, float] = {}
        self._axes: dict[int, Axis] = {}
        #: by axis, its speed and acceleration while it is commanded; replaced, not changed
        self._rates: dict[int | None, tuple[float, float]] = {}
        self._schemes: dict[int, Scheme] = {}  # replaced, not changed: read without a lock
        try:
            for name, axes in (schemes or {}).items():
                self._define(name, _given(name, axes))
        except Rejected as exc:
            raise ValueError(f"external axes: {exc}") from None

    def _define(self, name: str, axes: Sequence[Axis]) -> None:
        numbers = tuple(range(len(self._axes), len(self._axes) + len(axes)))
        for number, axis in zip(numbers, axes, strict=True):
            self.set_axis(number, axis)
        self._schemes[len(self._schemes)] = scheme = Scheme(name)
        self._link(scheme, numbers)

    def states(self) -> list[SchemeState]:
        """State of each scheme."""
        return [self._state(scheme) for scheme in self._schemes.values()]

    def _state(self, scheme: Scheme) -> SchemeState:
        first = scheme.axes[0] if scheme.axes else None
        position = 0.0 if first is None else self.positions[first]
        return SchemeState(
            scheme.name, scheme.active, position, *self._rates.get(first, (0.0, 0.0))
        )

    def follow(self, positions: Mapping[int, float], cycle: float) -> None:
        """Take the axes to positions that a motion commands; the others stand.

        Args:
            positions: by axis [rad or m].
            cycle: time in which a motion takes them there [s]. Idle time before it does not count.
        """
        if not positions and not self._rates:
            return
        rates: dict[int | None, tuple[float, float]] = {}
        for number, position in positions.items():
            speed = (position - self.positions[number]) / cycle
            rates[number] = speed, (speed - self._rates.get(number, (0.0, 0.0))[0]) / cycle
        self.positions.update(positions)
        self._rates = rates

    # -- set-up --------------------------------------------------------------------------------

    def set_axis(self, number: int, axis: Axis) -> None:
        """Set up an axis.

        A known axis keeps its position; a new one starts at the position nearest to zero.
        """
        _check_number(number)
        if not (axis.lower < axis.upper and axis.velocity > 0.0 and axis.acceleration > 0.0):
            raise mismatch("an axis has a way, a highest speed and an acceleration")
        if any(number in scheme.axes and scheme.active for scheme in self._schemes.values()):
            raise illegal(f"axis {number} is in use")
        self._axes[number] = axis
        self.positions.setdefault(number, min(max(0.0, axis.lower), axis.upper))

    def add(self, number: int) -> None:
        """Add a scheme without axes."""
        _check_number(number)
        if number in self._schemes:
            raise illegal(f"there is a scheme {number} already")
        self._schemes = {**self._schemes, number: Scheme(f"scheme{number}")}

    def delete(self, number: int) -> None:
        """Delete a scheme."""
        deleted = self._inactive(number)
        self._schemes = {n: scheme for n, scheme in self._schemes.items() if n != deleted}

    def link(self, number: int, axes: Sequence[int]) -> None:
        """Set which axes belong to a scheme."""
        self._link(self._schemes[self._inactive(number)], tuple(axes))

    def _link(self, scheme: Scheme, axes: tuple[int, ...]) -> None:
        if not 1 <= len(axes) <= _MOST or len(set(axes)) < len(axes):
            raise mismatch(f"a scheme has one to {_MOST} axes, each once")
        if missing := set(axes) - self._axes.keys():
            raise mismatch(f"axis {min(missing)} has not been set up")
        scheme.axes = axes

    def _inactive(self, number: int) -> int:
        if number not in self._schemes:
            raise illegal(f"there is no scheme {number}")
        if self._schemes[number].active:
            raise illegal(f"scheme {number} is active")
        return number

    # -- use -----------------------------------------------------------------------------------

    def enable(self, name: str) -> None:
        """Activate a scheme; its axes must not belong to another one that is active."""
        scheme = self._scheme(name)
        if not scheme.axes:
            raise illegal(f"scheme {name!r} has no axes")
        for other in self._schemes.values():
            if other is not scheme and other.active and set(other.axes) & set(scheme.axes):
                raise illegal(f"scheme {other.name!r} has one of the axes")
        scheme.active = True

    def disable(self, name: str) -> None:
        """Deactivate a scheme."""
        self._scheme(name).active = False

    def to(self, name: str, target: Sequence[float], speed: float) -> ExternalAxesMove:
        """Make the move of a scheme to positions.

        Args:
            name: name of the scheme, which must be active.
            target: positions to move to; numbers beyond those of its axes have no effect.
            speed: highest speed of each axis.

        Raises:
            PlanError: an axis would leave its range.
        """
        scheme = self.check_active(name)
        axes = [self._axes[number] for number in scheme.axes]
        for axis, end in zip(axes, target, strict=False):
            if outside(end, axis.lower, axis.upper):
                way = f"{axis.lower:g} to {axis.upper:g}"
                raise PlanError("limits", f"an axis of {name!r} would leave {way}")
        return self._move(scheme.axes, list(target[: len(axes)]), [speed] * len(axes))

    def jog(self, name: str, direction: int, share: float) -> ExternalAxesMove:
        """Make the move of a jog: of the first axis of a scheme, to the end of its range.

        Args:
            name: name of the scheme, which must be active.
            direction: 1 or -1.
            share: share of the axis's jog speed, 0 to 1.
        """
        number = self.check_active(name).axes[0]
        axis = self._axes[number]
        speed = share * (axis.jog or axis.velocity)
        return self._move((number,), [axis.upper if direction > 0 else axis.lower], [speed])

    def _move(
        self, numbers: tuple[int, ...], target: Sequence[float], speeds: Sequence[float]
    ) -> ExternalAxesMove:
        axes = [self._axes[number] for number in numbers]
        return ExternalAxesMove(
            numbers,
            np.array([self.positions[number] for number in numbers]),
            np.array(target, dtype=float),
            np.minimum(speeds, [axis.velocity for axis in axes]),
            np.array([axis.acceleration for axis in axes]),
            np.array([axis.braking or axis.acceleration for axis in axes]),
        )

    def check_active(self, name: str) -> Scheme:
        """Check that a scheme may be used, and give it."""
        scheme = self._scheme(name)
        if not scheme.active:
            raise illegal(f"scheme {name!r} is not active")
        return scheme

    def _scheme(self, name: str) -> Scheme:
        for scheme in self._schemes.values():
            if scheme.name == name:
                return scheme
        known = ", ".join(scheme.name for scheme in self._schemes.values()) or "none"
        raise illegal(f"there is no scheme {name!r}; there are: {known}")


def _check_number(number: int) -> None:
    if not 0 <= number < CAPACITY:
        raise mismatch(f"num is {number}, but must be from 0 to {CAPACITY - 1}")


def _given(name: str, axes: Sequence[Sequence[float]]) -> list[Axis]:
    """The axes of a scheme as a program gives them."""
    where = f"external_axes[{name!r}]"
    if not isinstance(axes, (list, tuple)):
        raise ParameterError(where, axes, "a list of axes")
    found = []
    for number, axis in enumerate(axes):
        numbers = FINITES(f"{where}[{number}]", axis)
        if not _NEEDED <= len(numbers) <= len(Axis._fields):
            expected = "an Axis: lower, upper, velocity, acceleration, perhaps braking and jog"
            raise ParameterError(f"{where}[{number}]", axis, expected)
        found.append(Axis(*numbers))
    return found
