"""A stop from a signal handler, at any line of the program."""

from __future__ import annotations

import random
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

import anyio
import pytest
from client.bench import HOME, Bench

import aioduco
from aioduco._wire.lane import WireLane
from aioduco.errors import TaskStopped
from aioduco.supervision.settings import GuardKind
from aioduco.testing import FaultProxy, RecordingServer, no_leaks

from .calls import ANSWERS, METHODS, Call, CallRecords, Lag, make
from .guards import BOTH
from .test_lane_chaos import opened

STOPS = 400
#: s in which a stop is answered, also by a busy machine
PATIENCE = 10.0
#: stops of a robot
NOW = 80


@contextmanager
def interrupting(handler: Callable[[int, FrameType | None], None], every: float) -> Iterator[None]:
    """While the block runs, the handler interrupts the main thread wherever it is.

    The next interrupt is `every` seconds after the end of the last one: a busy machine has time for
    what is interrupted.
    """
    over = False

    def interrupt(signum: int, frame: FrameType | None) -> None:
        try:
            handler(signum, frame)
        finally:
            if not over:
                signal.setitimer(signal.ITIMER_REAL, every)

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, every)
    try:
        yield
    finally:
        over = True
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.slow
async def test_a_stop_from_a_signal_handler_is_answered_wherever_it_interrupts(seed: int) -> None:
    async with (
        no_leaks(),
        Lag() as lag,
        RecordingServer(ANSWERS) as server,
        FaultProxy(server.host, server.port) as proxy,
        opened(WireLane("call", proxy.host, proxy.port, size=3)) as pool,
        opened(WireLane("control", proxy.host, proxy.port)) as control,
    ):
        rng = random.Random(seed)
        stops = CallRecords(rng)
        all_records = [CallRecords(rng) for _ in range(4)]

        def stop(signum: int, frame: FrameType | None) -> None:
            # on the pool, and while the same lane is in the middle of something, too
            lane = rng.choice([pool, control])
            stops.follow_blocking(Call(0, "stop", (True,), 0), lane.call_from_thread, PATIENCE)

        async def caller(records: CallRecords) -> None:
            while sum(stops.outcomes.values()) < STOPS:
                lane = rng.choice([pool, pool, control])
                cancel_after = rng.uniform(0.0, 0.002) if rng.random() < 0.3 else None
                await records.follow(make(rng.choice(METHODS)), lane.call, 2.0, cancel_after)

        with interrupting(stop, every=0.0023):
            async with anyio.create_task_group() as callers:
                for records in all_records:
                    callers.start_soon(caller, records)
        await pool.aclose()
        await control.aclose()
        assert stops.outcomes == {"answered": sum(stops.outcomes.values())}
        for records in (stops, *all_records):
            records.check(server, lag)


@pytest.mark.slow
@BOTH
async def test_stop_now_from_a_signal_handler_of_a_busy_program(guard: GuardKind | None) -> None:
    async with no_leaks():
        with Bench() as bench:
            async with aioduco.connect(bench.host, bench.port, guard=guard) as robot:
                stopped = 0

                def stop(signum: int, frame: FrameType | None) -> None:
                    nonlocal stopped
                    robot.stop_now()
                    stopped += 1

                async def read() -> None:
                    while stopped < NOW:
                        await robot.io.get_standard_digital_out(1)

                async def move() -> None:
                    while stopped < NOW:
                        # stopped meanwhile, or before it was sent
                        with suppress(TaskStopped):
                            await robot.motion.movej2(HOME, v=1.0, a=1.0)

                with interrupting(stop, every=0.005):
                    async with anyio.create_task_group() as tasks:
                        tasks.start_soon(read)
                        tasks.start_soon(read)
                        tasks.start_soon(move)
                assert robot.statistics().stops >= NOW
            assert len(bench.received("stop")) >= NOW
            assert not bench.moving()
