"""Reads that are retried while the connection is lost.

A function that only reads is called again, after a growing random pause, until its deadline: a
controller that restarts, or a switch that reboots, causes a short delay instead of an error. A
command is never sent again: if it was not sent, it raises an error that says so; if its answer was
lost, it raises `OutcomeUnknown`.
"""

from __future__ import annotations

import random
import time
from typing import TYPE_CHECKING, Any, Final

import anyio

from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.rpc import AsyncRpc
from aioduco.errors import ConnectError, ConnectionLost, ProtocolError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco._wire.lane import WireLane

__all__ = ["RetryingReads", "pauses"]

#: first and longest pause before another attempt [s]
FIRST: Final = 0.02
LONGEST: Final = 1.0


def pauses(draw: random.Random) -> Iterator[float]:
    """Yield pauses between attempts [s]: each up to twice as long as the one before, at random.

    Many programs that lose the same controller must not reconnect all at once: a pause has at least
    half of its limit, at most all of it.

    Args:
        draw: the random number generator.
    """
    limit = FIRST
    while True:
        yield limit * (0.5 + 0.5 * draw.random())
        limit = min(limit * 2, LONGEST)


class RetryingReads:
    """The calls of a lane; those that only read are retried while the connection is lost.

    Args:
        lane: lane on which calls are sent.

    Attributes:
        rpc: the functions of the wire with the lane's time limit.
        retries: number of retried reads.
    """

    def __init__(self, lane: WireLane) -> None:
        self._lane = lane
        self._draw = random.Random()
        self.rpc: AsyncRpc = AsyncRpc(self.call)
        self.retries: int = 0

    async def call(self, name: str, args: tuple[Any, ...]) -> Any:
        """Call a function of the wire, as `WireLane.call`; a read is retried.

        The lane's time limit holds for the whole call, with its retries.

        Args:
            name: the function.
            args: one value per parameter.
        """
        left = self._lane.call_timeout
        until, following = time.monotonic() + left, pauses(self._draw)
        while True:
            try:
                return await self._lane.call(name, args, left)
            except (ConnectError, ConnectionLost) as exc:
                if call_kind(name) is not CallKind.READ or isinstance(exc, ProtocolError):
                    raise
                if time.monotonic() + (pause := next(following)) >= until:
                    raise
            await anyio.sleep(pause)
            self.retries += 1
            left = max(0.001, until - time.monotonic())
