"""Doing something to its end although the task that does it is cancelled, once or more.

anyio's shield keeps cancel scopes away, but not `asyncio.Task.cancel`, which `asyncio.timeout`,
task groups and Ctrl-C use; a second Ctrl-C cancels once more, while the first is being served.
A stop of the arm must survive all of them, so it is repeated until it is done. What is done this
way must therefore be safe to do twice, and must end by itself: it has a deadline of its own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import anyio

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

T = TypeVar("T")


async def insist(step: Callable[[], Awaitable[T]]) -> tuple[T, BaseException | None]:
    """Await `step()`, again whenever it is cancelled, until it returns or raises.

    An interrupt from the keyboard, or an exit from a signal handler, that lands in the middle of
    it is treated like a cancellation.

    Args:
        step: makes what is awaited; called once, and once more for each cancellation.

    Returns:
        The result, and the last cancellation that came meanwhile: the caller must raise it.
    """
    cancelled: BaseException | None = None
    results: list[T] = []
    with anyio.CancelScope(shield=True):
        while not results:
            try:
                results.append(await step())
            except (anyio.get_cancelled_exc_class(), KeyboardInterrupt, SystemExit) as exc:
                cancelled = exc
    return results[0], cancelled
