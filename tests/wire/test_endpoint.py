"""Names are resolved off the event loop, for each connection.

That each address has its share of the time: `test_connection.py` and `hostile/test_hosts.py`.
"""

from __future__ import annotations

import asyncio
import socket
import threading
import time
from collections.abc import Callable
from itertools import product

import anyio
import pytest
from for_each import for_each

from aioduco._wire.lane import WireLane
from aioduco._wire.lifecycle import ConnectionState, Lifecycle, Progress
from aioduco.errors import ConnectError, ConnectionLost, NotSent
from aioduco.testing import eventually, eventually_async

from .lanes import SHORT, channel, noted, own_threads
from .names import NAME, Names
from .servers import PATIENCE, ScriptedServer

# Addresses


async def test_an_address_that_refuses_costs_no_time(names: Names) -> None:
    with ScriptedServer() as server, socket.socket() as closed:
        closed.bind(("127.0.0.1", 0))
        names.addresses = [closed.getsockname(), (server.host, server.port)]
        lane = WireLane("test", NAME, 7003, connect_timeout=PATIENCE)
        await lane.open()
        await lane.aclose()
        names.addresses.pop()
        with pytest.raises(ConnectError, match="refused"):
            await WireLane("test", NAME, 7003).open()


async def test_a_connection_that_was_made_while_the_loop_stood_still_is_taken() -> None:
    with ScriptedServer() as server:
        lane = WireLane("test", server.host, server.port, connect_timeout=SHORT, spare=True)
        opening = asyncio.ensure_future(lane.open())
        while not opening.done():
            await asyncio.sleep(0)
            time.sleep(2 * SHORT)  # noqa: ASYNC251 - the loop stands still
        await opening
        assert await lane.rpc.resume(True) == 0
        await lane.aclose()


# Names


async def test_an_address_needs_no_thread_and_no_name_server(names: Names) -> None:
    with ScriptedServer() as server:
        before = own_threads()
        lane = WireLane("test", server.host, server.port)
        await lane.open()
        assert own_threads() == before
        await lane.aclose()


async def test_a_name_is_resolved_for_each_connection(names: Names) -> None:
    """A replaced controller may have another address."""
    with ScriptedServer() as first, ScriptedServer() as second:
        names.addresses = [(first.host, first.port)]
        lane = WireLane("test", NAME, 7003)
        await lane.open()
        names.addresses = [(second.host, second.port)]
        with anyio.move_on_after(0.0):
            await lane.rpc.pause(True)
        channel(lane)._drop("for the test")
        assert await lane.rpc.stop(True) == 0
        await lane.aclose()
        assert (first.names, second.names) == ([], ["stop"])
        assert names.asked == 2


async def test_a_name_without_a_thread_is_said_so(
    names: Names, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", none)
        with pytest.raises(ConnectError, match="can start no more threads"):
            await WireLane("test", NAME, 7003).open()


async def test_a_name_server_that_hangs_holds_up_neither_the_loop_nor_a_deadline(
    names: Names,
) -> None:
    with ScriptedServer() as server:
        names.addresses = [(server.host, server.port)]
        lane = WireLane("test", NAME, 7003, connect_timeout=PATIENCE)
        await lane.open()
        channel(lane)._drop("for the test")
        names.answers.clear()
        for _ in range(5):
            # a busy machine may begin it when no time is left
            with pytest.raises((ConnectError, NotSent), match=r"no answer in time|no time left"):
                await lane.call("pause", (True,), SHORT / 2)
        # all wait for one thread, which nothing can end
        assert names.asked == 2
        assert [thread.is_alive() for thread in names.threads[1:]] == [True]
        await eventually_async(lambda: lane.statistics().stuck == 1)
        assert lane.statistics().failed == 5
        names.answers.set()
        assert await lane.rpc.resume(True) == 0
        assert server.names == ["resume"]
        assert lane.statistics().stuck == 0
        await lane.aclose()


async def test_a_lane_closes_while_its_name_server_hangs(names: Names) -> None:
    names.answers.clear()
    lane = WireLane("test", NAME, 7003, connect_timeout=PATIENCE)
    raised: list[BaseException] = []

    async with anyio.create_task_group() as group:
        group.start_soon(noted, raised, ConnectionLost, lane.open())
        await eventually_async(lambda: names.asked == 1)
        group.cancel_scope.cancel()
    assert lane.closed
    assert raised == []
    names.answers.set()
    eventually(lambda: not names.threads[0].is_alive())


NEW, IDLE, ACTIVE = ConnectionState.NEW, ConnectionState.IDLE, ConnectionState.ACTIVE
POISONED, CLOSED = ConnectionState.POISONED, ConnectionState.CLOSED

EVENTS: dict[str, Callable[[Lifecycle], bool]] = {
    "opened": Lifecycle.opened,
    "begin": Lifecycle.begin,
    "complete": Lifecycle.complete,
    "poison": lambda life: life.poison("a reason"),
    "close": Lifecycle.close,
}

#: every transition that there is; any other event is refused and changes nothing
TRANSITIONS = {
    (NEW, "opened"): IDLE,
    (IDLE, "begin"): ACTIVE,
    (ACTIVE, "complete"): IDLE,
    (NEW, "poison"): POISONED,
    (IDLE, "poison"): POISONED,
    (ACTIVE, "poison"): POISONED,
    (NEW, "close"): CLOSED,
    (IDLE, "close"): CLOSED,
    (ACTIVE, "close"): CLOSED,
    (POISONED, "close"): CLOSED,
}

REACHED = {
    NEW: (),
    IDLE: ("opened",),
    ACTIVE: ("opened", "begin"),
    POISONED: ("poison",),
    CLOSED: ("close",),
}


@for_each("state, event", product(ConnectionState, EVENTS))
def test_each_event_in_each_state(state: ConnectionState, event: str) -> None:
    life = Lifecycle()
    for step in REACHED[state]:
        assert EVENTS[step](life)
    assert life.state is state
    happened = EVENTS[event](life)
    assert happened is ((state, event) in TRANSITIONS)
    assert life.state is TRANSITIONS.get((state, event), state)


def test_the_first_reason_stays() -> None:
    life = Lifecycle()
    life.poison("the first")
    life.poison("the second")
    life.close()
    assert life.reason == "the first"
    other = Lifecycle()
    other.close()
    assert other.reason


def test_each_call_begins_with_nothing_sent() -> None:
    life = Lifecycle()
    life.opened()
    seen = []
    for step in (life.begin, life.sent, life.answering, life.complete, life.begin):
        step()
        seen.append(life.progress)
    nothing, sent, answering = Progress.NOTHING_SENT, Progress.SENT, Progress.ANSWERING
    assert seen == [nothing, sent, answering, answering, nothing]
