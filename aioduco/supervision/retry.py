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


def retried(lane: WireLane) -> AsyncRpc:
    """The functions of the wire on a lane; reads are retried while the connection is lost.

    The lane's time limit holds for the whole call, with its retries.
    """
    draw = random.Random()

    async def call(name: str, args: tuple[Any, ...]) -> Any:
        left = lane.call_timeout
        until, following = time.monotonic() + left, pauses(draw)
        while True:
            try:
                return await lane.call(name, args, left)
            except (ConnectError, ConnectionLost) as exc:
                if call_kind(name) is not CallKind.READ or isinstance(exc, ProtocolError):
                    raise
                if not lane.is_open:
                    raise  # the robot was closed, or never opened
                if time.monotonic() + (pause := next(following)) >= until:
                    raise
            await anyio.sleep(pause)
            left = max(0.001, until - time.monotonic())

    return AsyncRpc(call)
