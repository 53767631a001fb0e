"""Tests that do not depend on how fast or busy the machine is."""

from __future__ import annotations

import re
import threading
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import TypeVar

import anyio

from aioduco.errors import StreamRefused, StreamStarved
from aioduco.testing import eventually_async

T = TypeVar("T")

#: how often a stream that starved is run again at most
RUNS_AGAIN = 2

_BUSY = re.compile(
    r"^(?:the event loop (?:did not get to run|was blocked) for [\d.]+ s"
    r"|\S+: \d+ times the arm moved for more than [\d.]+ s without a sample).*\n",
    re.MULTILINE,
)


@asynccontextmanager
async def cancelled_once(condition: Callable[[], object]) -> AsyncIterator[anyio.CancelScope]:
    """Cancel the block as soon as a condition holds, however long that takes on this machine."""
    async with anyio.create_task_group() as tg:
        with anyio.CancelScope() as scope:

            async def cancel() -> None:
                await eventually_async(condition)
                scope.cancel()

            tg.start_soon(cancel)
            yield scope
        tg.cancel_scope.cancel()


def on_another_thread(work: Callable[[], object]) -> None:
    """Do it on a thread that has ended when this returns."""
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()


def complaints(stderr: str) -> str:
    """What a program said on its standard error, but for the time that the machine was busy."""
    return _BUSY.sub("", stderr)


async def streamed_in_time(
    run: Callable[[], Awaitable[T]], again: Callable[[], Awaitable[object]], totals: Counter[str]
) -> T:
    """Run what leads an arm on the clock of the wall, again if the machine was too busy for it.

    A stream for which set-points come too late ends, and says so: that is as it should be. It is
    run again twice at most, and counted.
    """
    for _ in range(RUNS_AGAIN):
        try:
            return await run()
        except (StreamStarved, StreamRefused):
            totals["streams starved and run again"] += 1
            await again()
    return await run()
