"""When to ask for the state of each task: pure functions of times.

The controller does not tell when a task ends; it is asked. Asking costs a round trip, so a
task is asked about often when something is likely to happen and seldom when not:

- just after acceptance, when it starts, is refused, or was short;
- near its expected end and shortly after, if an end can be expected;
- in between at a rate that still keeps the notice of an unexpected end short.

Due times are absolute: a late poll does not move the ones after it. Polls that were missed are
left out, not caught up with.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Generic, TypeVar

#: seconds between polls while something is likely to happen
FAST = 0.002
#: seconds between polls of a task whose end cannot be expected; half of it is the median delay
STEADY = 0.005
#: seconds between polls at most, far from an expected end
SLOW = 0.025
#: for how long after its acceptance a task counts as fresh [s]
FRESH = 0.05
#: for how long after its expected end a task is asked about at the fast rate [s]
OVERDUE = 0.1
#: part of the time that remains until the expected end that may pass without a poll
_APPROACH = 0.25

K = TypeVar("K", bound=Hashable)


def interval(age: float, remaining: float | None = None) -> float:
    """Return the seconds until the next poll of a task.

    Args:
        age: seconds since the controller accepted the task.
        remaining: seconds until its expected end, negative after it; None if unknown.
    """
    if age < FRESH:
        return FAST
    if remaining is None or remaining < -OVERDUE:
        return STEADY
    return min(max(remaining * _APPROACH, FAST), SLOW)


class Roster(Generic[K]):
    """Who is to be asked next: the one whose due time is earliest.

    When there is more to ask than time for it, every due time has passed, and the earliest is
    that of the task not asked for longest: the roster is then a round robin.
    """

    def __init__(self) -> None:
        self._due: dict[K, float] = {}

    def __len__(self) -> int:
        return len(self._due)

    def __contains__(self, key: K) -> bool:
        return key in self._due

    def add(self, key: K, due: float) -> None:
        """Take `key` in, to be asked at `due`."""
        self._due[key] = due

    def remove(self, key: K) -> None:
        """Take `key` out, if it is in."""
        self._due.pop(key, None)

    def first(self) -> tuple[K, float] | None:
        """Who is next, and when; None if nobody is in."""
        if not self._due:
            return None
        key = min(self._due, key=self._due.__getitem__)
        return key, self._due[key]

    def asked(self, key: K, now: float, every: float) -> None:
        """`key` was asked: its next due time is `every` after the last, or after now if past."""
        if key in self._due:
            due = self._due[key] + every
            self._due[key] = due if due > now else now + every
