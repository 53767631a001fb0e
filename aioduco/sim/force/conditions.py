"""The conditions under which a motion ends in force control (fc_wait_*, manual 1.3.10)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from aioduco.models.force import ForceLogic

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


#: in the order of fc_wait_logic
Quantity: TypeAlias = Literal["pos", "vel", "ft"]
Verdict: TypeAlias = Literal["met", "late"]

QUANTITIES: tuple[Quantity, ...] = ("pos", "vel", "ft")
_EARLY = 1e-9  # allowance for the rounding of a time that is a sum of cycles [s]


@dataclass(frozen=True, slots=True)
class Condition:
    """Some or all of six numbers have to be within their ranges for a while.

    Attributes:
        middle: middles of the ranges [m, rad; m/s, rad/s; N, N m].
        range: largest distances from the middles, to both sides; 0 for a number that is ignored.
        absolute: whether the numbers are checked, or their changes since the conditions began.
        duration: time for which they must be within their ranges [s].
        timeout: time from the beginning within which this must be so [s].
    """

    middle: tuple[float, ...]
    range: tuple[float, ...]
    absolute: bool
    duration: float
    timeout: float

    @property
    def counts(self) -> bool:
        """Whether any of the six numbers is checked."""
        return any(width != 0.0 for width in self.range)


class Conditions:
    """The conditions on position, speed and force, and how they are combined. Without a clock.

    All conditions with "and" have to hold at the same time; one with "or" is enough by itself.
    """

    def __init__(self) -> None:
        self.verdict: Verdict | None = None
        self._conditions: dict[Quantity, Condition] = {}
        self._logic: dict[Quantity, int] = {}
        self._began = 0.0
        self._references: dict[Quantity, tuple[float, ...]] = {}
        self._since: dict[Quantity, float] = {}

    def set(self, quantity: Quantity, condition: Condition) -> None:
        """Set a condition; the logic given to `begin` decides whether it is checked."""
        self._conditions[quantity] = condition
        self._since.pop(quantity, None)

    def begin(
        self,
        logic: Sequence[int],
        time: float,
        now: Callable[[Quantity], Sequence[float]],
    ) -> None:
        """Restart the conditions (fc_wait_logic).

        Args:
            logic: for position, speed and force 0 for off, 1 for "and", 2 for "or". A quantity
                without a condition is off until it gets one.
            time: time of the simulation [s].
            now: returns the six numbers of a quantity, from which changes are counted.
        """
        pairs = zip(QUANTITIES, logic, strict=True)
        self._logic = {quantity: how for quantity, how in pairs if how != ForceLogic.OFF}
        self._references = {quantity: tuple(now(quantity)) for quantity in self._logic}
        self._since.clear()
        self._began = time
        self.verdict = None

    def end(self) -> None:
        """Switch all conditions off."""
        self._logic.clear()
        self._since.clear()
        self.verdict = None

    def restart_durations(self) -> None:
        """Restart the durations of all conditions, since no motion runs."""
        self._since.clear()

    def tick(self, time: float, now: Callable[[Quantity], Sequence[float]]) -> Verdict | None:
        """Check the conditions.

        Args:
            time: time of the simulation [s].
            now: returns the six numbers of a quantity.

        Returns:
            "met" when they hold, "late" when they can no longer hold in time; this then stays so.
        """
        if not self._logic or self.verdict is not None:
            return self.verdict
        logic: dict[Quantity, int] = {
            each: how
            for each, how in self._logic.items()
            if each in self._conditions and self._conditions[each].counts
        }
        held = {each: self._held(each, time, now(each)) for each in logic}
        late = {each: not held[each] and self._is_late(each, time) for each in logic}
        together = [each for each, how in logic.items() if how == ForceLogic.AND]
        groups = [[each] for each in logic if each not in together]
        if together:
            groups.append(together)
        if any(all(held[each] for each in group) for group in groups):
            self.verdict = "met"
        elif groups and all(any(late[each] for each in group) for group in groups):
            self.verdict = "late"
        return self.verdict

    def _is_late(self, quantity: Quantity, time: float) -> bool:
        return time - self._began > self._conditions[quantity].timeout + _EARLY

    def _held(self, quantity: Quantity, time: float, values: Sequence[float]) -> bool:
        """Whether a condition has held for long enough."""
        condition = self._conditions[quantity]
        turning = quantity == "pos"
        for i, width in enumerate(condition.range):
            if width == 0.0:
                continue
            value = values[i] - condition.middle[i]
            if not condition.absolute:
                value -= self._references[quantity][i]
            if turning and i >= 3:
                value = math.remainder(value, math.tau)
            if not abs(value) <= width:
                self._since.pop(quantity, None)
                return False
        since = self._since.setdefault(quantity, time)
        return time - since >= condition.duration - _EARLY
