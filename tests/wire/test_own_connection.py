"""The connection of one thread: opened again for a call, and never after it was given up."""

from __future__ import annotations

import time

import pytest

from aioduco._wire.endpoint import Endpoint
from aioduco._wire.own_connection import OwnConnection
from aioduco.errors import ConnectionLost

from .servers import PATIENCE, Peer, ScriptedServer


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
