"""Calls that block at the controller: on threads, each with a connection of its own."""

from __future__ import annotations

import threading
import time
from functools import partial
from typing import Any

import anyio
import pytest

from aioduco._wire.endpoint import Endpoint
from aioduco._wire.lane import WireLane
from aioduco._wire.own_connection import OwnConnection
from aioduco.errors import CallTimeout, ConnectionLost, OutcomeUnknown, RobotStateError
from aioduco.testing import eventually_async

from .lanes import SHORT, Gate, noted, opened, own_threads
from .names import NAME, Names
from .servers import PATIENCE, Peer, ScriptedServer, ending, honest

blocking = partial(opened, blocks=True)


def threads() -> list[str]:
    return [name for name in own_threads() if name == "aioduco-test"]


async def test_each_thread_has_a_connection_for_its_whole_life() -> None:
    gate = Gate()
    async with blocking(gate, size=2) as (lane, server):
        assert server.connections == len(threads()) == 0
        async with anyio.create_task_group() as group:
            for number in range(3):
                group.start_soon(lane.within(None).get_noneblock_taskstate, number)
            await eventually_async(lambda: len(server.calls) == 2)
            assert lane.statistics()._replace(calls=0) == (0, 0, 1, 2, 2, 2, 0, 0)
            assert len(threads()) == 2
            gate.open()
        assert await lane.rpc.stop(True) == 0
        assert server.connections == len(threads()) == 2
    assert threads() == []


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("name", "args", "error"),
    [("get_tcp_pose", (), CallTimeout), ("pause", (True,), OutcomeUnknown)],
)
async def test_a_call_keeps_its_deadline(
    name: str, args: tuple[Any, ...], error: type[Exception]
) -> None:
    gate = Gate()
    async with blocking(gate, honest) as (lane, _):
        with pytest.raises(error):
            await lane.call(name, args, 5 * SHORT)
        gate.open()
        assert await lane.rpc.stop(True) == 0


async def test_a_connection_that_ended_while_idle_costs_no_call() -> None:
    def one(peer: Peer) -> None:
        call = peer.take()
        peer.answer(call)

    async with blocking(one, honest) as (lane, server):
        assert await lane.rpc.pause(True) == 0
        server.wait_finished(1)
        assert await lane.rpc.resume(True) == 0
        assert (server.names, server.connections) == (["pause", "resume"], 2)


async def test_a_command_whose_connection_ends_is_not_sent_again() -> None:
    async with blocking(ending) as (lane, server):
        with pytest.raises(OutcomeUnknown):
            await lane.rpc.pause(True)
        assert server.names == ["pause"]
        assert lane.statistics().failed == 1


async def test_closing_ends_calls_under_way_and_their_threads() -> None:
    gate = Gate()
    raised: list[BaseException] = []

    async with blocking(gate) as (lane, server):
        async with anyio.create_task_group() as group:
            for _ in range(2):
                group.start_soon(noted, raised, ConnectionLost, lane.within(None).pause(True))
            await eventually_async(lambda: len(server.calls) == 1)
            await lane.aclose()
        assert {type(error) for error in raised} == {ConnectionLost, OutcomeUnknown}
        assert threads() == []
        gate.open()


async def test_closing_does_not_wait_for_a_name_server_that_hangs(names: Names) -> None:
    names.answers.clear()
    lane = WireLane("test", NAME, 7003, blocks=True, connect_timeout=PATIENCE)
    await lane.open()
    raised: list[BaseException] = []
    async with anyio.create_task_group() as group:
        group.start_soon(noted, raised, ConnectionLost, lane.within(None).pause(True))
        await eventually_async(lambda: names.asked == 1)
        await lane.aclose()
    assert [str(error) for error in raised] == ["pause was not sent, since its lane was closed"]
    names.answers.set()
    await eventually_async(lambda: threads() == [])


async def test_a_thread_that_cannot_be_had_is_said_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    async with blocking() as (lane, server):
        with monkeypatch.context() as patch:
            patch.setattr(threading.Thread, "start", none)
            with pytest.raises(ConnectionLost, match="pause was not sent: no thread for it"):
                await lane.rpc.pause(True)
        assert server.calls == []
        assert lane.statistics().busy == 0
        assert await lane.rpc.pause(True) == 0


async def test_a_permit_that_ended_sends_nothing_and_keeps_the_connection() -> None:
    ended = RobotStateError("the arm is being stopped")

    def permit() -> None:
        raise ended

    async with blocking() as (lane, server):
        assert await lane.rpc.stop(True) == 0
        with pytest.raises(RobotStateError) as raised:
            await lane.call("pause", (True,), permit=permit)
        assert raised.value is ended
        assert await lane.rpc.stop(True) == 0
        assert (server.names, server.connections) == (["stop", "stop"], 1)


def stands(peer: Peer) -> None:
    """A controller whose arm stands."""
    while (call := peer.receive()) is not None:
        peer.answer(call, False)


def leaves(peer: Peer) -> None:
    """One that breaks the connection with the first call."""
    peer.receive()
    peer.reset()


def own(server: ScriptedServer) -> OwnConnection:
    return OwnConnection(Endpoint(server.host, server.port, PATIENCE))


def test_calls_share_a_connection_that_is_open() -> None:
    with ScriptedServer(stands) as server:
        mine = own(server)
        assert mine.call("robotmoving", (), PATIENCE) is False
        assert mine.call("robotmoving", (), PATIENCE) is False
        assert server.connections == 1
        mine.close()


def test_the_call_after_one_that_failed_opens_another() -> None:
    with ScriptedServer(leaves, stands) as server:
        mine = own(server)
        with pytest.raises(ConnectionLost):
            mine.call("robotmoving", (), PATIENCE)
        assert not mine.idle
        assert mine.call("robotmoving", (), PATIENCE) is False
        assert server.connections == 2
        mine.close()


def test_nothing_is_opened_after_it_was_given_up() -> None:
    with ScriptedServer(stands, stands) as server:
        mine = own(server)
        assert mine.call("robotmoving", (), PATIENCE) is False
        mine.give_up("its heartbeat ends")
        with pytest.raises(ConnectionLost, match="its heartbeat ends"):
            mine.ready(time.monotonic() + PATIENCE)
        assert server.connections == 1
        mine.close()
