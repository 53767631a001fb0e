"""Wait for a condition in place of a sleep."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import anyio

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["eventually", "eventually_async"]

#: s between two looks at first, and at last: a condition that comes soon is seen soon, and one
#: that takes long does not keep the processor from what it waits for
_FIRST = 0.0005
_LAST = 0.02


def eventually(
    condition: Callable[[], object], timeout: float = 30.0, *, what: str | Callable[[], str] = ""
) -> None:
    """Wait, in a plain thread, until a condition holds.

    Args:
        condition: looked at again and again; it must have no effects.
        timeout: s after which waiting ends: a net for what never comes, so long that no busy
            machine reaches it.
        what: what is waited for, for the error; a callable is asked only then.

    Raises:
        AssertionError: the condition does not hold after the time-out.
    """
    for pause in _pauses(condition, timeout, what):
        time.sleep(pause)


async def eventually_async(
    condition: Callable[[], object], timeout: float = 30.0, *, what: str | Callable[[], str] = ""
) -> None:
    """Wait, in a coroutine, until a condition holds.

    Args:
        condition: looked at again and again; it must have no effects and not block.
        timeout: s after which waiting ends: a net for what never comes, so long that no busy
            machine reaches it.
        what: what is waited for, for the error; a callable is asked only then.

    Raises:
        AssertionError: the condition does not hold after the time-out.
    """
    for pause in _pauses(condition, timeout, what):
        await anyio.sleep(pause)


def _pauses(
    condition: Callable[[], object], timeout: float, what: str | Callable[[], str]
) -> Iterator[float]:
    """How long to wait, again and again, until the condition holds."""
    deadline = time.monotonic() + timeout
    pause = _FIRST
    while not condition():
        left = deadline - time.monotonic()
        if left <= 0:
            said = what if isinstance(what, str) else what()
            said = said or getattr(condition, "__qualname__", repr(condition))
            raise AssertionError(f"not so after {timeout:g} s: {said}")
        yield min(pause, left)
        pause = min(2 * pause, _LAST)
