"""Lanes of these tests, and what holds their server back."""

from __future__ import annotations

import threading
from collections.abc import AsyncIterator, Awaitable
from contextlib import asynccontextmanager
from typing import Any

from aioduco._wire.channel import Channel
from aioduco._wire.lane import WireLane
from aioduco.testing import no_leaks

from .servers import PATIENCE, Peer, Script, ScriptedServer

#: seconds after which a server that says nothing is given up
SHORT = 0.1


@asynccontextmanager
async def opened(
    *scripts: Script, **options: Any
) -> AsyncIterator[tuple[WireLane, ScriptedServer]]:
    """A lane and its server; when they are closed, nothing is left of either.

    It connects as late as a busy machine does; a test about that time gives it.
    """
    options.setdefault("connect_timeout", PATIENCE)
    async with no_leaks():
        with ScriptedServer(*scripts) as server:
            lane = WireLane("test", server.host, server.port, **options)
            await lane.open()
            try:
                yield lane, server
            finally:
                await lane.aclose()


def channel(lane: WireLane) -> Channel:
    """The lane's first connection."""
    first = lane._carriers[0]
    assert isinstance(first, Channel)
    return first


def own_threads() -> list[str]:
    """Names of the package's threads."""
    return [one.name for one in threading.enumerate() if one.name.startswith("aioduco")]


async def noted(
    raised: list[BaseException], kind: type[BaseException], call: Awaitable[object]
) -> None:
    """Await a call; an error of this kind is noted."""
    try:
        await call
    except kind as exc:
        raised.append(exc)


class Gate:
    """A script that holds every answer back until it is opened."""

    def __init__(self) -> None:
        self._open = threading.Event()

    def __call__(self, peer: Peer) -> None:
        while (call := peer.receive()) is not None:
            assert self._open.wait(PATIENCE)
            peer.answer(call, call.args[0] if call.name == "get_noneblock_taskstate" else None)

    def open(self) -> None:
        self._open.set()
