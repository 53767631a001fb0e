"""Work in slices: a long plan yields to other threads in between.

Planning runs while the controller's cycles and commands go on. The planning code calls `yield_now`
between two slices of the work. There the caller of the plan, who has set a hook by `yielding`,
yields to other threads, or raises `PlanDropped` if the plan is no longer needed. The slices depend
on the path alone, never on the time that a slice takes, so a plan has the same result on every
machine.
"""

from __future__ import annotations

from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator


T = TypeVar("T")
R = TypeVar("R")

#: number of samples or nodes of a path that are processed between two calls of the hook
SLICE = 64
#: the same for work with only a few operations on each
LONG_SLICE = 128


class PlanDropped(Exception):
    """A plan is no longer needed. This is not an error: planning code must not catch it."""


#: of the thread that plans; None where no other thread waits
_hook: ContextVar[Callable[[], None] | None] = ContextVar("yield_hook", default=None)


@contextmanager
def yielding(hook: Callable[[], None]) -> Iterator[None]:
    """Have the planning code of this thread call a function between slices of its work."""
    token = _hook.set(hook)
    try:
        yield
    finally:
        _hook.reset(token)


def yield_now() -> None:
    """Let other threads run, if the caller of the plan has set how.

    Raises:
        PlanDropped: the plan is no longer needed.
    """
    if (hook := _hook.get()) is not None:
        hook()


def slices(count: int, size: int = SLICE) -> Iterator[slice]:
    """Cut a number of samples into slices of a size, and yield to other threads after each."""
    for begin in range(0, count, size):
        yield slice(begin, min(begin + size, count))
        yield_now()


def in_turn(function: Callable[[T], R], values: Iterable[T]) -> list[R]:
    """Call a function with each of some values, and yield to other threads after each call."""
    results: list[R] = []
    for value in values:
        results.append(function(value))
        yield_now()
    return results
