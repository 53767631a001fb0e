"""Wait for a condition in place of a sleep."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import anyio

from aioduco.models.ranges import WAIT
from aioduco.models.rules import condition_holds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

#: seconds between two checks, at first and at last: a condition that holds soon is detected soon,
#: and a long wait leaves the processor to what it waits for
_FIRST = 0.0005
_LAST = 0.02


def eventually(
    condition: Callable[[], object], timeout: float = 30.0, *, what: str | Callable[[], str] = ""
) -> None:
    """Wait, in a plain thread, until a condition holds.

    Args:
        condition: checked repeatedly; it must have no side effects.
        timeout: seconds after which waiting ends: so many that only a condition that never holds
            reaches them, even on a busy machine.
        what: what is waited for, for the error message; a callable is called only then.

    Raises:
        ParameterError: the condition must be awaited.
        AssertionError: the condition does not hold after the time-out.
    """
    for pause in _pauses(condition, timeout, what):
        time.sleep(pause)


async def eventually_async(
    condition: Callable[[], object], timeout: float = 30.0, *, what: str | Callable[[], str] = ""
) -> None:
    """Wait, in a coroutine, until a condition holds.

    Args:
        condition: checked repeatedly; it must have no side effects and not block.
        timeout: seconds after which waiting ends: so many that only a condition that never holds
            reaches them, even on a busy machine.
        what: what is waited for, for the error message; a callable is called only then.

    Raises:
        ParameterError: the condition must be awaited.
        AssertionError: the condition does not hold after the time-out.
    """
    for pause in _pauses(condition, timeout, what):
        await anyio.sleep(pause)


def _pauses(
    condition: Callable[[], object], timeout: float, what: str | Callable[[], str]
) -> Iterator[float]:
    """Yield the seconds to sleep before each further check, until the condition holds."""
    timeout = WAIT("timeout", timeout)
    deadline = time.monotonic() + timeout
    pause = _FIRST
    while not condition_holds("condition", condition()):
        left = deadline - time.monotonic()
        if not left > 0:
            said = what if isinstance(what, str) else what()
            said = said or getattr(condition, "__qualname__", repr(condition))
            raise AssertionError(f"not so after {timeout:g} s: {said}")
        yield min(pause, left)
        pause = min(2 * pause, _LAST)
