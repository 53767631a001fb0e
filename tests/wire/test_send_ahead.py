"""A call is on its way before the thread that owns its connection gets to run."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import contextmanager
from queue import SimpleQueue
from typing import TYPE_CHECKING

import anyio
import pytest

from aioduco._wire import codec, idl
from aioduco._wire.connection import Connection
from aioduco._wire.deadline_socket import DeadlineSocket
from aioduco._wire.lifecycle import ConnectionState, Progress
from aioduco._wire.worker import AbandonOutcome
from aioduco.errors import OutcomeUnknown
from aioduco.testing import eventually_async, no_leaks

from .lanes import Gate, opened
from .servers import PATIENCE, Peer, ScriptedServer, honest

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco._wire.lane import WireLane

STOP = idl.functions()["stop"]
BLOCK = codec.encode(STOP, (True,))


def test_the_owner_has_the_answer_to_what_another_thread_sent() -> None:
    with no_leaks(), ScriptedServer() as server:
        connection = Connection(server.host, server.port)
        connection.open()
        sent: list[bool] = []
        thread = threading.Thread(target=lambda: sent.append(ahead(connection)))
        thread.start()
        thread.join()
        server.wait_calls(1)  # without the owner
        assert sent == [True]
        assert connection.state is ConnectionState.ACTIVE
        assert connection.usable
        assert connection.exchange(STOP, BLOCK, None) == 0
        assert connection.rpc.stop(True) == 0
        assert server.names == ["stop", "stop"]
        figures = connection.statistics()
        assert (figures.calls, figures.answered) == (2, 2)
        connection.close()


def ahead(connection: Connection, deadline: float | None = None) -> bool:
    return connection.send_ahead(STOP, BLOCK, deadline)


def test_what_is_not_open_or_not_in_time_sends_nothing() -> None:
    with no_leaks(), ScriptedServer() as server:
        connection = Connection(server.host, server.port)
        assert not ahead(connection)
        connection.open()
        assert not ahead(connection, time.monotonic())
        assert connection.state is ConnectionState.IDLE
        connection.abandon()
        assert not ahead(connection)
        assert not connection.usable
        connection.close()
        assert server.calls == []


def test_the_connection_is_not_free_until_the_answer_is_there() -> None:
    gate = Gate()
    with no_leaks(), ScriptedServer(gate) as server:
        connection = Connection(server.host, server.port)
        connection.open()
        assert ahead(connection)
        assert not ahead(connection)
        connection.abandon()
        with pytest.raises(OutcomeUnknown):
            connection.exchange(STOP, BLOCK, None)
        assert connection.progress is Progress.SENT
        connection.close()
        gate.open()


@contextmanager
def unheard(lane: WireLane) -> Iterator[None]:
    """Keep what the lane's thread is given from it until the block is left."""
    (worker,) = lane._pool.workers
    inbox, worker._inbox = worker._inbox, SimpleQueue()
    yield
    kept, worker._inbox = worker._inbox, inbox
    while not kept.empty():
        inbox.put(kept.get())


async def test_an_awaited_stop_does_not_wait_for_the_lanes_thread() -> None:
    async with opened() as (lane, server), anyio.create_task_group() as tasks:
        with unheard(lane):
            tasks.start_soon(lane.rpc.stop, True)
            await eventually_async(lambda: server.names == ["stop"])


async def test_a_stop_from_a_thread_does_not_wait_for_the_lanes_thread() -> None:
    async with opened() as (lane, server):
        thread = threading.Thread(target=lane.call_from_thread, args=("stop", (True,), PATIENCE))
        with unheard(lane):
            thread.start()
            await eventually_async(lambda: server.names[:1] == ["stop"])
        await eventually_async(lambda: not thread.is_alive())


async def test_an_awaited_command_does_not_wait_for_the_lanes_thread() -> None:
    async with opened() as (lane, server), anyio.create_task_group() as tasks:
        with unheard(lane):
            tasks.start_soon(lane.rpc.pause, True)
            await eventually_async(lambda: server.names == ["pause"])


async def test_a_command_on_a_closed_connection_is_left_to_the_lanes_thread() -> None:
    """It was not sent, so it is sent once, on another connection."""

    def closing(peer: Peer) -> None:
        peer.sock.shutdown(socket.SHUT_RDWR)

    async with opened(closing, honest) as (lane, server):
        (worker,) = lane._pool.workers
        assert worker.connection is not None
        stream = worker.connection._stream
        assert stream is not None
        await eventually_async(lambda: not stream.silent)
        assert await lane.rpc.pause(True) == 0
        assert (server.names, server.connections) == (["pause"], 2)


async def test_a_stop_that_was_sent_is_not_called_unsent() -> None:
    gate = Gate()
    async with opened(gate, honest) as (lane, server):
        with anyio.move_on_after(PATIENCE) as scope:
            async with anyio.create_task_group() as tasks:
                with unheard(lane):
                    tasks.start_soon(lane.rpc.stop, True)
                    await eventually_async(lambda: server.names == ["stop"])
                    (worker,) = lane._pool.workers
                    assert worker.abandon(None, "a test") is AbandonOutcome.UNKNOWN
                    scope.cancel()
        gate.open()
        assert await lane.rpc.stop(True) == 0
        assert server.names == ["stop", "stop"]


@pytest.mark.parametrize("taken", [-1, 0, 5])
async def test_a_connection_that_does_not_take_it_at_once_is_replaced(
    monkeypatch: pytest.MonkeyPatch, taken: int
) -> None:
    async with opened() as (lane, server):
        monkeypatch.setattr(DeadlineSocket, "send_at_once", lambda *_: taken)
        assert await lane.rpc.stop(True) == 0
        assert server.names == ["stop"]
        assert server.connections == 2


async def test_a_stop_survives_a_connection_that_the_other_side_closed() -> None:
    def closed(peer: Peer) -> None:
        peer.receive()

    async with opened(closed, honest) as (lane, server):
        assert await lane.rpc.stop(True) == 0
        assert server.connections == 2
