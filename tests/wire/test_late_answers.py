"""Late, doubled, cut and foreign answers never reach a caller.

And what is sent again, and what never: a command is carried out at most once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import anyio
import pytest

from aioduco._wire.lane import WireLane
from aioduco._wire.lifecycle import ConnectionState, Progress
from aioduco._wire.messages import Message, MessageType
from aioduco.errors import (
    CallTimeout,
    ConnectError,
    ConnectionLost,
    NotSent,
    OutcomeUnknown,
    ProtocolError,
)
from aioduco.testing import eventually_async, no_leaks

from .lanes import SHORT, Gate, channel, noted, opened
from .servers import PATIENCE, Peer, Script, ScriptedServer, reply, silent

#: one function of each kind, with arguments
READ = ("get_noneblock_taskstate", (7,))
COMMAND = ("set_wobj_offset", ([0.0] * 6, True))
STOP = ("stop", (True,))
CONSUMING = ("read_raw_data_485", (4,))
ALL = [READ, COMMAND, STOP, CONSUMING]

each_kind = pytest.mark.parametrize("call", ALL, ids=[name for name, _ in ALL])


def numbered(peer: Peer) -> None:
    """Answer each task id by its double."""
    while (call := peer.receive()) is not None:
        answer = 2 * call.args[0] if call.name == READ[0] else None
        peer.answer(call, [1, 2] if call.name == CONSUMING[0] else answer)


# Late


@each_kind
async def test_a_late_answer_reaches_nobody(call: tuple[str, Any]) -> None:
    late = threading.Event()

    def tardy(peer: Peer) -> None:
        received = peer.take()
        assert late.wait(PATIENCE)
        peer.answer(received, [9] if received.name == CONSUMING[0] else 111)

    async with opened(tardy, numbered) as (lane, server):
        error = CallTimeout if call is READ else OutcomeUnknown
        with pytest.raises(error, match=call[0]):
            await lane.call(*call, SHORT)
        assert await lane.call(*READ, PATIENCE) == 14
        late.set()
        server.wait_finished(1)
        for number in range(5):
            assert await lane.call(READ[0], (number,), PATIENCE) == 2 * number
        assert server.names[0] == call[0]
        assert server.connections == 2


# Not its answer


def answer_of(name: str) -> Any:
    return [1] if name == CONSUMING[0] else 5


def of_another_call(raw: Message, step: int) -> bytes:
    return reply(Message(raw.kind, raw.name, raw.seqid + step, b""), answer_of(raw.name))


#: what comes in place of an answer to a call
FALSE: dict[str, Callable[[Message], bytes]] = {
    "wrong_sequence": lambda raw: of_another_call(raw, 1),
    "previous_sequence": lambda raw: of_another_call(raw, -1),
    "wrong_function": lambda raw: reply(Message(raw.kind, "pause", raw.seqid, b""), 0),
    "wrong_kind": lambda raw: Message(MessageType.CALL, raw.name, raw.seqid, b"\x00").encode(),
    "garbage": lambda _: bytes(range(200, 256)),
    "zeros": lambda _: bytes(64),
    "http": lambda _: b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n",
    "gigabytes": lambda raw: Message(
        MessageType.REPLY, raw.name, raw.seqid, b"\x0b\x00\x00\x7f\xff\xff\xff" + b"x" * 99
    ).encode(),
}


@each_kind
@pytest.mark.parametrize("false", FALSE)
async def test_what_is_not_its_answer_is_never_returned(false: str, call: tuple[str, Any]) -> None:
    def script(peer: Peer) -> None:
        peer.send(FALSE[false](peer.take().raw))
        assert peer.wait_gone()

    async with opened(script, numbered) as (lane, server):
        if call is STOP:
            # until it is sure: a second one, which is answered truly
            assert await lane.call(*call, PATIENCE) == 0
        else:
            error = ProtocolError if call is READ else OutcomeUnknown
            with pytest.raises(error, match="something else than its answer") as raised:
                await lane.call(*call, PATIENCE)
            assert raised.value.__cause__ is not None
        server.wait_finished(1)
        assert server.names == [call[0]] * (2 if call is STOP else 1)
        assert await lane.call(*READ, PATIENCE) == 14
        assert server.connections == 2


# Too much


async def test_a_doubled_answer_in_one_piece() -> None:
    def script(peer: Peer) -> None:
        call = peer.take()
        peer.send(2 * reply(call.raw, 5))
        assert peer.wait_gone()

    async with opened(script, numbered) as (lane, server):
        assert await lane.call(*READ, PATIENCE) == 5
        assert await lane.call(*COMMAND, PATIENCE) == 0
        assert server.connections == 2


def idle_connection_has_news(lane: WireLane) -> bool:
    """Whether the lane has seen that something came on its connection, or its end."""
    return channel(lane).life.state is ConnectionState.POISONED


# Ends


each_end = pytest.mark.parametrize("end", [Peer.close, Peer.reset], ids=lambda end: end.__name__)


@each_kind
@pytest.mark.parametrize("event", ["close", "reset", "bytes"])
async def test_what_comes_while_a_connection_idles_costs_no_call(
    event: str, call: tuple[str, Any]
) -> None:
    """Even a command is sent on a fresh connection: nothing of it had left."""
    now = threading.Event()

    def script(peer: Peer) -> None:
        received = peer.take()
        peer.answer(received, 5)
        now.wait(PATIENCE)
        if event == "bytes":  # that nobody asked for
            peer.answer(received, 5)
            assert peer.wait_gone()
        else:
            getattr(peer, event)()

    async with opened(script, numbered) as (lane, server):
        assert await lane.call(*READ, PATIENCE) == 5
        now.set()
        await eventually_async(lambda: idle_connection_has_news(lane))
        await lane.call(*call, PATIENCE)
        assert server.names == [READ[0], call[0]]
        assert server.connections == 2


@each_kind
@each_end
async def test_a_connection_that_ends_before_the_answer(end: Script, call: tuple[str, Any]) -> None:
    """What only reads, and stop, is sent once more; a command never."""

    def script(peer: Peer) -> None:
        peer.receive()
        end(peer)

    async with opened(script, numbered) as (lane, server):
        if call in (READ, STOP):
            assert await lane.call(*call, PATIENCE) == (14 if call is READ else 0)
            assert server.names == [call[0]] * 2
        else:
            with pytest.raises(OutcomeUnknown, match="only a stop is ever sent again"):
                await lane.call(*call, PATIENCE)
            assert await lane.call(*READ, PATIENCE) == 14
            assert server.names == [call[0], READ[0]]


@each_kind
@each_end
async def test_nothing_is_sent_a_third_time(end: Script, call: tuple[str, Any]) -> None:
    def script(peer: Peer) -> None:
        if peer.receive() is not None:
            end(peer)

    async with opened(script) as (lane, server):
        error = ConnectionLost if call is READ else OutcomeUnknown
        with pytest.raises(error) as raised:
            await lane.call(*call, PATIENCE)
        assert type(raised.value) is error
        assert server.names == [call[0]] * (2 if call in (READ, STOP) else 1)


@each_kind
@each_end
async def test_a_connection_that_ends_in_the_answer(end: Script, call: tuple[str, Any]) -> None:
    """The controller was there and answered: only a stop is sent again, to be sure."""

    def script(peer: Peer) -> None:
        received = peer.take()
        encoded = reply(received.raw, answer_of(received.name))
        peer.send(encoded[:-3])
        # the client has them before the end can come
        now.wait(PATIENCE)
        end(peer)

    now = threading.Event()
    async with opened(script, numbered) as (lane, server):
        errors: list[BaseException] = []

        async with anyio.create_task_group() as group:
            group.start_soon(noted, errors, ConnectionLost, lane.call(*call, PATIENCE))
            await eventually_async(lambda: answering(lane))
            now.set()
        if call is STOP:
            assert errors == []
            assert server.names == [call[0]] * 2
        else:
            (error,) = errors
            assert type(error) is (ConnectionLost if call is READ else OutcomeUnknown)
            assert server.names == [call[0]]


def answering(lane: WireLane) -> bool:
    return channel(lane).life.progress is Progress.ANSWERING


async def test_a_stop_whose_second_try_finds_nobody_says_that_it_was_sent() -> None:
    def script(peer: Peer) -> None:
        peer.receive()
        peer.server.stop_listening()
        peer.close()

    async with no_leaks():
        with ScriptedServer(script) as server:
            lane = WireLane("test", server.host, server.port, connect_timeout=SHORT)
            await lane.open()
            with pytest.raises(OutcomeUnknown) as raised:
                await lane.call(*STOP, PATIENCE)
            assert isinstance(raised.value.__cause__, ConnectError)
            await lane.aclose()


async def test_a_lane_comes_back_with_its_controller() -> None:
    async with no_leaks():
        with ScriptedServer() as server:
            host, port = server.host, server.port
            lane = WireLane("test", host, port)
            await lane.open()
            assert await lane.call(*STOP) == 0
        for _ in range(2):
            with pytest.raises(ConnectError, match="refused"):
                await lane.call(*COMMAND)
        with ScriptedServer(port=port) as again:
            assert await lane.call(*COMMAND) == 0
            assert again.names == [COMMAND[0]]
            assert lane.statistics().opened == 2
            assert channel(lane).life.state is ConnectionState.IDLE
            await lane.aclose()


async def test_a_call_whose_wait_is_cancelled_goes_on() -> None:
    gate = Gate()
    async with opened(gate) as (lane, server):
        call = lane.prepare("get_noneblock_taskstate", (7,), PATIENCE)
        lane.send(call)
        with anyio.CancelScope() as scope:
            scope.cancel()
            await call.wait()
        assert scope.cancelled_caught
        assert call.ended_at is None
        gate.open()
        assert await call.wait(PATIENCE)
        assert (call.value, call.error, call.answered) == (7, None, True)
        assert server.connections == 1
        assert lane.statistics().abandoned == 0


async def test_a_wait_with_a_limit_leaves_the_call_alone() -> None:
    gate = Gate()
    async with opened(gate) as (lane, server):
        call = lane.prepare("get_noneblock_taskstate", (7,), PATIENCE)
        lane.send(call)
        assert not await call.wait(0.0)
        gate.open()
        assert await call.answer() == 7
        assert server.connections == 1


async def test_an_answer_that_is_not_awaited_any_more_abandons_its_call() -> None:
    async with opened(silent) as (lane, server):
        call = lane.prepare("pause", (True,), PATIENCE)
        lane.send(call)
        await eventually_async(lambda: len(server.calls) == 1)
        with anyio.CancelScope() as scope:
            scope.cancel()
            await call.answer()
        assert isinstance(call.error, OutcomeUnknown)
        assert lane.statistics().abandoned == 1


async def test_an_abandoned_command_may_have_been_carried_out() -> None:
    async with opened(silent) as (lane, server):
        call = lane.prepare("pause", (True,), PATIENCE)
        lane.send(call)
        await eventually_async(lambda: len(server.calls) == 1)
        call.abandon("no answer came in time", late=True)
        assert await call.wait(0.0)
        assert call.handed_over
        assert not call.answered
        with pytest.raises(OutcomeUnknown, match="no answer came in time"):
            await call.answer()


async def test_a_call_that_is_abandoned_while_it_waits_is_certainly_not_sent() -> None:
    gate = Gate()
    async with opened(gate) as (lane, server):
        first, second = (lane.prepare("pause", (True,), PATIENCE) for _ in range(2))
        lane.send(first)
        lane.send(second)
        assert lane.statistics().waiting == 1
        second.abandon("no connection was free", late=True)
        assert lane.statistics().waiting == 0
        assert not second.handed_over
        assert second.answered
        gate.open()
        await first.answer()
        with pytest.raises(NotSent, match="no connection was free"):
            await second.answer()
        assert server.names == ["pause"]
        assert (lane.statistics().abandoned, lane.statistics().failed) == (0, 0)
