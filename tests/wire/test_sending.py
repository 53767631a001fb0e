"""When a call is sent: before anything else runs, with its permit, long ones in parts."""

from __future__ import annotations

import socket
import threading
from typing import Any

import anyio
import pytest
from for_each import for_each

from aioduco._wire.lane import WireLane
from aioduco.errors import ConnectionLost, NotSent, OutcomeUnknown, RobotStateError
from aioduco.testing import eventually_async

from .lanes import SHORT, Gate, channel, noted, opened, own_threads
from .servers import PATIENCE, Peer, honest

#: more than a system keeps for a connection whose other side reads nothing
LONG = "x" * 3_000_000


def unread(read: threading.Event) -> Any:
    """A script that reads nothing until it may."""

    def script(peer: Peer) -> None:
        assert read.wait(PATIENCE)
        honest(peer)

    return script


def narrow(lane: WireLane) -> None:
    """Let the system keep little of what the lane sends."""
    stream = channel(lane)._stream
    assert stream is not None
    stream.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)


class Permit:
    """A permit that ends when it is told to."""

    def __init__(self) -> None:
        self.asked = 0
        self.error: Exception | None = None

    def __call__(self) -> None:
        self.asked += 1
        if self.error is not None:
            raise self.error


# At once


async def test_a_call_that_was_begun_is_sent_before_anything_else_runs() -> None:
    async with opened() as (lane, server):
        call = lane.prepare("stop", (True,), PATIENCE)
        lane.send(call)
        server.wait_calls(1)  # blocks the loop
        assert await call.answer() == 0


async def test_a_lane_needs_no_thread() -> None:
    before = own_threads()
    async with opened() as (lane, _):
        assert await lane.rpc.stop(True) == 0
        assert own_threads() == before


async def test_a_call_that_was_begun_and_not_awaited_disturbs_nothing() -> None:
    async with opened() as (lane, server):
        lane.send(lane.prepare("stop", (True,), PATIENCE))
        server.wait_calls(1)
        assert await lane.rpc.get_global_speed() == 0
        assert server.connections == 1


async def test_a_call_on_a_connection_that_was_closed_is_sent_on_another() -> None:
    async with opened(Peer.close, honest) as (lane, server):
        server.wait_finished(1)  # the loop has not heard of it
        assert await lane.rpc.pause(True) == 0
        assert (server.names, server.connections) == (["pause"], 2)


async def test_an_end_of_the_connection_is_noticed_while_it_is_idle() -> None:
    async with opened(Peer.close, honest) as (lane, _):
        await eventually_async(lambda: channel(lane).life.reason != "")
        assert channel(lane).life.reason == "the controller closed the connection"


# With a permit


async def test_a_permit_that_ended_sends_nothing_and_keeps_the_connection() -> None:
    permit = Permit()
    async with opened() as (lane, server):
        assert await lane.call("pause", (True,), permit=permit) == 0
        assert permit.asked == 1
        permit.error = RobotStateError("the arm is being stopped")
        with pytest.raises(RobotStateError) as raised:
            await lane.call("pause", (True,), permit=permit)
        assert raised.value is permit.error
        call = lane.prepare("pause", (True,), PATIENCE, permit)
        lane.send(call)
        with pytest.raises(RobotStateError):
            await call.answer()
        with pytest.raises(RobotStateError):
            lane.call_from_thread("pause", (True,), PATIENCE, permit)
        assert await lane.rpc.stop(True) == 0
        # no stop, which is sent once more if its answer takes longer than 0.1 s
        assert lane.call_from_thread("abort", (True,), PATIENCE) == 0
        assert server.names == ["pause", "stop", "abort"]
        assert server.connections == 2
        assert lane.statistics().failed == lane.statistics().abandoned == 0


async def test_a_permit_is_asked_when_a_call_is_sent_and_not_before() -> None:
    """It waits behind another call, and meanwhile its permit ends."""
    gate, permit = Gate(), Permit()
    raised: list[BaseException] = []

    async with opened(gate) as (lane, server), anyio.create_task_group() as group:
        group.start_soon(lane.within(None).pause, True)
        await eventually_async(lambda: len(server.calls) == 1)
        resume = lane.call("resume", (True,), permit=permit)
        group.start_soon(noted, raised, RobotStateError, resume)
        group.start_soon(lane.rpc.get_global_speed)
        await eventually_async(lambda: lane.statistics().waiting == 2)
        assert permit.asked == 0
        permit.error = RobotStateError("the arm is being stopped")
        gate.open()
        await eventually_async(lambda: len(server.calls) == 2)
        assert server.names == ["pause", "get_global_speed"]
        assert raised == [permit.error]
        assert permit.asked == 1


@for_each("late", [False, True])
async def test_any_number_of_calls_that_wait_may_be_refused_in_their_turn(late: bool) -> None:
    gate, permit = Gate(), Permit()
    async with opened(gate, call_timeout=PATIENCE) as (lane, server):
        calls = [lane.prepare("pause", (True,))]
        calls += [lane.prepare("abort", (True,), PATIENCE, permit) for _ in range(1000)]
        for call in calls:
            lane.send(call)
        if not late:
            permit.error = RobotStateError("the arm is being stopped")
        for call in calls[1:] if late else ():
            call.deadline = 0.0  # a busy loop hears of the answer first, then of the time
        gate.open()
        for call in calls:
            assert await call.wait(PATIENCE)
        assert {type(call.error) for call in calls[1:]} == {NotSent if late else RobotStateError}
        assert await lane.rpc.stop(True) == 0
        assert server.names == ["pause", "stop"]


async def test_a_permit_is_asked_again_on_another_connection() -> None:
    permit = Permit()

    def closing(peer: Peer) -> None:
        peer.receive()
        permit.error = RobotStateError("the arm is being stopped")

    async with opened(closing, honest) as (lane, server):
        with pytest.raises(RobotStateError):
            await lane.call("get_global_speed", (), permit=permit)
        assert permit.asked == 2
        assert len(server.calls) == 1


# In parts


@pytest.mark.slow
async def test_a_long_call_is_sent_in_parts_and_the_loop_goes_on() -> None:
    read = threading.Event()
    async with opened(unread(read), call_timeout=PATIENCE) as (lane, server):
        narrow(lane)
        async with anyio.create_task_group() as group:
            group.start_soon(lane.rpc.log_info, LONG)
            await eventually_async(lambda: channel(lane)._rest)
            read.set()
        assert [call.args for call in server.calls] == [(LONG,)]
        assert await lane.rpc.stop(True) == 0
        assert server.connections == 1


async def test_a_controller_that_reads_nothing_is_given_up_in_time() -> None:
    read = threading.Event()
    async with opened(unread(read), honest) as (lane, server):
        narrow(lane)
        with pytest.raises(OutcomeUnknown, match="no answer came in time"):
            await lane.call("log_info", (LONG,), 2 * SHORT)
        read.set()
        server.wait_finished(1)
        # the controller has only a part of it
        assert await lane.rpc.stop(True) == 0
        assert server.names == ["stop"]


async def test_a_permit_that_ends_between_two_parts_leaves_a_call_that_is_never_whole() -> None:
    read, permit = threading.Event(), Permit()
    raised: list[BaseException] = []

    async with opened(unread(read), honest) as (lane, server):
        narrow(lane)
        async with anyio.create_task_group() as group:
            call = lane.call("log_info", (LONG,), PATIENCE, permit=permit)
            group.start_soon(noted, raised, RobotStateError, call)
            await eventually_async(lambda: channel(lane)._rest)
            permit.error = RobotStateError("the arm is being stopped")
            read.set()
        assert raised == [permit.error]
        assert await lane.rpc.stop(True) == 0
        assert (server.names, server.connections) == (["stop"], 2)


@pytest.mark.parametrize("timeout", [0.0, -1.0])
async def test_a_call_without_time_is_not_sent(timeout: float) -> None:
    async with opened() as (lane, server):
        with pytest.raises(NotSent, match="no time left"):
            await lane.call("stop", (True,), timeout)
        assert server.calls == []
        assert lane.statistics().busy == 0


async def test_a_closed_lane_sends_nothing() -> None:
    async with opened() as (lane, server):
        await lane.aclose()
        with pytest.raises(ConnectionLost, match="is closed: use the robot"):
            lane.prepare("stop", (True,), PATIENCE)
        assert server.calls == []
