"""A lane that is cancelled at any of its awaits stays usable, and closes at once."""

from __future__ import annotations

import random
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from aioduco._wire.lane import WireLane
from aioduco.testing import (
    Cancelled,
    Delay,
    FaultProxy,
    RecordingServer,
    cancel_at_every_await,
    eventually_async,
    no_leaks,
)
from aioduco.testing.cancel import How

from .calls import ANSWERS, METHODS, CallRecords, make


@asynccontextmanager
async def proxied() -> AsyncIterator[tuple[RecordingServer, FaultProxy]]:
    """A server behind a proxy that answers so late that each call is awaited for a while."""
    async with (
        no_leaks(),
        RecordingServer(ANSWERS) as server,
        FaultProxy(server.host, server.port) as proxy,
    ):
        for method in METHODS:
            proxy.on(method, Delay(reply=0.005), times=None)
        yield server, proxy


@pytest.mark.parametrize("how", ["scope", "task"])
@pytest.mark.parametrize("again", [0, 2])
async def test_every_await_of_a_lane(how: How, again: int) -> None:
    async with proxied() as (server, proxy):
        records = CallRecords(random.Random(0))
        through = False

        async def program() -> None:
            nonlocal through
            through = False
            lane = WireLane("call", proxy.host, proxy.port, size=2)
            try:
                await lane.open()
                for method in METHODS:
                    await records.follow(make(method), lane.call, 5.0)
                through = True
            finally:
                await lane.aclose()

        async def check(run: Cancelled) -> None:
            assert run.error is None
            # a scope cannot cancel what is shielded: a lane that closes
            assert through or run.ended == "cancelled"
            await eventually_async(lambda: proxy.statistics().open == server.connections == 0)

        assert await cancel_at_every_await(program, check, how=how, again=again) > len(METHODS)
        records.check(server)
