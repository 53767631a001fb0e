"""Lanes: who gets a connection when, from which thread, and what is left when it is over."""

from __future__ import annotations

import asyncio
import gc
import signal
import socket
import threading
import time
import weakref
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

import anyio
import pytest

from aioduco._wire.lane import Lane, LaneState
from aioduco._wire.lifecycle import ConnectionState
from aioduco.errors import (
    ConnectError,
    ConnectionLost,
    ControllerError,
    NotSent,
    OutcomeUnknown,
    ParameterError,
)
from aioduco.testing import eventually, eventually_async, no_leaks
from aioduco.trace import CallFinished, ConnectionEnded, ConnectionOpened, Event

from .servers import PATIENCE, Peer, ScriptedServer, black_hole, exception, honest

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    Script = Callable[[Peer], None]

SHORT = 0.1


@asynccontextmanager
async def opened(*scripts: Script, **options: Any) -> AsyncIterator[tuple[Lane, ScriptedServer]]:
    async with no_leaks():
        with ScriptedServer(*scripts) as server:
            lane = Lane("test", server.host, server.port, **options)
            await lane.open()
            try:
                yield lane, server
            finally:
                await lane.aclose()


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


# Life


async def test_states_and_repr_of_a_life() -> None:
    async with no_leaks():
        with ScriptedServer() as server:
            lane = Lane("poll", server.host, server.port, size=2)
            address = f"{server.host}:{server.port}"
            assert repr(lane) == f"<Lane poll {address} NEW, 0 of 2 busy, 0 waiting>"
            with pytest.raises(ConnectionLost, match=r"stop was not sent, since <Lane .* NEW"):
                await lane.rpc.stop(True)
            await lane.open()
            assert repr(lane) == f"<Lane poll {address} OPEN, 0 of 2 busy, 0 waiting>"
            with pytest.raises(RuntimeError, match="once"):
                await lane.open()
            assert await lane.rpc.stop(True) == 0
            await lane.aclose()
            await lane.aclose()
            assert repr(lane) == f"<Lane poll {address} CLOSED, 0 of 2 busy, 0 waiting>"
            with pytest.raises(ConnectionLost, match=r"stop was not sent, since <Lane .* CLOSED"):
                await lane.rpc.stop(True)
            with pytest.raises(ConnectionLost, match="CLOSED"):
                lane.call_from_thread("stop", (True,), PATIENCE)
            assert server.names == ["stop"]


async def test_one_connection_is_open_at_once_and_the_others_when_they_are_needed() -> None:
    gate = Gate()
    async with opened(gate, size=3) as (lane, server):
        server.wait_for(lambda: server.connections == 1)
        assert lane.statistics().opened == 1
        async with anyio.create_task_group() as group:
            for number in range(5):
                group.start_soon(lane.rpc.get_noneblock_taskstate, number)
            await eventually_async(lambda: len(server.calls) == 3)
            assert lane.statistics()._replace(calls=0) == (0, 0, 2, 3, 3, 3, 0, 0)
            assert repr(lane).endswith("3 of 3 busy, 2 waiting>")
            gate.open()
        figures = lane.statistics()
        assert figures.calls == 5
        assert figures.workers == figures.opened == server.connections == 3
        assert figures.waiting == figures.busy == 0


async def test_calls_on_one_connection_keep_their_order() -> None:
    gate = Gate()
    answers = []

    async def call(number: int) -> None:
        answers.append(await lane.rpc.get_noneblock_taskstate(number))

    async with opened(gate) as (lane, server):
        async with anyio.create_task_group() as group:
            for number in range(20):
                group.start_soon(call, number)
            await eventually_async(lambda: lane.statistics().waiting == 19)
            gate.open()
        assert answers == list(range(20))
        assert [call.args[0] for call in server.calls] == list(range(20))
        assert server.connections == 1


async def test_a_lane_that_cannot_open_leaves_nothing() -> None:
    with socket.create_server(("127.0.0.1", 0)) as closed:
        host, port = closed.getsockname()
    async with no_leaks():
        lane = Lane("test", host, port)
        with pytest.raises(ConnectError, match="refused"):
            await lane.open()
        assert lane.state is LaneState.CLOSED


async def test_a_lane_whose_controller_does_not_answer_the_handshake() -> None:
    with black_hole() as (host, port):
        async with no_leaks():
            lane = Lane("test", host, port, connect_timeout=SHORT)
            with pytest.raises(ConnectError, match="no answer in time"):
                await lane.open()


async def test_a_lane_left_open_warns_and_its_threads_end() -> None:
    with ScriptedServer() as server, no_leaks():
        lane = Lane("test", server.host, server.port)
        await lane.open()
        # the timer of the last deadline still knows the lane
        lane._deadlines.stop()
        there = weakref.ref(lane)
        del lane

        def gone() -> bool:
            gc.collect()
            return there() is None

        # the thread lets go of the last call in a moment
        with pytest.warns(ResourceWarning, match=r"unclosed <Lane test .* OPEN"):
            await eventually_async(gone)
        server.wait_finished(1)


async def test_closing_ends_calls_under_way_and_calls_that_wait() -> None:
    raised: dict[str, BaseException] = {}

    async def call(name: str, *args: Any) -> None:
        try:
            await lane.call(name, args, None)
        except ConnectionLost as exc:
            raised[name] = exc

    gate = Gate()
    async with opened(gate, size=2) as (lane, server), anyio.create_task_group() as group:
        group.start_soon(call, "get_global_speed")
        group.start_soon(call, "pause", True)
        await eventually_async(lambda: len(server.calls) == 2)
        group.start_soon(call, "resume", True)
        await eventually_async(lambda: lane.statistics().waiting == 1)
        await lane.aclose()
        await eventually_async(lambda: len(raised) == 3)
        gate.open()
    assert type(raised["get_global_speed"]) is ConnectionLost
    assert type(raised["pause"]) is OutcomeUnknown
    assert type(raised["resume"]) is ConnectionLost
    assert "resume was not sent, since its lane was closed" in str(raised["resume"])
    assert server.names.count("resume") == 0


# What calls raise


async def test_a_value_that_cannot_be_sent_takes_no_connection() -> None:
    async with opened() as (lane, server):
        with pytest.raises(ParameterError):
            await lane.rpc.get_noneblock_taskstate(2**40)
        assert lane.statistics().calls == 0
        assert server.calls == []


async def test_arguments_are_sent_as_they_were_when_the_call_began() -> None:
    gate = Gate()
    joints = [0.0] * 6
    async with opened(gate) as (lane, server):
        async with anyio.create_task_group() as group:
            group.start_soon(lane.rpc.pause, True)
            group.start_soon(lane.rpc.servoj, joints, 1.0, 1.0, False, 200.0, 25.0, 10.0, 1.0)
            await eventually_async(lambda: lane.statistics().waiting == 1)
            joints[0] = 99.0
            gate.open()
        assert server.calls[1].args[0] == [0.0] * 6


async def test_an_application_error_costs_no_connection_and_is_no_failure() -> None:
    def script(peer: Peer) -> None:
        call = peer.receive()
        assert call is not None
        peer.send(exception(call.raw, 6, "not simulated"))
        honest(peer)

    async with opened(script) as (lane, server):
        with pytest.raises(ControllerError, match="not simulated"):
            await lane.rpc.abort(True)
        await lane.rpc.stop(True)
        assert server.connections == 1
        assert lane.statistics().failed == 0


async def test_a_call_that_finds_no_free_connection_in_time_was_not_sent() -> None:
    gate = Gate()
    async with opened(gate) as (lane, server):
        async with anyio.create_task_group() as group:
            group.start_soon(lane.within(None).pause, True)
            await eventually_async(lambda: len(server.calls) == 1)
            with pytest.raises(NotSent, match=r"resume was not sent: no connection .* was free"):
                await lane.call("resume", (True,), SHORT)
            with pytest.raises(TimeoutError):
                await lane.within(SHORT).resume(True)
            assert lane.statistics().waiting == 0
            assert lane.statistics().failed == 2
            gate.open()
        assert server.names == ["pause"]
        assert await lane.rpc.stop(True) == 0
        assert server.connections == 1


async def test_functions_that_block_may_take_longer_than_the_lanes_limit() -> None:
    gate = Gate()
    async with opened(gate, call_timeout=SHORT) as (lane, server):
        async with anyio.create_task_group() as group:
            group.start_soon(lane.within(None).run_program, "weld", True)
            await eventually_async(lambda: len(server.calls) == 1)
            # longer than the lane's own limit: another call has timed out meanwhile
            with pytest.raises(NotSent):
                await lane.rpc.resume(True)
            gate.open()
        assert lane.statistics().failed == 1
        assert server.connections == 1


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


async def test_signals_at_random_moments_of_busy_calls() -> None:
    """Neither side ever waits for the other for long: no lock is shared that could be held."""
    stops = 0
    async with opened(size=2) as (lane, server):
        slowest = 0.0

        def handler(*_: object) -> None:
            nonlocal stops, slowest
            begin = time.monotonic()
            assert lane.call_from_thread("stop", (True,), PATIENCE) == 0
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
        assert time.monotonic() - begin < 2 * (5 * SHORT) + 0.5
        assert [thread.is_alive() for thread in hanging] == [True]
        # others are not held up by it
        go_on.set()
        assert await lane.rpc.resume(True) == 0
        # and it sends nothing when it comes back
        await eventually_async(lambda: not hanging[0].is_alive())
        assert server.names == ["resume"]
        assert lane.statistics().stuck == 0


async def test_threads_that_hang_are_limited_and_do_not_hold_up_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    go_on = threading.Event()

    def slow(*_: Any, **__: Any) -> Any:
        assert go_on.wait(PATIENCE)
        raise OSError

    with ScriptedServer() as server:
        lane = Lane("test", server.host, server.port)
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
            lane = Lane("test", server.host, server.port)
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
        lane = Lane("test", server.host, server.port)

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
        lane = Lane("test", server.host, server.port)
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


# The hook


async def test_the_hook_sees_connections_and_calls() -> None:
    seen: list[Event] = []

    def script(peer: Peer) -> None:
        for answer in (7, None):
            call = peer.receive()
            assert call is not None
            if answer is not None:
                peer.answer(call, answer)

    async with opened(script, honest, trace=seen.append) as (lane, server):
        await lane.rpc.get_noneblock_taskstate(3)
        with pytest.raises(OutcomeUnknown):
            await lane.rpc.pause(True)
        lane.call_from_thread("stop", (False,), PATIENCE)
        peer = (server.host, server.port)
    opened_first, first, second, third = seen[0], seen[1], seen[2], seen[3]
    assert isinstance(opened_first, ConnectionOpened)
    assert opened_first.peer == peer
    assert opened_first.duration >= 0.0
    assert isinstance(first, CallFinished)
    assert (first.lane, first.function, first.arguments, first.result, first.error) == (
        "test",
        "get_noneblock_taskstate",
        (3,),
        7,
        None,
    )
    assert 0.0 < first.duration <= first.at
    assert isinstance(second, ConnectionEnded)
    assert second.reason == "the controller closed the connection"
    assert isinstance(third, CallFinished)
    assert isinstance(third.error, OutcomeUnknown)
    functions = [event.function for event in seen if isinstance(event, CallFinished)]
    assert functions == ["get_noneblock_taskstate", "pause", "stop"]
    assert sum(isinstance(event, ConnectionOpened) for event in seen) == 2
    assert sum(isinstance(event, ConnectionEnded) for event in seen) == 2


async def test_a_hook_that_fails_disturbs_no_call(caplog: pytest.LogCaptureFixture) -> None:
    def hook(_: Event) -> None:
        raise ValueError("a mistake")

    async with opened(trace=hook) as (lane, _):
        assert await lane.rpc.stop(True) == 0
    assert "the trace hook failed" in caplog.text
    assert "a mistake" in caplog.text


async def test_the_connection_of_a_lane_belongs_to_its_thread() -> None:
    async with opened() as (lane, _):
        connection = lane._pool.workers[0].connection
        assert connection is not None
        assert connection.state is ConnectionState.IDLE
        with pytest.raises(RuntimeError, match="belongs to the thread"):
            connection.rpc.stop(True)
