"""Blocking calls of the package in threads that the program's own blocking calls cannot take."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

import anyio
import anyio.to_thread

if TYPE_CHECKING:
    from collections.abc import Callable

T = TypeVar("T")


async def in_thread(call: Callable[..., T], *args: object, abandon_on_cancel: bool = False) -> T:
    """Make a blocking call in a thread; it begins at once.

    anyio has 40 threads for all calls that name no limiter: a program that waits in all of them
    would hold up this one, too.

    Args:
        call: the function.
        args: its arguments.
        abandon_on_cancel: whether a cancellation leaves the thread behind, and waits no longer.
    """
    return await anyio.to_thread.run_sync(
        call, *args, abandon_on_cancel=abandon_on_cancel, limiter=anyio.CapacityLimiter(1)
    )
