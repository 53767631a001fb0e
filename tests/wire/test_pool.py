"""Calls that block at the controller: on threads, each with a connection of its own."""

from __future__ import annotations

import threading
from functools import partial
from typing import Any

import anyio
import pytest

from aioduco.errors import CallTimeout, ConnectionLost, NotSent, OutcomeUnknown, RobotStateError
from aioduco.testing import eventually_async

from .lanes import SHORT, Gate, noted, opened, own_threads
from .servers import Peer, ending, honest

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


async def test_the_loop_goes_on_while_calls_block() -> None:
    gate = Gate()
    async with blocking(gate) as (lane, server), anyio.create_task_group() as group:
        group.start_soon(lane.within(None).run_program, "weld", True)
        await eventually_async(lambda: len(server.calls) == 1)
        with pytest.raises(NotSent, match=r"no connection .* was free"):
            await lane.call("resume", (True,), SHORT)
        gate.open()


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
