"""A call is cancelled at each point: nothing is left, and no other caller gets its answer."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Coroutine
from functools import partial
from typing import Any

import anyio
import pytest
from anyio.lowlevel import checkpoint
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from quick import examples

from aioduco._wire.lane import WireLane
from aioduco._wire.lifecycle import ConnectionState
from aioduco.errors import CallTimeout, ConnectError, NotSent, OutcomeUnknown
from aioduco.testing import eventually_async, no_leaks

from .lanes import SHORT, channel, opened, own_threads
from .servers import PATIENCE, Peer, ScriptedServer, black_hole, held, honest, silent


def doubling(peer: Peer) -> None:
    """Answer each task id by its double."""
    while (call := peer.receive()) is not None:
        peer.answer(call, 2 * call.args[0] if call.name == "get_noneblock_taskstate" else None)


def start(call: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
    return asyncio.get_running_loop().create_task(call)


async def works(lane: WireLane) -> None:
    """The lane is as good as new."""
    figures = lane.statistics()
    assert figures.waiting == 0
    for number in (3, 4, 5):
        assert await lane.rpc.get_noneblock_taskstate(number) == 2 * number


# Before anything is sent


async def test_in_a_scope_that_is_cancelled_already_nothing_is_sent() -> None:
    async with opened(doubling) as (lane, server):
        with anyio.CancelScope() as scope:
            scope.cancel()
            await lane.rpc.pause(True)
        assert scope.cancelled_caught
        with anyio.move_on_after(0.0):
            await lane.rpc.resume(True)
        await works(lane)
        assert {call.name for call in server.calls} == {"get_noneblock_taskstate"}
        assert server.connections == 1


async def test_a_shielded_call_in_a_cancelled_scope_is_sent() -> None:
    """A stop on the way out of a cancelled program."""
    async with opened(doubling) as (lane, server):
        with anyio.CancelScope() as scope:
            scope.cancel()
            with anyio.CancelScope(shield=True):
                assert await lane.rpc.stop(True) == 0
        assert server.names == ["stop"]


async def test_a_task_cancelled_before_it_begins_sends_nothing() -> None:
    async with opened(doubling) as (lane, server):
        task = start(lane.rpc.pause(True))
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert server.calls == []
        assert lane.statistics().calls == 0


# While it waits for a connection


async def test_a_call_cancelled_while_it_waits_leaves_no_trace() -> None:
    gate = threading.Event()

    async with opened(held(gate, doubling)) as (lane, server):
        async with anyio.create_task_group() as outer:
            outer.start_soon(lane.within(None).pause, True)
            await eventually_async(lambda: len(server.calls) == 1)
            async with anyio.create_task_group() as group:
                for _ in range(5):
                    group.start_soon(lane.rpc.resume, True)
                outer.start_soon(lane.rpc.get_noneblock_taskstate, 9)
                await eventually_async(lambda: lane.statistics().waiting == 6)
                group.cancel_scope.cancel()
            assert lane.statistics().waiting == 1
            assert lane.statistics().abandoned == 0
            gate.set()
        await works(lane)
        assert server.names[:2] == ["pause", "get_noneblock_taskstate"]
        assert "resume" not in server.names
        assert server.connections == 1


async def test_a_call_cancelled_just_as_its_turn_comes() -> None:
    """The answer is there, the loop has not read it, and the next in the queue gives up."""
    gate = threading.Event()

    async with opened(held(gate, doubling)) as (lane, server):
        first = start(lane.within(None).pause(True))
        await eventually_async(lambda: len(server.calls) == 1)
        second = start(lane.rpc.resume(True))
        third = start(lane.rpc.get_noneblock_taskstate(9))
        await eventually_async(lambda: lane.statistics().waiting == 2)
        gate.set()
        block_until_answered(lane)
        second.cancel()
        assert await first == 0
        assert await third == 18
        with pytest.raises(asyncio.CancelledError):
            await second
        assert server.names == ["pause", "get_noneblock_taskstate"]


def block_until_answered(lane: WireLane) -> None:
    """Block the loop, on purpose, until there is an answer that it has not read."""
    stream = channel(lane)._stream
    assert stream is not None
    assert stream.answers_within(PATIENCE)


# In mid call


@pytest.mark.parametrize("blocks", [False, True], ids=["on the loop", "on a thread"])
@pytest.mark.parametrize("name", ["get_global_speed", "pause", "stop"])
async def test_a_call_cancelled_in_mid_call_closes_its_connection(name: str, blocks: bool) -> None:
    """And a thread of its own comes back, and carries the next calls."""
    gone = []

    def script(peer: Peer) -> None:
        peer.receive()
        gone.append(peer.wait_gone())

    async with opened(script, doubling, blocks=blocks) as (lane, server):
        life = None if blocks else channel(lane).life
        async with anyio.create_task_group() as group:
            args = () if name == "get_global_speed" else (True,)
            group.start_soon(partial(lane.call, name, args, None))
            await eventually_async(lambda: len(server.calls) == 1)
            group.cancel_scope.cancel()
        if life is not None:
            assert life.state is ConnectionState.POISONED
            assert life.reason == "the call was cancelled"
        server.wait_finished(1)
        assert gone == [True]
        await works(lane)
        # never sent again by itself, not even a stop: nobody wants its answer any more
        assert server.names.count(name) == 1
        assert lane.statistics().abandoned == 1
        assert own_threads().count("aioduco-test") == blocks


async def test_a_call_cancelled_while_it_connects() -> None:
    async with opened(doubling) as (lane, _):
        with black_hole() as (host, port):
            source = lane._endpoint
            home = source.host, source.port
            source.host, source.port = host, port
            channel(lane)._drop("for the test")
            async with anyio.create_task_group() as group:
                group.start_soon(lane.within(None).pause, True)
                await eventually_async(lambda: connecting(lane))
                group.cancel_scope.cancel()
            source.host, source.port = home
        await works(lane)


def connecting(lane: WireLane) -> bool:
    return channel(lane)._opening is not None


async def test_opening_a_lane_is_cancelled() -> None:
    with black_hole() as (host, port):
        async with no_leaks():
            lane = WireLane("test", host, port, connect_timeout=PATIENCE)
            async with anyio.create_task_group() as group:
                group.start_soon(lane.open)
                await eventually_async(lambda: lane.statistics().connections == 1)
                group.cancel_scope.cancel()


async def test_closing_a_lane_goes_on_when_it_is_cancelled() -> None:
    async with no_leaks():
        with ScriptedServer(silent) as server:
            lane = WireLane("test", server.host, server.port)
            await lane.open()
            with anyio.CancelScope() as scope:
                scope.cancel()
                await lane.aclose()
            server.wait_finished(1)


# As it completes


async def test_an_answer_that_meets_a_cancellation_goes_to_nobody_else() -> None:
    """The answer is there, the loop has not read it, and the caller gives up."""
    async with opened(doubling) as (lane, server):
        for number in range(20):
            task = start(lane.rpc.get_noneblock_taskstate(number))
            await eventually_async(partial(begun, lane, task))
            if not task.done():
                block_until_answered(lane)
            task.cancel()
            outcome = (await asyncio.gather(task, return_exceptions=True))[0]
            assert isinstance(outcome, asyncio.CancelledError) or outcome == 2 * number
        await works(lane)
        # an answer that was not read is lost with its connection
        figures = lane.statistics()
        assert server.connections == 1 + figures.abandoned


def begun(lane: WireLane, task: asyncio.Task[Any]) -> bool:
    """Whether the call is on its way: its connection may have to be opened first."""
    return task.done() or (lane.statistics().busy == 1 and channel(lane)._stream is not None)


async def cancel_after(ticks: int, scope: anyio.CancelScope) -> None:
    """Cancel after so many turns of the loop: before, in, and after the call."""
    for _ in range(ticks):
        await checkpoint()
    scope.cancel()


@settings(
    max_examples=examples(40),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    size=st.integers(1, 3),
    plan=st.lists(st.one_of(st.none(), st.integers(0, 12)), min_size=1, max_size=12),
)
def test_any_pattern_of_cancellations(size: int, plan: list[int | None]) -> None:
    """Commands and reads side by side; each is sent at most once, and answered truly or not."""
    outcomes: dict[int, Any] = {}

    async def call(lane: WireLane, number: int, ticks: int | None) -> None:
        with anyio.CancelScope() as scope:
            async with anyio.create_task_group() as group:
                if ticks is not None:
                    group.start_soon(cancel_after, ticks, scope)
                outcomes[number] = await lane.rpc.write_word_reg(1, number)
                group.cancel_scope.cancel()

    def answer(peer: Peer) -> None:
        while (call := peer.receive()) is not None:
            peer.answer(call, call.args[1] + 1000 if call.name == "write_word_reg" else 5)

    async def main() -> None:
        async with opened(answer, size=size, call_timeout=PATIENCE) as (lane, server):
            async with anyio.create_task_group() as group:
                for number, ticks in enumerate(plan):
                    group.start_soon(call, lane, number, ticks)
            assert await lane.rpc.get_global_speed() == 5
            sent = [call.args[1] for call in server.calls if call.name == "write_word_reg"]
            assert len(sent) == len(set(sent))
            assert outcomes == {number: number + 1000 for number in outcomes}
            assert set(outcomes) <= set(sent)
            assert {n for n, ticks in enumerate(plan) if ticks is None} <= set(outcomes)

    asyncio.run(main())


# Time-outs


async def test_timeouts_at_every_point_leave_nothing() -> None:
    async with opened(silent, honest, call_timeout=PATIENCE) as (lane, server):
        async with anyio.create_task_group() as group:
            group.start_soon(expect, OutcomeUnknown, lane.call("pause", (True,), 3 * SHORT))
            await eventually_async(lambda: len(server.calls) == 1)
            # in the queue behind it
            group.start_soon(expect, NotSent, lane.call("resume", (True,), SHORT))
            group.start_soon(expect, NotSent, lane.call("get_tcp_pose", (), SHORT))
        assert server.names == ["pause"]
        assert await lane.rpc.get_robot_version() == "3.8"
        figures = lane.statistics()
        assert (figures.failed, figures.waiting, figures.busy) == (3, 0, 0)


async def expect(error: type[Exception] | tuple[type[Exception], ...], call: Any) -> None:
    with pytest.raises(error):
        await call


@pytest.mark.parametrize("way", ["anyio", "asyncio", "wait_for"])
async def test_the_callers_own_timeout_is_a_cancellation(way: str) -> None:
    async with opened(silent, doubling) as (lane, server):
        call = lane.within(None).pause(True)
        if way == "anyio":
            with pytest.raises(TimeoutError), anyio.fail_after(SHORT):
                await call
        elif way == "asyncio":
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(SHORT):
                    await call
        else:
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(call, SHORT)
        assert lane.statistics().abandoned == 1
        # On a busy machine the connection may have been reset before the server read from it.
        assert server.names in ([], ["pause"])
        server.wait_finished(1)
        await works(lane)


async def test_many_timeouts_on_a_silent_controller_leave_nothing() -> None:
    async with opened(silent, size=4) as (lane, _):
        for _ in range(5):
            async with anyio.create_task_group() as group:
                for _ in range(4):
                    call = lane.call("get_tcp_pose", (), SHORT / 2)
                    # on a busy machine the time can be over before it is sent, or connected
                    group.start_soon(expect, (CallTimeout, NotSent, ConnectError), call)
        figures = lane.statistics()
        assert figures.failed == 20
        assert figures.connections <= 4
        assert figures.busy == figures.waiting == figures.stuck == 0
