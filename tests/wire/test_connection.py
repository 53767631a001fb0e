"""One connection: what it returns, what it raises, and the state that it is left in."""

from __future__ import annotations

import random
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pytest
from for_each import for_each

from aioduco._wire import codec, deadline_socket, idl, nonblocking, rpc
from aioduco._wire.connection import Connection
from aioduco._wire.deadline_socket import DeadlineSocket
from aioduco._wire.endpoint import Endpoint, Route
from aioduco._wire.framing import MAX_REPLY
from aioduco._wire.lifecycle import ConnectionState, Progress
from aioduco.errors import (
    CallTimeout,
    ConnectError,
    ConnectionLost,
    ControllerError,
    OutcomeUnknown,
    ParameterError,
    UnknownFunction,
)
from aioduco.testing import eventually, no_leaks

from .names import NAME, Names
from .servers import (
    PATIENCE,
    Peer,
    ScriptedServer,
    black_hole,
    exception,
    held,
    honest,
    silent,
    zero,
)

#: seconds after which a server that says nothing is given up
SHORT = 0.1


@pytest.fixture(autouse=True)
def nothing_left() -> Iterator[None]:
    with no_leaks():
        yield


@contextmanager
def connected(*scripts: Callable[[Peer], None]) -> Iterator[tuple[Connection, ScriptedServer]]:
    with ScriptedServer(*scripts) as server:
        connection = Connection(Endpoint(server.host, server.port))
        connection.open()
        try:
            yield connection, server
        finally:
            connection.close()


def client(connection: Connection) -> rpc.RpcClient:
    """The functions of the wire over a connection."""
    return rpc.RpcClient(lambda name, args: connection.call(name, args, PATIENCE))


# What a call returns


@for_each(
    "name", ["getRobotStatus", "get_files_list", "get_last_error", "get_robot_version", "stop"]
)
def test_a_call_returns_what_the_controller_answers(name: str) -> None:
    with connected() as (connection, _):
        args = {"get_files_list": ("/",), "stop": (True,)}.get(name, ())
        assert connection.call(name, args, PATIENCE) == zero(name)


def test_a_caller_is_told_while_it_waits_for_an_answer() -> None:
    told = threading.Event()
    calls: list[None] = []

    def waiting() -> None:
        calls.append(None)
        if len(calls) == 3:
            told.set()

    def patient(peer: Peer) -> None:
        call = peer.take()
        told.wait(PATIENCE)
        peer.answer(call, True)

    with ScriptedServer(patient) as server:
        connection = Connection(Endpoint(server.host, server.port), waiting=waiting)
        connection.open()
        assert connection.call("robotmoving", (), PATIENCE) is True
        connection.close()
    assert told.is_set()


def test_arguments_arrive_as_they_were_given() -> None:
    op = rpc.Op(trig_io_1=3, trig_value_1=True, trig_event_1="焊接")
    with connected() as (connection, server):
        client(connection).movej2([0.1, -0.2, 0.3, 0.0, 1.5, -3.0], 0.5, 1.0, 0.01, False, op, True)
        (call,) = server.calls
        assert call.args == ([0.1, -0.2, 0.3, 0.0, 1.5, -3.0], 0.5, 1.0, 0.01, False, op, True)


def test_a_function_without_a_result_returns_none() -> None:
    with connected() as (connection, server):
        client(connection).log_info("schön")
        assert connection.call("rpc_heartbeat", (1000,), PATIENCE) is None
        assert server.names == ["log_info", "rpc_heartbeat"]


def test_states_and_repr_of_a_life() -> None:
    with ScriptedServer() as server:
        connection = Connection(Endpoint(server.host, server.port))
        address = f"{server.host}:{server.port}"
        assert repr(connection) == f"<Connection {address} NEW, 0 calls>"
        connection.open()
        assert repr(connection) == f"<Connection {address} IDLE, 0 calls>"
        client(connection).stop(True)
        # header, name, sequence id, the field of the answer and the stop byte
        assert connection._exchange.end == 8 + len("stop") + 4 + 7 + 1
        connection.close()
        assert repr(connection) == f"<Connection {address} CLOSED: it was closed, 1 calls>"
        connection.close()


def test_the_programs_own_random_numbers_stay_as_it_has_seeded_them() -> None:
    before = random.getstate()
    with connected() as (connection, _):
        client(connection).stop(True)
    assert random.getstate() == before


def test_sequence_ids_rise_and_begin_again() -> None:
    with connected() as (connection, server):
        connection._exchange._last = codec.LAST_SEQUENCE - 1
        for _ in range(3):
            client(connection).stop(True)
        assert [call.raw.seqid for call in server.calls] == [codec.LAST_SEQUENCE, 1, 2]


def test_one_call_is_one_piece_on_the_wire() -> None:
    """The vendor's client writes each field by itself, which costs 40 ms a call."""
    function = idl.functions()["servoj"]
    args = ([0.0] * 6, 1.0, 1.0, False, 200.0, 25.0, 10.0, 1.0)
    pieces = []

    def script(peer: Peer) -> None:
        pieces.append(len(peer.sock.recv(65536)))

    with connected(script) as (connection, server):
        with pytest.raises(OutcomeUnknown):
            connection.call("servoj", args, PATIENCE)
        server.wait_finished(1)
        assert pieces == [len(codec.message(function, 1, codec.encode(function, args)))]


def test_socket_options() -> None:
    with connected() as (connection, _):
        stream = connection._stream
        assert stream is not None
        get = stream.socket.getsockopt
        assert get(socket.IPPROTO_TCP, socket.TCP_NODELAY)
        assert get(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        idle = get(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE)
        probes = get(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL) * get(
            socket.IPPROTO_TCP, socket.TCP_KEEPCNT
        )
        assert idle + probes <= 10
        assert get(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) <= 10_000


# Opening


def test_a_refused_port() -> None:
    with socket.create_server(("127.0.0.1", 0)) as closed:
        host, port = closed.getsockname()
    connection = Connection(Endpoint(host, port))
    with pytest.raises(
        ConnectError, match=rf"cannot connect to {host}:{port}: .*refused; .*start the controller"
    ) as raised:
        connection.open()
    assert raised.value.host == host
    assert raised.value.port == port
    assert isinstance(raised.value.__cause__, ConnectionRefusedError)
    assert connection.state is ConnectionState.POISONED


@for_each("host", ["x" * 70, "a..b"])
def test_a_host_that_cannot_be(host: str) -> None:
    with pytest.raises(ConnectError, match=r"unknown host|must be a name or an address"):
        Connection(Endpoint(host, 7003)).open()


@pytest.mark.parametrize("limit", ["its own", "the caller's, which is sooner"])
def test_a_controller_that_does_not_answer_the_handshake(limit: str) -> None:
    own = limit == "its own"
    with black_hole() as (host, port):
        connection = Connection(Endpoint(host, port, SHORT if own else 100 * PATIENCE))
        begin = time.monotonic()
        with pytest.raises(ConnectError, match="no answer in time; check the address"):
            connection.open(None if own else begin + SHORT)
        assert time.monotonic() - begin >= SHORT * 0.9


def test_all_addresses_of_a_host_are_tried(names: Names) -> None:
    with socket.create_server(("127.0.0.1", 0)) as closed:
        dead = closed.getsockname()
    with ScriptedServer() as server:
        names.addresses = [dead, (server.host, server.port)]
        connection = Connection(Endpoint(NAME, 7003))
        connection.open()
        assert client(connection).stop(True) == 0
        connection.close()


def test_an_address_that_does_not_answer_leaves_time_for_the_others(names: Names) -> None:
    """And the connections that share its route begin with the one that connected."""
    with black_hole() as dead, ScriptedServer() as server:
        names.addresses = [dead, (server.host, server.port)]
        route = Route()
        for patience in (2.0, 100 * PATIENCE):
            connection = Connection(Endpoint(NAME, 7003, patience, route=route))
            connection.open()
            assert client(connection).stop(True) == 0
            connection.close()


def test_each_address_gets_a_fair_share_of_the_time() -> None:
    one, two, three = [(2, 1, 6, "", (f"10.0.0.{number}", 7003)) for number in (1, 2, 3)]
    route = Route()
    deadline = time.monotonic() + 9e5
    tries = list(route.tries([one, two, two, three], deadline))
    assert [each for each, _ in tries] == [one, two, three]
    shares = [until - deadline + 9e5 for _, until in tries]  # nothing of the time was used
    assert shares == pytest.approx([3e5, 4.5e5, 9e5], rel=1e-3)
    route.address = three[-1]
    assert [each for each, _ in route.tries([one, two, three], deadline)] == [three, one, two]
    route.address = ("10.0.0.9", 7003)  # the host has moved since
    assert [each for each, _ in route.tries([one, two], deadline)] == [one, two]
    assert not list(route.tries([one, two], time.monotonic()))


def test_a_connection_is_opened_once() -> None:
    with connected() as (connection, _):
        with pytest.raises(ConnectionLost, match="cannot be opened again"):
            connection.open()
        assert client(connection).stop(True) == 0


# Deadlines


@for_each(
    "name, args, error",
    [
        ("get_tcp_pose", (), CallTimeout),
        ("movej", ([0.0] * 6, 1.0, 1.0, 0.0, True, rpc.Op(), False), OutcomeUnknown),
        ("stop", (True,), OutcomeUnknown),
        ("read_raw_data_485", (8,), OutcomeUnknown),
    ],
)
def test_a_silent_controller(name: str, args: tuple[Any, ...], error: type[Exception]) -> None:
    gone = []

    def script(peer: Peer) -> None:
        peer.receive()
        gone.append(peer.wait_gone())

    with connected(script) as (connection, server):
        begin = time.monotonic()
        with pytest.raises(error, match=name):
            connection.call(name, args, SHORT)
        assert time.monotonic() - begin >= SHORT
        assert connection.state is ConnectionState.POISONED
        assert "POISONED: no answer came in time" in repr(connection)
        # the socket is closed at once, not when somebody collects the garbage
        server.wait_finished(1)
        assert gone == [True]
        assert server.names == [name]


def test_an_answer_that_came_while_the_caller_did_not_run_is_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The deadline has passed when the caller looks, and the answer is there."""
    with connected() as (connection, _):
        deadline = time.monotonic() + PATIENCE

        def held_up() -> None:
            assert connection.answers_within(PATIENCE)
            monkeypatch.setattr(
                deadline_socket, "time", SimpleNamespace(monotonic=lambda: deadline)
            )

        stop = idl.functions()["stop"]
        arguments = codec.encode(stop, (True,))
        assert connection.exchange(stop, arguments, deadline, held_up) == zero("stop")
        monkeypatch.undo()
        assert client(connection).get_robot_version() == "3.8"


def test_a_connection_that_was_made_while_the_caller_did_not_run_is_taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        address = listener.family, listener.type, 0, "", listener.getsockname()
        stream = deadline_socket.DeadlineSocket(address)
        stream.connect(time.monotonic() - 1.0)
        assert stream.has_peer
        stream.discard()


@pytest.mark.slow
def test_a_drip_feeding_controller_does_not_stretch_the_deadline() -> None:
    """Each byte comes long before any time-out on a single read, for as long as one likes."""

    def drip(peer: Peer) -> None:
        call = peer.take()
        head = b"\x80\x01\x00\x02\x00\x00\x00\x0cget_tcp_pose" + struct.pack("!i", call.raw.seqid)
        peer.sock.sendall(head + b"\x0f\x00\x00\x04" + struct.pack("!i", MAX_REPLY // 16))
        try:
            while True:
                peer.sock.send(b"\x00")
        except OSError:
            return

    with connected(drip) as (connection, server):
        begin = time.monotonic()
        with pytest.raises(CallTimeout):
            connection.call("get_tcp_pose", (), SHORT)
        # not the minutes that the bytes would take
        assert time.monotonic() - begin < PATIENCE
        server.wait_finished(1)


@pytest.mark.slow
def test_a_controller_that_takes_no_bytes_ends_a_long_command() -> None:
    ended = threading.Event()

    def deaf(peer: Peer) -> None:
        ended.wait(PATIENCE)

    with connected(deaf) as (connection, _):
        function = idl.functions()["log_info"]
        # more than the system takes in on both sides
        arguments = codec.encode(function, ("x" * 40_000_000,))
        try:
            with pytest.raises(OutcomeUnknown, match="log_info"):
                connection.exchange(function, arguments, time.monotonic() + 10 * SHORT)
        finally:
            ended.set()
        assert connection.progress is Progress.SENT


@pytest.mark.slow
def test_long_calls_and_long_replies_are_whole() -> None:
    points = [[float(i)] * 6 for i in range(20_000)]
    lists = [[float(i)] * 7 for i in range(30_000)]

    def script(peer: Peer) -> None:
        while (call := peer.receive()) is not None:
            peer.answer(call, lists if call.name == "get_system_value_lists" else None)

    with connected(script) as (connection, server):
        assert connection.call("trackEnqueue", (points, False), PATIENCE) == 0
        assert server.calls[0].args == (points, False)
        assert connection.call("get_system_value_lists", ("g",), PATIENCE) == lists
        assert connection.state is ConnectionState.IDLE


@pytest.mark.linux("sends that keep the interpreter's lock")
def test_a_call_is_sent_before_another_thread_can_run(monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[bytes] = []

    def keep(descriptor: int, data: bytes) -> int:
        sent.append(data)
        return nonblocking.send_at_once(descriptor, data)

    monkeypatch.setattr(deadline_socket, "send_at_once", keep)
    with connected() as (connection, _):
        assert connection.call("stop", (True,), PATIENCE) == 0
    assert [b"stop" in data for data in sent] == [True]


@pytest.mark.linux("reads that keep the interpreter's lock")
@for_each("how", ["silence", "bytes", "end", "reset"])
def test_what_a_socket_has_to_read(how: str) -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as listener,
        socket.create_connection(listener.getsockname()) as here,
        listener.accept()[0] as there,
    ):
        if how == "bytes":
            there.send(b"x")
        elif how == "end":
            there.shutdown(socket.SHUT_WR)
        elif how == "reset":
            there.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            there.close()
        assert nonblocking.is_silent(here.fileno()) == (how == "silence")


def test_a_call_without_time_left_is_not_sent() -> None:
    with connected() as (connection, server):
        with pytest.raises(ConnectionLost, match="stop was not sent"):
            connection.call("stop", (True,), -1.0)
        assert connection.state is ConnectionState.IDLE
        client(connection).pause(True)
        assert server.names == ["pause"]


def limits() -> list[float]:
    """The system's limit on a read after calls with different times; 0.0 for none."""
    with connected() as (connection, _):
        stream = connection._stream
        assert stream is not None
        seen = []
        for timeout in (None, 2.0, 2.0, 0.5, 30.0, None, 1.0):
            connection.call("stop", (True,), PATIENCE if timeout is None else timeout)
            connection.call("stop", (True,), timeout)
            raw = stream.socket.getsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, 16)
            seconds, micro = struct.unpack("@ll", raw)
            seen.append(float(seconds + micro / 1e6))
    return seen


@pytest.mark.linux("SO_RCVTIMEO and SO_SNDTIMEO, with which a socket stays usable")
def test_the_systems_limit_follows_the_deadline() -> None:
    seen: list[float] = []
    thread = threading.Thread(target=lambda: seen.extend(limits()), name="caller")
    thread.start()
    thread.join()
    for timeout, was in zip((2.0, 2.0, 0.5, 30.0), seen[1:5], strict=True):
        assert timeout * 0.5 < was < timeout + 0.1
    assert seen[0] == seen[5] == 0.0


@pytest.mark.linux("SO_RCVTIMEO and SO_SNDTIMEO, with which a socket stays usable")
def test_the_main_thread_can_take_a_signal_now_and_then() -> None:
    """One that comes just before a wait begins does not end the wait."""
    assert all(0.0 < limit < 2 * deadline_socket.WAKE_EVERY for limit in limits())


# What leaves a connection usable, and what does not


@pytest.mark.parametrize(
    ("code", "error"), [(1, UnknownFunction), (6, ControllerError), (7, ControllerError)]
)
def test_an_application_error_is_an_answer(code: int, error: type[ControllerError]) -> None:
    def script(peer: Peer) -> None:
        call = peer.take()
        peer.send(exception(call.raw, code, "no"))
        honest(peer)

    with connected(script) as (connection, _):
        with pytest.raises(error) as raised:
            client(connection).abort(True)
        assert raised.value.function == "abort"
        assert connection.state is ConnectionState.IDLE
        assert client(connection).stop(True) == 0


def test_a_value_that_cannot_be_sent_leaves_the_connection_alone() -> None:
    with connected() as (connection, server):
        with pytest.raises(ParameterError):
            client(connection).get_noneblock_taskstate(2**40)
        assert connection.state is ConnectionState.IDLE
        assert client(connection).stop(True) == 0
        assert server.names == ["stop"]


@pytest.mark.parametrize(
    ("error", "raised"),
    [
        (KeyboardInterrupt, KeyboardInterrupt),
        (TimeoutError, TimeoutError),  # of a signal handler; those of the system have a number
        (MemoryError, OutcomeUnknown),
    ],
)
def test_an_interrupt_in_mid_call_poisons(
    monkeypatch: pytest.MonkeyPatch, error: type[BaseException], raised: type[BaseException]
) -> None:
    with connected(silent) as (connection, server):

        def interrupted(*_: object) -> bytes:
            raise error

        monkeypatch.setattr(DeadlineSocket, "receive", interrupted)
        with pytest.raises(raised):
            client(connection).stop(True)
        assert connection.state is ConnectionState.POISONED
        assert error.__name__ in connection.reason
        server.wait_finished(1)


@for_each("state", ["new", "closed", "poisoned"])
def test_a_connection_that_is_not_open_sends_nothing(state: str) -> None:
    with connected(silent) as (connection, server):
        if state == "new":
            other = Connection(Endpoint(server.host, server.port))
            other._owner = threading.get_ident()
        else:
            other = connection
            if state == "closed":
                connection.close()
            else:
                with pytest.raises(CallTimeout):
                    connection.call("get_tcp_pose", (), SHORT)
        with pytest.raises(ConnectionLost, match=f"stop cannot use .*{state.upper()}.*nothing was"):
            client(other).stop(True)
        assert "stop" not in server.names


# Threads


def test_only_the_owner_may_call(background: Any) -> None:
    with connected() as (connection, server):
        error = background(lambda: client(connection).stop(True))()
        assert isinstance(error, RuntimeError)
        assert "belongs to the thread" in str(error)
        assert connection.state is ConnectionState.IDLE
        assert server.calls == []


@pytest.mark.parametrize(
    ("name", "args", "error"),
    [("get_tcp_pose", (), ConnectionLost), ("pause", (True,), OutcomeUnknown)],
)
def test_abandon_wakes_a_call_that_waits_for_ever(
    background: Any, name: str, args: tuple[Any, ...], error: type[Exception]
) -> None:
    with ScriptedServer(silent) as server:
        connection = Connection(Endpoint(server.host, server.port))

        def work() -> None:
            connection.open()
            connection.call(name, args, None)

        outcome = background(work)
        server.wait_calls(1)
        connection.abandon("the program has something better to do")
        assert type(outcome()) is error
        assert "something better to do" in str(outcome())
        assert connection.state is ConnectionState.POISONED
        server.wait_finished(1)


def test_abandon_wakes_a_handshake(background: Any) -> None:
    with black_hole() as (host, port):
        connection = Connection(Endpoint(host, port, PATIENCE * 10))
        outcome = background(connection.open)
        eventually(lambda: connection._stream is not None)
        connection.abandon("enough")
        error = outcome()
        assert isinstance(error, ConnectionLost)
        assert "nothing was sent" in str(error)


@pytest.mark.parametrize("moment", ["before the socket is there", "before the handshake begins"])
def test_abandon_is_seen_at_every_moment_of_a_handshake(
    moment: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is there yet that could be shut down, and the handshake would take for ever."""
    with black_hole() as (host, port):
        connection = Connection(Endpoint(host, port, PATIENCE * 10))
        made, connect = DeadlineSocket.__init__, DeadlineSocket.connect

        def slow_make(stream: DeadlineSocket, *args: Any) -> None:
            connection.abandon("enough")
            made(stream, *args)

        def slow_connect(stream: DeadlineSocket, deadline: float) -> None:
            connection.abandon("enough")
            connect(stream, deadline)

        if moment == "before the socket is there":
            monkeypatch.setattr(DeadlineSocket, "__init__", slow_make)
        else:
            monkeypatch.setattr(DeadlineSocket, "connect", slow_connect)
        begin = time.monotonic()
        with pytest.raises(ConnectionLost, match="given up while it was made: enough"):
            connection.open()
        assert time.monotonic() - begin < PATIENCE
        assert connection._stream is None


def test_what_is_abandoned_before_it_is_opened_stays_closed() -> None:
    with ScriptedServer() as server:
        connection = Connection(Endpoint(server.host, server.port))
        connection.abandon("too late")
        with pytest.raises(ConnectionLost, match="too late"):
            connection.open()
        assert server.connections == 0


def test_an_answer_that_comes_with_an_abandon_is_not_given(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever abandoned the call has told its caller that the answer is lost."""
    with connected() as (connection, _):
        receive = DeadlineSocket.receive

        def late(stream: DeadlineSocket, deadline: float | None) -> bytes:
            data = receive(stream, deadline)
            connection.abandon("cancelled")
            return data

        monkeypatch.setattr(DeadlineSocket, "receive", late)
        with pytest.raises(OutcomeUnknown, match="cancelled"):
            client(connection).stop(True)
        assert connection.state is ConnectionState.POISONED


def test_a_connection_left_open_warns() -> None:
    with ScriptedServer() as server:
        connection = Connection(Endpoint(server.host, server.port))
        connection.open()
        held = [connection]
        del connection
        with pytest.warns(ResourceWarning, match=r"unclosed <Connection .* IDLE"):
            held.clear()
        server.wait_finished(1)


def test_a_connection_whose_socket_the_interpreter_has_closed_closes() -> None:
    """At its exit it may do that before the object of the vendor's class is collected."""
    with connected() as (connection, _):
        stream = connection._stream
        assert stream is not None
        stream.socket.close()
        connection.close()
        assert connection.state is ConnectionState.CLOSED


def test_a_long_wait_of_the_main_thread_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deadline_socket, "WAKE_EVERY", 0.01)
    limit_to = DeadlineSocket._limit_to
    looks: list[float | None] = []
    enough = threading.Event()

    def counted(stream: DeadlineSocket, deadline: float | None) -> None:
        looks.append(deadline)
        if len(looks) > 8:
            enough.set()
        limit_to(stream, deadline)

    with connected(held(enough)) as (connection, _):
        monkeypatch.setattr(DeadlineSocket, "_limit_to", counted)
        assert client(connection).get_robot_version() == "3.8"
