"""Lanes: who gets a connection when, and what is left at the end."""

from __future__ import annotations

import gc
import socket
import time
import weakref
from typing import Any

import anyio
import pytest
from for_each import for_each

from aioduco._process.reporting import reporter
from aioduco._wire import channel as lane_channel
from aioduco._wire.lane import WireLane
from aioduco.errors import (
    ConnectError,
    ConnectionLost,
    ControllerError,
    NotSent,
    OutcomeUnknown,
    ParameterError,
    WrongProcess,
)
from aioduco.models.trace import (
    CallFinished,
    ConnectionEnded,
    ConnectionOpened,
    TraceEvent,
    guarded,
)
from aioduco.testing import eventually_async, no_leaks

from .lanes import SHORT, Gate, channel, opened
from .servers import PATIENCE, Peer, ScriptedServer, black_hole, exception, honest, silent

# Life


async def test_states_and_repr_of_a_life() -> None:
    async with no_leaks():
        with ScriptedServer() as server:
            lane = WireLane("poll", server.host, server.port, size=2)
            address = f"{server.host}:{server.port}"
            assert repr(lane) == f"<Lane poll {address} NEW, 0 of 2 busy, 0 waiting>"
            unopened = f"stop was not sent, since its connection to {address} is not open yet"
            with pytest.raises(ConnectionLost, match=unopened):
                await lane.rpc.stop(True)
            await lane.open()
            assert repr(lane) == f"<Lane poll {address} OPEN, 0 of 2 busy, 0 waiting>"
            with pytest.raises(RuntimeError, match="once"):
                await lane.open()
            assert await lane.rpc.stop(True) == 0
            await lane.aclose()
            await lane.aclose()
            assert repr(lane) == f"<Lane poll {address} CLOSED, 0 of 2 busy, 0 waiting>"
            closed = (
                f"stop was not sent, since its connection to {address} is closed: use the robot"
            )
            with pytest.raises(ConnectionLost, match=closed):
                await lane.rpc.stop(True)
            with pytest.raises(ConnectionLost, match=closed):
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
        assert figures.connections == figures.opened == server.connections == 3
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


@for_each("hangs, said", [(False, "refused"), (True, "no answer in time")])
async def test_a_lane_that_cannot_open_leaves_nothing(hangs: bool, said: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as closed, black_hole() as hole:
        address = hole if hangs else closed.getsockname()
        closed.close()
        async with no_leaks():
            lane = WireLane("test", *address, connect_timeout=SHORT if hangs else PATIENCE)
            with pytest.raises(ConnectError, match=said):
                await lane.open()
            assert lane.closed


async def test_a_lane_left_open_warns_and_its_connections_end() -> None:
    with ScriptedServer() as server, no_leaks():
        lane = WireLane("test", server.host, server.port)
        await lane.open()
        await lane.rpc.stop(True)  # the timer of its deadline runs on
        there = weakref.ref(lane)
        del lane

        def gone() -> bool:
            gc.collect()
            return there() is None

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


def descriptor(lane: WireLane) -> int:
    """The descriptor of the lane's first connection."""
    stream = channel(lane)._stream
    assert stream is not None
    return stream.socket.fileno()


async def test_a_forked_child_takes_nothing_from_a_connection_that_is_its_parents() -> None:
    """Its event loop may have found the connection ready just before the fork."""
    async with opened(silent) as (lane, _):
        first = channel(lane)
        first._loop.remove_reader(descriptor(lane))
        first.forked()
        first._readable()
        first._writable()


async def test_a_forked_child_sends_no_call_that_waited_for_its_parents_connection() -> None:
    async with opened(silent) as (lane, server):
        first = lane.prepare("get_global_speed", (), SHORT)
        lane.send(first)
        waits = lane.prepare("resume", (True,), PATIENCE)
        lane.send(waits)
        server.wait_calls(1)
        channel(lane)._loop.remove_reader(descriptor(lane))
        lane.forked()
        assert await waits.wait(PATIENCE)
    assert isinstance(waits.error, WrongProcess)
    assert "resume was not sent" in str(waits.error)
    assert isinstance(first.error, ConnectionLost)
    assert server.names == ["get_global_speed"]


async def test_a_forked_child_sends_no_call_whose_connection_was_being_opened() -> None:
    async with opened(silent, size=2) as (lane, server):
        lane.send(lane.prepare("get_global_speed", (), SHORT))
        opening = lane.prepare("resume", (True,), PATIENCE)
        lane.send(opening)
        channel(lane)._loop.remove_reader(descriptor(lane))
        lane.forked()
        assert await opening.wait(PATIENCE)
    assert isinstance(opening.error, WrongProcess)
    assert "resume" not in server.names


async def test_a_forked_child_sends_no_call_again_that_its_parent_has_sent() -> None:
    async with opened(silent) as (lane, server):
        reads = lane.prepare("get_global_speed", (), PATIENCE)
        lane.send(reads)
        server.wait_calls(1)
        channel(lane)._loop.remove_reader(descriptor(lane))
        lane.forked()
        channel(lane)._lost(EOFError())
        assert await reads.wait(PATIENCE)
    assert isinstance(reads.error, ConnectionLost)
    assert server.connections == 1


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
        call = peer.take()
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
            with pytest.raises(
                NotSent, match=r"resume was not sent: no connection to [\d.:]+ was free"
            ):
                await lane.call("resume", (True,), SHORT)
            with pytest.raises(TimeoutError):
                await lane.within(SHORT).resume(True)
            assert lane.statistics().waiting == 0
            assert lane.statistics().failed == 2
            gate.open()
        assert server.names == ["pause"]
        assert await lane.rpc.stop(True) == 0
        assert server.connections == 1


async def test_a_call_whose_connection_opens_just_after_its_deadline_was_not_sent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The time for the connection ends a moment after that for the call."""
    connect = lane_channel.connect
    async with opened(honest) as (lane, server):
        channel(lane)._drop("for the test")

        async def late(loop: Any, endpoint: Any, _: float) -> Any:
            stream = await connect(loop, endpoint, time.monotonic() + PATIENCE)
            await eventually_async(lambda: not lane._deadlines._calls)
            return stream

        monkeypatch.setattr(lane_channel, "connect", late)
        with pytest.raises(NotSent, match="resume was not sent: there was no time left for it"):
            await lane.call("resume", (True,), SHORT)
        assert await lane.rpc.stop(True) == 0
        assert server.names == ["stop"]
        assert server.connections == 2  # the late one serves the next call


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


# The hook


async def test_the_hook_sees_connections_and_calls() -> None:
    seen: list[TraceEvent] = []

    def script(peer: Peer) -> None:
        for answer in (7, None):
            call = peer.take()
            if answer is not None:
                peer.answer(call, answer)

    async with opened(script, honest, trace=seen.append) as (lane, server):
        await lane.rpc.get_noneblock_taskstate(3)
        with pytest.raises(OutcomeUnknown):
            await lane.rpc.pause(True)
        lane.call_from_thread("abort", (False,), PATIENCE)
        peer = (server.host, server.port)
    assert reporter.flush(10.0)
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
    assert functions == ["get_noneblock_taskstate", "pause", "abort"]
    # none after the loss until it is needed; one for the thread
    assert sum(isinstance(event, ConnectionOpened) for event in seen) == 2
    assert sum(isinstance(event, ConnectionEnded) for event in seen) == 2


async def test_a_hook_that_fails_disturbs_no_call(caplog: pytest.LogCaptureFixture) -> None:
    def hook(_: TraceEvent) -> None:
        raise ValueError("a mistake")

    async with opened(trace=guarded(hook)) as (lane, _):
        assert await lane.rpc.stop(True) == 0
    await eventually_async(lambda: "the trace hook failed" in caplog.text)
    assert "a mistake" in caplog.text


# Several questions at once

_STATE = ("get_robot_state", "getRobotStatus", "get_tcp_force")
_QUESTIONS = tuple((name, ()) for name in _STATE)


async def test_several_questions_are_asked_in_order_and_seen_one_by_one() -> None:
    seen: list[TraceEvent] = []

    def script(peer: Peer) -> None:
        for name in _STATE:
            call = peer.take()
            if name == "get_tcp_force":
                peer.send(exception(call.raw, 6, "not simulated"))
            else:
                peer.answer(call, [6, 1, 1, 0] if name == "get_robot_state" else None)
        honest(peer)

    async with opened(script) as (lane, server):
        lane.observers.append(seen.append)
        states, status, force = await lane.ask(*_QUESTIONS)
        assert states.get() == [6, 1, 1, 0]
        assert status.error is None
        assert states.at <= status.at <= force.at
        with pytest.raises(ControllerError, match="not simulated"):
            force.get()
        assert server.names == [*_STATE]
        assert server.connections == 1
        assert lane.statistics().calls == 3
    ends = [event for event in seen if isinstance(event, CallFinished)]
    assert [event.function for event in ends] == [*_STATE]
    assert [event.at for event in ends] == [states.at, status.at, force.at]
    assert isinstance(ends[2].error, ControllerError)


async def test_several_questions_are_asked_again_on_another_connection() -> None:
    def breaking(peer: Peer) -> None:
        # A connection that was used before may have died since.
        for _ in ("stop", "get_robot_state"):
            call = peer.take()
            peer.answer(call)
        peer.receive()
        peer.reset()

    async with opened(breaking, honest) as (lane, server):
        await lane.rpc.stop(True)
        assert len(await lane.ask(*_QUESTIONS)) == 3
        assert server.names == ["stop", *_STATE[:2], *_STATE]
        assert server.connections == 2


async def test_several_questions_without_an_answer_are_over_in_time() -> None:
    gate = Gate()
    async with opened(gate, call_timeout=SHORT) as (lane, server):
        with pytest.raises(ConnectionLost):
            await lane.ask(*_QUESTIONS)
        assert lane.statistics().failed == lane.statistics().calls == 3
        gate.open()
        assert set(server.names) <= {*_STATE[:1]}
