"""The server, with a handler of a few lines behind it."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator, Sequence
from typing import Any, NoReturn

import psutil
import pytest
from thriftpy2.thrift import TApplicationException

from aioduco._wire import rpc
from aioduco.sim.refusal import Refusal
from aioduco.sim.server import Server
from aioduco.testing import eventually

from .raw import RawClient


def _no(name: str, _args: tuple[Any, ...]) -> NoReturn:
    raise Refusal(f"{name} is not simulated yet")


class Echo(rpc.RpcClient):
    """Answers with what it was called with."""

    def __init__(self) -> None:
        super().__init__(_no)
        self.calls: list[tuple[Any, ...]] = []
        self.entered = threading.Event()
        self.released = threading.Event()

    def movej2(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: rpc.Op,
        def_acc: bool,
    ) -> int:
        self.calls.append((joints_list, v, a, r, block, op, def_acc))
        return 4

    def get_robot_state(self) -> list[int]:
        return [6, 0, 5, 1]

    def rpc_heartbeat(self, time: int) -> None:
        self.calls.append((time,))

    def log_info(self, message: str) -> None:
        self.calls.append((message,))

    def get_tcp_pose(self) -> list[float]:
        raise ZeroDivisionError("of course")

    def get_global_speed(self) -> int:
        return 2**40

    def stop(self, block: bool) -> int:
        self.entered.set()
        self.released.wait(30)
        return 4


@pytest.fixture
def echo() -> Echo:
    return Echo()


@pytest.fixture
def server(echo: Echo) -> Iterator[Server]:
    with Server(echo) as server:
        yield server
        echo.released.set()


def test_a_call_is_answered(server: Server, echo: Echo) -> None:
    with RawClient(server.port) as client:
        op = rpc.Op(trig_event_1="spray")
        assert client.call("movej2", [0.1] * 6, 1.0, 2.0, 0.0, True, op, False) == 4
        assert client.call("get_robot_state") == [6, 0, 5, 1]
        assert client.call("rpc_heartbeat", 1000) is None
    assert echo.calls == [([0.1] * 6, 1.0, 2.0, 0.0, True, op, False), (1000,)]


def test_fields_left_out_are_zeros(server: Server, echo: Echo) -> None:
    with RawClient(server.port) as client:
        assert client.call("movej2", joints_list=[0.1] * 6) == 4
    assert echo.calls == [([0.1] * 6, 0.0, 0.0, 0.0, False, rpc.Op(), False)]


def test_fields_of_newer_clients_are_passed_over(server: Server, echo: Echo) -> None:
    with RawClient(server.port) as client:
        known = client.encode("rpc_heartbeat", 400)
        newer = b"\x0b\x00\x63\x00\x00\x00\x03new\x0f\x00\x64\x0b\x00\x00\x00\x01\x00\x00\x00\x01x"
        client.sock.sendall(known[:-1] + newer + b"\x00")
        assert client.answer("rpc_heartbeat") is None
    assert echo.calls == [(400,)]


def test_a_field_of_another_type_counts_as_left_out(server: Server, echo: Echo) -> None:
    with RawClient(server.port) as client:
        head = client.encode("rpc_heartbeat")[:-1]
        client.sock.sendall(head + b"\x0b\x00\x01\x00\x00\x00\x04" + b"1000" + b"\x00")
        assert client.answer("rpc_heartbeat") is None
    assert echo.calls == [(0,)]


def test_an_unknown_function_is_said_to_be_one_and_the_connection_goes_on(server: Server) -> None:
    with RawClient(server.port) as client:
        with pytest.raises(TApplicationException) as caught:
            client.call("make_coffee")
        assert caught.value.type == TApplicationException.UNKNOWN_METHOD
        assert client.call("get_robot_state") == [6, 0, 5, 1]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("get_tcp_pose", "ZeroDivisionError('of course')"),
        ("get_global_speed", "does not fit the wire"),
        ("servoj", "servoj is not simulated yet"),
    ],
)
def test_a_handler_that_fails_is_an_application_error(server: Server, name: str, text: str) -> None:
    with RawClient(server.port) as client:
        with pytest.raises(TApplicationException) as caught:
            client.call(name)
        assert caught.value.type == TApplicationException.INTERNAL_ERROR
        assert text in str(caught.value.message)
        assert client.call("get_robot_state") == [6, 0, 5, 1]


def test_text_that_is_not_utf8_is_refused_and_the_connection_goes_on(server: Server) -> None:
    with RawClient(server.port) as client:
        sane = client.encode("log_info", "ab")
        client.sock.sendall(sane.replace(b"ab", b"\xff\xfe"))
        with pytest.raises(TApplicationException) as caught:
            client.answer("log_info")
        assert caught.value.type == TApplicationException.PROTOCOL_ERROR
        assert client.call("log_info", "急停") is None


def test_calls_sent_together_are_answered_in_order(server: Server, echo: Echo) -> None:
    with RawClient(server.port) as client:
        client.sock.sendall(b"".join(client.encode("rpc_heartbeat", n) for n in range(100)))
        for _ in range(100):
            client.answer("rpc_heartbeat")
    assert echo.calls == [(n,) for n in range(100)]


def test_bytes_that_are_no_message_close_their_connection_only(server: Server) -> None:
    with RawClient(server.port) as good, RawClient(server.port) as bad:
        assert good.call("get_robot_state") == [6, 0, 5, 1]
        bad.sock.sendall(b"\x80\x01\x00\x01\x00\x00\x00\x04stop\x00\x00\x00\x01")
        bad.sock.sendall(b"\x0b\x00\x01" + struct.pack(">i", 2**31 - 1))
        assert bad.ended()
        assert good.call("get_robot_state") == [6, 0, 5, 1]
    eventually(lambda: server.connections == 0)


def test_a_hostile_peer_fills_no_log(server: Server, caplog: pytest.LogCaptureFixture) -> None:
    for _ in range(50):
        with RawClient(server.port) as bad:
            bad.sock.sendall(b"GET / HTTP/1.1\r\n\r\n")
            assert bad.ended()
    eventually(lambda: server.connections == 0)
    eventually(lambda: bool(caplog.records))  # a thread writes them
    assert len(caplog.records) <= 20


def test_a_call_that_waits_delays_no_other_connection(server: Server, echo: Echo) -> None:
    with RawClient(server.port) as waiting, RawClient(server.port) as other:
        waiting.sock.sendall(waiting.encode("stop", True))
        assert echo.entered.wait(10)
        assert other.call("get_robot_state") == [6, 0, 5, 1]
        echo.released.set()
        assert waiting.answer("stop") == 4


def test_an_answer_leaves_at_once_and_whole(server: Server) -> None:
    with RawClient(server.port) as client:
        client.sock.sendall(client.encode("get_robot_state"))
        assert client.sock.recv(4096).endswith(b"\x05\x01\x00")
    assert server.connections <= 1


def test_connections_beyond_the_limit_are_closed(echo: Echo) -> None:
    with Server(echo, max_connections=2) as server:
        clients = [RawClient(server.port) for _ in range(3)]
        assert clients[2].ended()
        assert clients[1].call("get_robot_state") == [6, 0, 5, 1]
        for client in clients:
            client.close()


def test_a_server_that_refuses_cuts_connections_until_it_does_not(server: Server) -> None:
    with RawClient(server.port) as before:
        before.call("get_robot_state")
        server.refuse(True)
        assert before.ended()
    with RawClient(server.port) as during:
        assert during.ended()
    server.refuse(False)
    with RawClient(server.port) as after:
        assert after.call("get_robot_state") == [6, 0, 5, 1]


def test_a_port_is_never_shared(server: Server, echo: Echo) -> None:
    with pytest.raises(OSError, match="in use"):
        Server(echo, port=server.port).start()


def test_closing_ends_every_thread_and_every_socket(echo: Echo) -> None:
    process = psutil.Process()
    # What a test before this one left may end meanwhile.
    threads, descriptors = set(threading.enumerate()), process.num_fds()
    server = Server(echo)
    server.start()
    clients = [RawClient(server.port) for _ in range(20)]
    for client in clients:
        client.call("get_robot_state")
    server.close()
    assert set(threading.enumerate()) <= threads
    assert all(client.ended() for client in clients)
    for client in clients:
        client.close()
    assert process.num_fds() <= descriptors
    assert "closed" in repr(server)
    server.close()


def test_the_port_is_free_again_at_once(echo: Echo) -> None:
    with Server(echo) as first, RawClient(first.port) as client:
        client.call("get_robot_state")
        port = first.port
    with Server(echo, port=port) as second, RawClient(second.port) as client:
        assert client.call("get_robot_state") == [6, 0, 5, 1]


def test_closing_says_which_call_does_not_end(echo: Echo) -> None:
    server = Server(echo)
    server.start()
    with RawClient(server.port) as client:
        client.sock.sendall(client.encode("stop", True))
        assert echo.entered.wait(10)
        with pytest.raises(TimeoutError, match="calls still run"):
            server.close(timeout=0.05)
        echo.released.set()
    eventually(lambda: server.connections == 0)


def test_listens_on_loopback_only_unless_told_otherwise(server: Server) -> None:
    listening = [
        connection.laddr.ip
        for connection in psutil.Process().net_connections("tcp")
        if connection.status == psutil.CONN_LISTEN and connection.laddr.port == server.port
    ]
    assert listening == ["127.0.0.1"]


def test_ipv6_is_served_where_there_is_any(echo: Echo) -> None:
    try:
        probe = socket.create_server(("::1", 0), family=socket.AF_INET6)
    except OSError:
        pytest.skip("this machine has no IPv6")
    probe.close()
    with (
        Server(echo, host="::1") as server,
        socket.create_connection(("::1", server.port), timeout=10) as sock,
    ):
        sock.sendall(b"\x80\x01\x00\x01\x00\x00\x00\x0fget_robot_state\x00\x00\x00\x01\x00")
        assert b"get_robot_state" in sock.recv(4096)
