"""Lanes on loops of every kind, and on loops that end."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import threading
from collections.abc import Callable
from typing import Any, NoReturn

import anyio
import anyio.lowlevel
import pytest
import uvloop
from moments import on_another_thread

from aioduco._wire.lane import WireLane
from aioduco._wire.owner_loop import OwnerLoop
from aioduco.errors import NotSent, OutcomeUnknown
from aioduco.testing import eventually_async, no_leaks

from .lanes import SHORT, Gate, noted, opened
from .servers import PATIENCE, Peer, ScriptedServer, ending, honest


class UnreportingLoop(asyncio.SelectorEventLoop):
    """A loop that reports no readiness of a descriptor, as the default one of Windows."""

    def add_reader(self, *_: Any, **__: Any) -> NoReturn:  # type: ignore[override]
        raise NotImplementedError

    def add_writer(self, *_: Any, **__: Any) -> NoReturn:  # type: ignore[override]
        raise NotImplementedError


LOOPS: dict[str, Callable[[], asyncio.AbstractEventLoop]] = {
    "asyncio": asyncio.SelectorEventLoop,
    "uvloop": uvloop.new_event_loop,
    "unreporting": UnreportingLoop,
}


@pytest.fixture(params=LOOPS)
def runner(request: pytest.FixtureRequest) -> Any:
    """An event loop; the pipe that libuv opens for the first one is no leak."""
    with asyncio.Runner(loop_factory=LOOPS[request.param]) as made:
        made.run(anyio.lowlevel.checkpoint())
        yield made


def test_calls_are_answered(runner: asyncio.Runner) -> None:
    async def main() -> None:
        async with opened(size=2) as (lane, server):
            async with anyio.create_task_group() as group:
                for number in range(5):
                    group.start_soon(lane.rpc.get_noneblock_taskstate, number)
            names = ("get_robot_state", "getRobotStatus", "get_global_speed")
            answers = await lane.ask(*((name, ()) for name in names))
            assert [answer.error for answer in answers] == [None] * 3
            call = lane.prepare("stop", (True,), PATIENCE)
            lane.send(call)
            assert await call.answer() == 0
            assert server.connections == 2

    runner.run(main())


def test_a_long_call_and_a_long_answer(runner: asyncio.Runner) -> None:
    names = {f"program {number}": 1 for number in range(20_000)}

    def script(peer: Peer) -> None:
        while (call := peer.receive()) is not None:
            peer.answer(call, names if call.name == "get_files_list" else None)

    async def main() -> None:
        async with opened(script, call_timeout=PATIENCE) as (lane, server):
            await lane.rpc.log_info("x" * 3_000_000)
            assert [call.name for call in server.calls] == ["log_info"]
            assert await lane.rpc.get_files_list("") == names
            assert server.connections == 1

    runner.run(main())


@pytest.mark.parametrize("how", ["cancelled", "late", "closed"])
def test_a_call_without_an_answer_costs_its_connection(runner: asyncio.Runner, how: str) -> None:
    gate = Gate()
    raised: list[BaseException] = []

    async def main() -> None:
        async with opened(gate, honest) as (lane, server):
            async with anyio.create_task_group() as group:
                pause = lane.call("pause", (True,), 2 * SHORT if how == "late" else None)
                group.start_soon(noted, raised, OutcomeUnknown, pause)
                await eventually_async(lambda: len(server.calls) == 1)
                if how == "cancelled":
                    group.cancel_scope.cancel()
                elif how == "closed":
                    await lane.aclose()
            assert len(raised) == (how != "cancelled")
            if how != "closed":
                assert await lane.rpc.stop(True) == 0
                assert (server.names, server.connections) == (["pause", "stop"], 2)
            gate.open()

    runner.run(main())


def test_a_read_whose_connection_ends_is_made_on_another(runner: asyncio.Runner) -> None:
    async def main() -> None:
        async with opened(ending, honest) as (lane, server):
            assert await lane.rpc.get_robot_version() == "3.8"
            assert await lane.rpc.pause(True) == 0
            assert server.connections == 2

    runner.run(main())


@pytest.mark.slow
def test_many_connections_in_turn_use_descriptors_again(runner: asyncio.Runner) -> None:
    """What the loop knows of a descriptor is forgotten before another connection has it."""

    def one(peer: Peer) -> None:
        call = peer.receive()
        if call is not None and call.name != "get_tcp_pose":
            peer.answer(call)
        peer.receive()

    async def main() -> None:
        async with opened(one, size=3) as (lane, _):
            for _ in range(10):
                async with anyio.create_task_group() as group:
                    for name in ("get_tcp_pose", "get_global_speed", "get_tcp_pose"):
                        group.start_soon(ignoring(lane, name))
            assert lane.statistics().busy == 0

    def ignoring(lane: WireLane, name: str) -> Callable[[], Any]:
        async def call() -> None:
            with contextlib.suppress(ConnectionError):
                await lane.call(name, (), SHORT / 2)

        return call

    runner.run(main())


# Loops that end


def test_a_lane_survives_the_end_of_its_loop(runner: asyncio.Runner) -> None:
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

        runner.run(second())
        # one for each loop: a connection is no other thread's
        assert server.connections == 2


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["asyncio", "uvloop"])
def test_a_lane_survives_a_loop_that_ends_in_mid_call(kind: str) -> None:
    gate = Gate()
    LOOPS[kind]().close()  # the first of a process opens what the process keeps
    with no_leaks(), ScriptedServer(gate) as server:
        lane = WireLane("test", server.host, server.port)
        loop = LOOPS[kind]()
        loop.run_until_complete(lane.open())
        task = loop.create_task(lane.within(None).pause(True))
        waiting = loop.create_task(lane.within(None).resume(True))
        loop.call_soon(loop.stop)
        loop.run_forever()
        server.wait_calls(1)
        # a loop that is thrown away with tasks on it, which nobody ever cancels
        pending = asyncio.all_tasks(loop)
        loop.close()
        gate.open()

        async def again() -> None:
            assert await lane.rpc.stop(True) == 0
            await lane.aclose()

        asyncio.run(again())
        assert server.names == ["pause", "stop"]
        for one in (task, waiting, *pending):
            one._log_destroy_pending = False  # type: ignore[attr-defined]  # it is what is tested
        del task, waiting, pending, one
        gc.collect()


def test_a_lane_is_closed_on_another_loop_than_its_own() -> None:
    with no_leaks(), ScriptedServer() as server:
        lane = WireLane("test", server.host, server.port, spare=True)
        asyncio.run(lane.open())
        asyncio.run(lane.aclose())
        server.wait_finished(2)
        assert repr(lane).endswith("CLOSED, 0 of 1 busy, 0 waiting>")


@pytest.mark.slow
def test_a_lane_that_is_forgotten_on_another_thread_closes_its_connection() -> None:
    """The garbage collector runs anywhere; the loop's readers are taken away on the loop."""

    def forget(lanes: list[WireLane]) -> None:
        lanes.clear()
        gc.collect()

    async def main(server: ScriptedServer) -> None:
        lanes = [WireLane("test", server.host, server.port, spare=True)]
        await lanes[0].open()
        with pytest.warns(ResourceWarning, match="unclosed <Lane test"):
            on_another_thread(lambda: forget(lanes))
        await eventually_async(lambda: server.finished == 2)

    with no_leaks(), ScriptedServer() as server:
        asyncio.run(main(server))


# Whose loop it is


def test_an_owner_loop_runs_what_other_threads_have_for_it() -> None:
    owner = OwnerLoop()
    ran: list[object] = []
    owner.run(lambda: ran.append("before it has a loop"))

    async def main() -> None:
        owner.require("a test")
        owner.run(lambda: ran.append("on it"))
        assert ran[-1] == "on it"
        here = threading.get_ident()
        on_another_thread(lambda: owner.run(lambda: ran.append(threading.get_ident() == here)))
        await eventually_async(lambda: ran[-1] is True)

    asyncio.run(main())
    owner.run(lambda: ran.append("after its end"))
    assert ran == ["before it has a loop", "on it", True, "after its end"]
