"""A server that answers from a script."""

from __future__ import annotations

import pytest

from aioduco._wire.connection import Connection
from aioduco._wire.endpoint import Endpoint
from aioduco._wire.rpc import RpcClient
from aioduco.errors import ControllerError
from aioduco.sim.refusal import Refusal
from aioduco.testing import RecordingServer, no_leaks


def test_answers_as_it_was_told_and_remembers() -> None:
    def refuse(value: str) -> float:
        raise Refusal(f"no {value} here")

    with no_leaks(), RecordingServer({"read_word_reg": lambda num: num + 1, "stop": 0}) as server:
        connection = Connection(Endpoint(server.host, server.port))
        connection.open()
        client = RpcClient(lambda name, args: connection.call(name, args, 2.0))
        assert client.read_word_reg(7) == 8
        assert client.stop(True) == 0
        server.answer("stop", -1)
        assert client.stop(False) == -1
        server.answer("get_system_value_double", refuse)
        with pytest.raises(ControllerError, match="no speed here"):
            client.get_system_value_double("speed")
        with pytest.raises(ControllerError, match="pause has no answer"):
            connection.call("pause", (True,), 1.0)
        assert server.connections == 1
        connection.close()
    assert [(call.method, call.args) for call in server.received()] == [
        ("read_word_reg", (7,)),
        ("stop", (True,)),
        ("stop", (False,)),
        ("get_system_value_double", ("speed",)),
        ("pause", (True,)),
    ]
    assert len(server.received("stop")) == 2
    assert len({call.thread for call in server.received()}) == 1


def test_a_server_listens_once_at_a_time() -> None:
    with no_leaks():
        server = RecordingServer()
        with server, pytest.raises(RuntimeError, match="listens already"):
            server.__enter__()
        with server:
            pass


def test_knows_the_functions_of_the_wire() -> None:
    with pytest.raises(KeyError, match="no function 'movej3'"):
        RecordingServer({"movej3": 1})
