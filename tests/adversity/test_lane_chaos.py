"""Many callers on lanes, through a proxy that injects every kind of fault."""

from __future__ import annotations

import random
import threading
from collections import Counter
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from functools import partial

import anyio
import pytest

from aioduco._wire.lane import WireLane
from aioduco.testing import Chaos, Ending, FaultProxy, RecordingServer, eventually_async, no_leaks

from .calls import ANSWERS, METHODS, Call, CallRecords, Lag, make
from .conftest import PARTS
from .menu import MENU

CALLERS = 12


class Storm:
    """Callers, cancellations, and blows at all connections at once, until there were enough."""

    def __init__(self, proxy: FaultProxy, faults: int, seed: str) -> None:
        self.proxy = proxy
        self.faults = faults
        self.seed = seed
        self.all_records: list[CallRecords] = []

    @property
    def over(self) -> bool:
        return self.proxy.statistics().faults >= self.faults

    def _records(self, who: str) -> tuple[CallRecords, random.Random]:
        rng = random.Random(f"{self.seed}/{who}")
        records = CallRecords(rng)
        self.all_records.append(records)
        return records, rng

    async def caller(self, lane: WireLane, number: int) -> None:
        records, rng = self._records(f"caller {number}")
        while not self.over:
            call = make(rng.choice(METHODS))
            timeout = rng.choice([0.005, 0.01, 0.02, 0.05])
            cancel_after = rng.uniform(0.0, 0.015) if rng.random() < 0.2 else None
            await records.follow(call, lane.call, timeout, cancel_after)

    async def stopper(self, lane: WireLane) -> None:
        """A stop is never told "it may have been done" without a try at a second one."""
        records, rng = self._records("stopper")
        while not self.over:
            call = Call(0, "stop", (True,), 0)
            await records.follow(call, lane.call, rng.choice([0.01, 0.05]))

    @contextmanager
    def thread(self, lane: WireLane) -> Iterator[None]:
        """While the block runs, a plain thread calls too."""
        records, rng = self._records("thread")
        ended = threading.Event()

        def work() -> None:
            while not ended.is_set():
                records.follow_blocking(make(rng.choice(METHODS)), lane.call_from_thread, 0.02)

        thread = threading.Thread(target=work, name="caller")
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()

    async def blows(self) -> None:
        _, rng = self._records("blows")
        due = anyio.current_time()
        while True:
            due = max(due + rng.uniform(0.02, 0.2), anyio.current_time())
            await anyio.sleep_until(due)
            match rng.randrange(4):
                case 0:
                    self.proxy.cut(Ending.RESET)
                case 1:
                    self.proxy.cut(Ending.CLOSE)
                case 2:
                    self.proxy.refuse()
                    await anyio.sleep_until(due + rng.uniform(0.001, 0.02))
                    self.proxy.accept()
                case _:
                    self.proxy.freeze()
                    await anyio.sleep_until(due + rng.uniform(0.001, 0.02))
                    self.proxy.thaw()


@pytest.mark.parametrize("part", range(PARTS))
async def test_every_call_has_its_own_answer_or_a_true_error(
    part: int, faults: int, seed: int, totals: Counter[str]
) -> None:
    async with (
        no_leaks(),
        Lag() as lag,
        RecordingServer(ANSWERS) as server,
        FaultProxy(server.host, server.port, seed=seed) as proxy,
        opened(WireLane("call", proxy.host, proxy.port, size=4)) as pool,
        opened(WireLane("control", proxy.host, proxy.port)) as control,
    ):
        proxy.schedule(Chaos(seed * 1000 + part, MENU, rate=0.8))
        storm = Storm(proxy, faults, f"{seed}/{part}")
        async with anyio.create_task_group() as group:
            group.start_soon(storm.blows)
            with storm.thread(pool):
                async with anyio.create_task_group() as callers:
                    for number in range(CALLERS):
                        callers.start_soon(storm.caller, pool, number)
                    callers.start_soon(storm.stopper, control)
            group.cancel_scope.cancel()
        proxy.clear()
        await calm(pool)
        await calm(control)
        await pool.aclose()
        await control.aclose()
        await eventually_async(partial(quiet, proxy, server))
        totals["faults"] += proxy.statistics().faults
        totals["calls"] += proxy.statistics().calls
        totals["connections"] += proxy.statistics().connections
        for records in storm.all_records:
            totals.update(records.outcomes)
            records.check(server, lag)


@asynccontextmanager
async def opened(lane: WireLane) -> AsyncIterator[WireLane]:
    await lane.open()
    try:
        yield lane
    finally:
        await lane.aclose()


async def calm(lane: WireLane) -> None:
    """When the faults are over the lane works again, at once and for good."""
    for _ in range(10):
        call = make("get_system_value_double")
        assert await lane.call(call.method, call.args, 2.0) == call.answer


def quiet(proxy: FaultProxy, server: RecordingServer) -> bool:
    """Nothing is on its way to the server any more."""
    return proxy.statistics().open == 0 and server.connections == 0
