"""Calls from threads and signal handlers never wait for the event loop."""

from __future__ import annotations

import signal
import threading
import time
from functools import partial
from typing import Any

import anyio
import pytest

from aioduco._wire.lane import WireLane
from aioduco.errors import ConnectionLost, OutcomeUnknown
from aioduco.testing import eventually_async

from .lanes import SHORT, Gate, opened
from .names import NAME, Names
from .servers import PATIENCE, Peer, ScriptedServer, held, honest

# From other threads


async def test_a_thread_calls_while_the_loop_is_blocked(background: Any) -> None:
    async with opened() as (lane, server):
        result = background(partial(lane.call_from_thread, "stop", (True,), PATIENCE))
        # blocks the loop
        assert result() == 0
        assert server.connections == 2
        assert await lane.rpc.get_robot_version() == "3.8"


async def test_a_call_from_a_thread_waits_behind_nothing(background: Any) -> None:
    gate = Gate()
    async with opened(gate, honest) as (lane, server), anyio.create_task_group() as group:
        group.start_soon(lane.within(None).pause, True)
        await eventually_async(lambda: len(server.calls) == 1)
        call = partial(lane.call_from_thread, "get_robot_version", (), PATIENCE)
        assert background(call)() == "3.8"
        assert server.connections == 2
        gate.open()


async def test_a_stop_that_is_not_answered_is_sent_on_another_connection(background: Any) -> None:
    gate = Gate()
    async with opened(honest, gate, honest) as (lane, server):
        result = background(partial(lane.call_from_thread, "stop", (True,), PATIENCE))
        assert result() == 0
        assert server.names == ["stop", "stop"]
        assert server.connections == 3
        gate.open()


async def test_a_stop_that_nobody_answers_is_unknown(background: Any) -> None:
    gate = Gate()
    async with opened(gate) as (lane, server):
        result = background(partial(lane.call_from_thread, "stop", (True,), 3 * SHORT))
        assert isinstance(result(), OutcomeUnknown)
        assert server.names == ["stop", "stop"]
        gate.open()


@pytest.mark.parametrize(
    ("name", "args", "error"),
    [("get_tcp_pose", (), ConnectionLost), ("pause", (True,), OutcomeUnknown)],
)
async def test_a_call_from_a_thread_keeps_its_deadline(
    background: Any, name: str, args: tuple[Any, ...], error: type[Exception]
) -> None:
    gate = Gate()
    async with opened(honest, gate) as (lane, server):
        assert isinstance(background(partial(lane.call_from_thread, name, args, SHORT))(), error)
        gate.open()
        assert await lane.rpc.stop(True) == 0
        assert server.names == [name, "stop"]
        assert lane.statistics().failed == 1


async def test_a_signal_handler_stops_in_the_middle_of_a_call() -> None:
    """The handler runs on the loop's own thread, between two of its instructions."""
    gate = Gate()
    stopped = []
    async with opened(gate, honest) as (lane, server):

        def handler(*_: object) -> None:
            stopped.append(lane.call_from_thread("stop", (True,), PATIENCE))

        before = signal.signal(signal.SIGUSR1, handler)
        try:
            async with anyio.create_task_group() as group:
                group.start_soon(lane.within(None).get_noneblock_taskstate, 1)
                await eventually_async(lambda: len(server.calls) == 1)
                signal.raise_signal(signal.SIGUSR1)
                assert stopped == [0]
                gate.open()
        finally:
            signal.signal(signal.SIGUSR1, before)
        first, *others = server.names
        # once more if its answer took longer than 0.1 s
        assert (first, {*others}) == ("get_noneblock_taskstate", {"stop"})


@pytest.mark.slow
async def test_signals_at_random_moments_of_busy_calls() -> None:
    """Neither side ever waits for the other for long: no lock is shared that could be held."""
    stops = within = 0
    async with opened(size=2, call_timeout=PATIENCE) as (lane, server):
        slowest = 0.0

        def handler(*_: object) -> None:
            nonlocal stops, within, slowest
            if within == 3 or stops >= 50:
                return  # a busy machine takes longer over a stop than to the next signal
            within += 1
            begin = time.monotonic()
            try:
                assert lane.call_from_thread("stop", (True,), PATIENCE) == 0
            finally:
                within -= 1
            slowest = max(slowest, time.monotonic() - begin)
            stops += 1

        before = signal.signal(signal.SIGALRM, handler)
        signal.setitimer(signal.ITIMER_REAL, 0.003, 0.0031)
        try:
            while stops < 50:
                async with anyio.create_task_group() as group:
                    for number in range(3):
                        group.start_soon(lane.rpc.get_noneblock_taskstate, number)
                    group.start_soon(lane.rpc.get_robot_version)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, before)
        assert server.names.count("stop") >= 50
        assert slowest < PATIENCE / 2


# The spare connection


async def test_a_spare_connection_is_there_before_it_is_needed(background: Any) -> None:
    async with opened(spare=True) as (lane, server):
        server.wait_for(lambda: server.connections == 2)
        server.stop_listening()
        # no other connection could be made now
        for _ in range(3):
            assert background(partial(lane.call_from_thread, "stop", (True,), PATIENCE))() == 0
        assert server.connections == lane.statistics().opened == 2


async def test_a_spare_connection_that_was_lost_costs_no_stop(background: Any) -> None:
    async with opened(honest, Peer.close, honest, spare=True) as (lane, server):
        server.wait_finished(1)
        stop = partial(lane.call_from_thread, "stop", (True,), PATIENCE)
        assert background(stop)() == 0
        assert background(stop)() == 0
        assert (server.names, server.connections) == (["stop", "stop"], 3)


async def test_threads_that_call_at_once_have_a_connection_each(background: Any) -> None:
    gate = Gate()
    async with opened(honest, gate, spare=True) as (lane, server):
        call = partial(lane.call_from_thread, "get_noneblock_taskstate", (7,), PATIENCE)
        results = [background(call) for _ in range(3)]
        server.wait_calls(3)
        assert server.connections == 4
        gate.open()
        assert [result() for result in results] == [7, 7, 7]
        # one of them is kept, and no more
        await eventually_async(lambda: server.connections - server.finished == 2)


async def test_a_stop_whose_second_connection_is_refused_has_the_first_answer(
    background: Any,
) -> None:
    late = threading.Event()

    async with opened(honest, held(late), spare=True) as (lane, server):
        server.wait_for(lambda: server.connections == 2)
        server.stop_listening()
        refused = server.connections
        result = background(partial(lane.call_from_thread, "stop", (True,), PATIENCE))
        server.wait_calls(1)
        late.set()
        assert result() == 0
        assert server.connections == refused


async def test_a_name_is_not_resolved_again_for_a_call_from_a_thread(
    background: Any, names: Names
) -> None:
    """A signal handler must not wait for a name server."""
    with ScriptedServer() as server:
        names.addresses = [(server.host, server.port)]
        lane = WireLane("test", NAME, server.port, connect_timeout=PATIENCE)
        await lane.open()
        assert names.asked == 1
        assert background(partial(lane.call_from_thread, "stop", (True,), PATIENCE))() == 0
        assert names.asked == 1
        await lane.aclose()
