"""Lanes among threads: calls from other ones, threads that hang, loops that end."""

from __future__ import annotations

import asyncio
import signal
import socket
import threading
import time
from functools import partial
from typing import TYPE_CHECKING, Any

import anyio
import pytest

from aioduco._wire.lane import WireLane
from aioduco._wire.worker import Worker
from aioduco.errors import (
    ConnectError,
    ConnectionLost,
    NotSent,
    OutcomeUnknown,
)
from aioduco.testing import eventually, eventually_async, no_leaks

from .lanes import SHORT, Gate, opened
from .servers import PATIENCE, ScriptedServer, honest

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.handoff import Call

# From other threads


@pytest.fixture
def background() -> Any:
    """Run something on a thread; its outcome when it has ended."""
    threads = []

    def start(work: Callable[[], Any]) -> Callable[[], Any]:
        outcome: list[Any] = []

        def run() -> None:
            try:
                outcome.append(work())
            except Exception as exc:
                outcome.append(exc)

        thread = threading.Thread(target=run)
        threads.append(thread)
        thread.start()

        def result() -> Any:
            thread.join(PATIENCE)
            assert not thread.is_alive()
            return outcome[0]

        return result

    yield start
    for thread in threads:
        thread.join(PATIENCE)


async def test_a_thread_calls_while_the_loop_is_blocked(background: Any) -> None:
    async with opened() as (lane, server):
        result = background(partial(lane.call_from_thread, "stop", (True,), PATIENCE))
        # blocks the loop
        assert result() == 0
        assert server.connections == 1
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


async def test_calls_wait_for_a_connection_that_a_thread_has(background: Any) -> None:
    gate = Gate()
    async with opened(gate) as (lane, server):
        call = partial(lane.call_from_thread, "get_noneblock_taskstate", (5,), PATIENCE)
        result = background(call)
        server.wait_calls(1)
        async with anyio.create_task_group() as group:
            group.start_soon(lane.rpc.get_noneblock_taskstate, 6)
            await eventually_async(lambda: lane.statistics().waiting == 1)
            gate.open()
        assert result() == 5
        assert server.connections == 1


async def test_a_stop_that_is_not_answered_is_sent_on_another_connection(background: Any) -> None:
    gate = Gate()
    async with opened(gate, honest) as (lane, server):
        result = background(partial(lane.call_from_thread, "stop", (True,), PATIENCE))
        assert result() == 0
        assert server.names == ["stop", "stop"]
        assert server.connections == 2
        gate.open()
        await eventually_async(lambda: lane.statistics().busy == 0)


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
    async with opened(gate, honest) as (lane, server):
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
        assert server.names == ["get_noneblock_taskstate", "stop"]


@pytest.mark.parametrize("error", [ValueError, RuntimeError, ConnectionLost, KeyboardInterrupt])
@pytest.mark.parametrize("blocking", [True, False])
@pytest.mark.parametrize("submitted", [True, False])
async def test_what_a_signal_handler_raises_leaves_no_connection_claimed(
    monkeypatch: pytest.MonkeyPatch, error: type[BaseException], blocking: bool, submitted: bool
) -> None:
    submit = Worker.submit

    def interrupted(worker: Worker, call: Call) -> None:
        if submitted:
            submit(worker, call)
        raise error("by a signal handler")

    async with opened() as (lane, server):

        async def pause() -> int:
            if blocking:
                answer: int = lane.call_from_thread("pause", (True,), PATIENCE)
                return answer
            return await lane.rpc.pause(True)

        with monkeypatch.context() as patched:
            patched.setattr(Worker, "submit", interrupted)
            with pytest.raises(error, match="by a signal handler"):
                await pause()
        for _ in range(2):
            assert lane.call_from_thread("stop", (True,), PATIENCE) == 0
            assert await lane.rpc.stop(True) == 0
        # A call that was not handed over is not sent, and one that was is not sent again.
        assert [name for name in server.names if name != "stop"] in ([], ["pause"] * submitted)
        assert lane.statistics().busy == 0


async def test_a_stop_that_fails_waits_for_no_lock_of_other_calls(background: Any) -> None:
    async with opened(honest) as (lane, server):
        (worker,) = lane._pool.workers
        other = object()
        assert worker.claim(other)  # so the stop needs a connection of its own
        server.stop_listening()
        with worker._lock:
            failed = background(partial(lane.call_from_thread, "stop", (True,), PATIENCE))()
        assert isinstance(failed, ConnectError)
        worker._claims.clear()


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


# Threads that hang, loops that end


async def test_no_await_outlives_its_deadline_when_a_thread_hangs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Resolving a name cannot be interrupted, and can take half a minute."""
    go_on = threading.Event()
    resolve = socket.getaddrinfo
    hanging = []

    def slow(*args: Any, **options: Any) -> Any:
        if not go_on.is_set() and threading.current_thread().name.startswith("aioduco"):
            hanging.append(threading.current_thread())
            assert go_on.wait(PATIENCE)
        return resolve(*args, **options)

    async with opened() as (lane, server):
        connection = lane._pool.workers[0].connection
        assert connection is not None
        connection.abandon("for the test")
        monkeypatch.setattr(socket, "getaddrinfo", slow)
        begin = time.monotonic()
        with pytest.raises(NotSent, match="pause was not sent"):
            await lane.call("pause", (True,), 5 * SHORT)
        assert time.monotonic() - begin < PATIENCE  # not until the name is found
        assert [thread.is_alive() for thread in hanging] == [True]
        # others are not held up by it
        go_on.set()
        assert await lane.rpc.resume(True) == 0
        # and it sends nothing when it comes back
        await eventually_async(lambda: not hanging[0].is_alive())
        assert server.names == ["resume"]
        assert lane.statistics().stuck == 0


@pytest.mark.slow
async def test_threads_that_hang_are_limited_and_do_not_hold_up_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    go_on = threading.Event()

    def slow(*_: Any, **__: Any) -> Any:
        assert go_on.wait(PATIENCE)
        raise OSError

    with ScriptedServer() as server:
        lane = WireLane("test", server.host, server.port)
        await lane.open()
        connection = lane._pool.workers[0].connection
        assert connection is not None
        connection.abandon("for the test")
        monkeypatch.setattr(socket, "getaddrinfo", slow)
        before = threading.active_count()
        async with no_leaks():
            for _ in range(8):
                with pytest.raises(NotSent):
                    await lane.call("pause", (True,), 0.01)
            assert threading.active_count() <= before + 4
            errors: list[BaseException] = []

            async def for_ever() -> None:
                try:
                    await lane.call("pause", (True,), None)
                except ConnectionLost as exc:
                    errors.append(exc)

            async with anyio.create_task_group() as group:
                group.start_soon(for_ever)
                await eventually_async(lambda: lane.statistics().calls == 9)
                await lane.aclose()
            assert len(errors) == 1
            assert server.calls == []
            go_on.set()


async def test_closing_ends_a_call_whose_thread_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    go_on = threading.Event()
    hangs = threading.Event()

    def slow(*_: Any, **__: Any) -> Any:
        hangs.set()
        assert go_on.wait(PATIENCE)
        raise OSError

    errors: list[BaseException] = []

    async def for_ever() -> None:
        try:
            await lane.call("pause", (True,), None)
        except ConnectionLost as exc:
            errors.append(exc)

    async with no_leaks():
        with ScriptedServer() as server:
            lane = WireLane("test", server.host, server.port)
            await lane.open()
            connection = lane._pool.workers[0].connection
            assert connection is not None
            connection.abandon("for the test")
            monkeypatch.setattr(socket, "getaddrinfo", slow)
            async with anyio.create_task_group() as group:
                group.start_soon(for_ever)
                await eventually_async(hangs.is_set)
                await lane.aclose()
                await eventually_async(lambda: len(errors) == 1)
            assert "did not come back" in str(errors[0])
            go_on.set()


def test_a_lane_survives_the_end_of_its_loop() -> None:
    with no_leaks(), ScriptedServer() as server:
        lane = WireLane("test", server.host, server.port)

        async def first() -> None:
            await lane.open()
            await lane.rpc.stop(True)

        asyncio.run(first())

        async def second() -> None:
            assert await lane.rpc.get_noneblock_taskstate(1) == 0
            with pytest.raises(NotSent):
                await lane.call("stop", (True,), 0.0)
            await lane.aclose()

        asyncio.run(second())
        assert server.connections == 1


def test_a_thread_outlives_a_loop_that_ends_in_mid_call() -> None:
    gate = Gate()
    with no_leaks(), ScriptedServer(gate) as server:
        lane = WireLane("test", server.host, server.port)
        loop = asyncio.new_event_loop()
        loop.run_until_complete(lane.open())
        task = loop.create_task(lane.within(None).pause(True))
        loop.call_soon(loop.stop)
        loop.run_forever()
        server.wait_calls(1)
        # a loop that is thrown away with a task on it, which nobody ever cancels
        loop.close()
        gate.open()
        eventually(lambda: lane.statistics().busy == 0)

        async def again() -> None:
            assert await lane.rpc.stop(True) == 0
            await lane.aclose()

        asyncio.run(again())
        assert server.names == ["pause", "stop"]
        assert server.connections == 1
        task._log_destroy_pending = False  # type: ignore[attr-defined]  # it is what is tested
