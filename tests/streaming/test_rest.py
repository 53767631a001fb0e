"""A worker that brings the arm to rest, on its one thread: it looks on until it has seen it."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest
from wire.servers import PATIENCE, Peer, ScriptedServer

from aioduco._wire.endpoint import Endpoint
from aioduco._wire.own_connection import OwnConnection
from aioduco.streaming.worker.rest import bring_to_rest
from aioduco.supervision.unanswered import UnansweredMotion


def moving(count: int) -> Callable[[Peer], None]:
    """An arm that is seen to move some times."""
    left = count

    def script(peer: Peer) -> None:
        nonlocal left
        while (call := peer.receive()) is not None:
            left -= call.name == "robotmoving"
            peer.answer(call, left >= 0 if call.name == "robotmoving" else 4)

    return script


def rest(server: ScriptedServer, seconds: float, *, stops: bool) -> tuple[bool, int]:
    """Whether the arm was brought to rest, and how often the worker showed that it runs."""
    own = OwnConnection(Endpoint(server.host, server.port, PATIENCE))
    own.ready()
    signs: list[None] = []
    now = time.monotonic()
    motion = UnansweredMotion.none(now, now + seconds, stops=stops)
    try:
        return bring_to_rest(motion, own, PATIENCE, lambda: signs.append(None)), len(signs)
    finally:
        own.close()


@pytest.mark.parametrize("count", [0, 3])
def test_it_is_seen_to_stand_twice(count: int) -> None:
    with ScriptedServer(moving(count)) as server:
        stands, signs = rest(server, PATIENCE, stops=False)
        assert stands
        assert server.names == ["robotmoving"] * (count + 2)
        assert signs == count + 3
        assert server.connections == 1


def test_a_connection_that_breaks_meanwhile_is_replaced() -> None:
    def breaks(peer: Peer) -> None:
        peer.receive()
        peer.reset()

    with ScriptedServer(breaks, moving(1)) as server:
        stands, _ = rest(server, PATIENCE, stops=False)
        assert stands
        assert server.connections == 2
        assert "stop" not in server.names


def test_an_arm_that_moves_on_is_given_up() -> None:
    with ScriptedServer(moving(10**9)) as server:
        stands, _ = rest(server, 0.05, stops=False)
        assert not stands
        assert "stop" not in server.names
