"""Work in slices: a long plan yields to other threads in between.

Planning runs while the controller's cycles and commands go on. The planning code calls its
`yield_hook` between two slices of the work. There the caller of the plan yields to other threads,
or raises `PlanDropped` if the plan is no longer needed. The slices depend on the path alone, never
on the time that a slice takes, so a plan has the same result on every machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from aioduco.models.rotation import Array

__all__ = ["LONG_SLICE", "SLICE", "PlanDropped", "YieldHook", "no_yield", "slices", "to_list"]

YieldHook: TypeAlias = Callable[[], None]

#: number of samples or nodes of a path that are processed between two calls of the hook
SLICE = 64
#: the same for work with only a few operations on each
LONG_SLICE = 512


class PlanDropped(Exception):
    """A plan is no longer needed. This is not an error: planning code must not catch it."""


def no_yield() -> None:
    """Continue at once: no other thread waits."""


def slices(count: int, yield_hook: YieldHook, size: int = SLICE) -> Iterator[slice]:
    """Cut a number of samples into slices, and call the hook after each.

    Args:
        count: number of samples.
        yield_hook: called after each slice.
        size: number of samples in a slice.
    """
    for begin in range(0, count, size):
        yield slice(begin, min(begin + size, count))
        yield_hook()


def to_list(values: Array, yield_hook: YieldHook) -> list[float]:
    """Give an array as a list, and call the hook after each of its slices. Shape (n,)."""
    numbers: list[float] = []
    for part in slices(len(values), yield_hook, 8 * LONG_SLICE):
        numbers += values[part].tolist()
    return numbers
