"""Each fault does to a call what it says, and the records say what was done."""

from __future__ import annotations

import errno
import math
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from typing import Any

import anyio
import pytest
from for_each import for_each

from aioduco._wire.messages import Message, MessageType, application_error
from aioduco.errors import ParameterError
from aioduco.testing import (
    ApplicationError,
    Chaos,
    Cut,
    Delay,
    DropReply,
    DropRequest,
    Ending,
    Fault,
    FaultProxy,
    Garbage,
    HalfOpen,
    HoldReply,
    Place,
    RepeatReply,
    Throttle,
    WrongKind,
    WrongMethod,
    WrongSeqid,
    eventually,
    no_leaks,
)
from aioduco.testing.faults import Script

from .echo import EchoServer, call, replies


@pytest.fixture
def server() -> Iterator[EchoServer]:
    with no_leaks(), EchoServer() as server:
        yield server


@pytest.fixture
def proxy(server: EchoServer) -> Iterator[FaultProxy]:
    with no_leaks(), FaultProxy("127.0.0.1", server.port) as proxy:
        yield proxy


@pytest.fixture
def client(proxy: FaultProxy) -> Iterator[socket.socket]:
    with connected(proxy) as client:
        yield client


def connected(proxy: FaultProxy) -> socket.socket:
    return socket.create_connection((proxy.host, proxy.port), timeout=10)


def exchange(client: socket.socket, message: Message) -> Message:
    client.sendall(message.encode())
    return next(replies(client))


def reply_to(message: Message) -> Message:
    return replace(message, kind=MessageType.REPLY)


def nothing_comes(client: socket.socket) -> bool:
    """Nothing has come, and the connection is open. Only after what would come would be there."""
    client.setblocking(False)
    try:
        client.recv(1)
    except BlockingIOError:
        return True
    finally:
        client.settimeout(10)
    return False


def test_passes_calls_and_replies_on(
    proxy: FaultProxy, server: EchoServer, client: socket.socket
) -> None:
    sent = [call("read_word_reg", seqid, f"{seqid}") for seqid in range(20)]
    assert [exchange(client, message) for message in sent] == [reply_to(m) for m in sent]
    assert server.received == sent
    eventually(lambda: proxy.calls()[-1].answered is not None)
    for record, message in zip(proxy.calls(), sent, strict=True):
        assert (record.connection, record.request, record.fault) == (0, message, None)
        assert record.forwarded is not None
        assert record.replied is not None
        assert record.answered is not None
        assert record.received <= record.forwarded <= record.replied <= record.answered
    assert proxy.statistics() == (1, 1, 20, 0)
    client.close()
    eventually(lambda: proxy.connections()[0].ended_by == "client")
    eventually(lambda: server.ended == 1)


def test_a_request_in_single_bytes_arrives_whole(server: EchoServer, client: socket.socket) -> None:
    message = call("movej2", 5, "slow")
    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    for byte in message.encode():
        client.send(bytes([byte]))
    assert next(replies(client)) == reply_to(message)
    assert server.received == [message]


def test_bytes_that_are_no_message_are_passed_on_as_they_are(
    server: EchoServer, client: socket.socket
) -> None:
    client.sendall(b"not thrift at all")
    client.shutdown(socket.SHUT_WR)
    assert client.recv(100) == b""
    eventually(lambda: server.rest == [b"not thrift at all"])


def test_whoever_closes_is_seen_by_the_other(
    proxy: FaultProxy, server: EchoServer, client: socket.socket
) -> None:
    exchange(client, call())
    server.__exit__(None, None, None)
    assert client.recv(1) == b""
    client.close()
    eventually(lambda: proxy.connections()[0].ended_by == "server")


def test_a_server_that_is_not_there_resets(proxy: FaultProxy, server: EchoServer) -> None:
    server.__exit__(None, None, None)
    # the reset may come as early as while connecting
    with pytest.raises(ConnectionResetError), connected(proxy) as client:
        client.recv(1)


@pytest.mark.parametrize("how", Ending)
@pytest.mark.parametrize(
    ("place", "reaches", "replied", "answered"),
    [
        (Place.BEFORE_REQUEST, False, False, False),
        (Place.IN_REQUEST, False, False, False),
        (Place.AFTER_REQUEST, True, False, False),
        (Place.BEFORE_REPLY, True, True, False),
        (Place.IN_REPLY, True, True, False),
        (Place.AFTER_REPLY, True, True, True),
    ],
)
def test_a_cut_ends_the_connection_at_its_place(
    proxy: FaultProxy,
    server: EchoServer,
    client: socket.socket,
    how: Ending,
    place: Place,
    reaches: bool,
    replied: bool,
    answered: bool,
) -> None:
    proxy.on("movej2", Cut(place, how))
    first, second = call("stop", 1), call("movej2", 2, "x" * 100)
    assert exchange(client, first) == reply_to(first)
    client.sendall(second.encode())
    got, ending = b"", Ending.CLOSE
    try:
        while data := client.recv(4096):
            got += data
    except ConnectionResetError:
        ending = Ending.RESET
    assert ending is how
    whole = reply_to(second).encode()
    if answered:
        assert got == whole
    else:
        assert whole.startswith(got)
        assert 0 < len(got) < len(whole) if place is Place.IN_REPLY else not got
    eventually(lambda: server.ended == 1)
    assert server.received == [first, second] if reaches else [first]
    if place is Place.IN_REQUEST:
        assert 0 < len(server.rest[0]) < len(second.encode())
    (record,) = proxy.calls("movej2")
    assert (record.forwarded is not None) == reaches
    assert (record.replied is not None) == replied
    assert (record.answered is not None) == answered
    eventually(lambda: proxy.connections()[0].ended_by == "fault")


@pytest.mark.parametrize(("fault", "received"), [(DropRequest(), [2]), (DropReply(), [1, 2])])
def test_what_is_dropped_does_not_arrive(
    proxy: FaultProxy, server: EchoServer, client: socket.socket, fault: Fault, received: list[int]
) -> None:
    proxy.next(fault)
    client.sendall(call(seqid=1).encode())
    assert exchange(client, call(seqid=2)).seqid == 2
    assert [message.seqid for message in server.received] == received
    record = proxy.calls()[0]
    assert (record.forwarded is None) == (record.replied is None) == (received == [2])
    assert record.answered is None


def test_a_held_reply_comes_before_the_next_one(
    proxy: FaultProxy, server: EchoServer, client: socket.socket
) -> None:
    proxy.next(HoldReply())
    client.sendall(call(seqid=1).encode())
    eventually(lambda: proxy.calls()[0].replied is not None if proxy.calls() else False)
    assert nothing_comes(client)
    client.sendall(call(seqid=2).encode())
    stream = replies(client)
    assert [next(stream).seqid, next(stream).seqid] == [1, 2]


def test_a_half_open_connection_passes_nothing_on_and_stays(
    proxy: FaultProxy, server: EchoServer, client: socket.socket
) -> None:
    exchange(client, call(seqid=1))
    proxy.on("movej2", HalfOpen())
    client.sendall(call("movej2", 2).encode() + call("stop", 3).encode())
    eventually(lambda: len(proxy.calls("movej2")) == 1)
    with connected(proxy) as other:
        exchange(other, call(seqid=4))
    assert nothing_comes(client)
    assert [message.seqid for message in server.received] == [1, 4]
    assert proxy.connections()[0].closed is None


def test_a_half_open_connection_is_reset_after_its_time(
    proxy: FaultProxy, client: socket.socket
) -> None:
    proxy.next(HalfOpen(seconds=0.01))
    client.sendall(call().encode())
    with pytest.raises(ConnectionResetError):
        client.recv(1)


ASKED = call("read_word_reg", 5, "five")
RIGHT = reply_to(ASKED)


@pytest.mark.parametrize(
    ("fault", "answer"),
    [
        (RepeatReply(), RIGHT.encode() * 2),
        (RepeatReply(3), RIGHT.encode() * 4),
        (Garbage(b"\xde\xad\xbe\xef"), b"\xde\xad\xbe\xef"),
        (Garbage(b"\x00", reply=True), b"\x00" + RIGHT.encode()),
        (WrongSeqid(), replace(RIGHT, seqid=4).encode()),
        (WrongSeqid(2**31 - 1), replace(RIGHT, seqid=-(2**31) + 4).encode()),
        (WrongMethod("stop"), replace(RIGHT, name="stop").encode()),
        (WrongKind(), replace(RIGHT, kind=MessageType.CALL).encode()),
        (ApplicationError(6, "no", forward=True), application_error(ASKED, 6, "no").encode()),
    ],
    ids=repr,
)
def test_a_reply_is_rewritten(
    proxy: FaultProxy, server: EchoServer, client: socket.socket, fault: Fault, answer: bytes
) -> None:
    after = call("stop", 6)
    proxy.next(fault)
    client.sendall(ASKED.encode() + after.encode())
    whole = answer + reply_to(after).encode()
    got = b""
    while len(got) < len(whole):
        got += client.recv(4096)
    assert got == whole
    assert server.received == [ASKED, after]
    assert [record.fault for record in proxy.calls()] == [fault, None]


def test_an_application_error_overtakes_no_reply_of_a_batch(
    proxy: FaultProxy, server: EchoServer, client: socket.socket
) -> None:
    proxy.on("stop", ApplicationError(1, "no"), times=None)
    sent = [call(name, seqid) for seqid, name in enumerate(["movej2", "stop", "stop", "movej2"])]
    client.sendall(b"".join(message.encode() for message in sent))
    came = replies(client)
    assert [next(came) for _ in sent] == [
        application_error(each, 1, "no") if each.name == "stop" else reply_to(each) for each in sent
    ]
    assert [message.seqid for message in server.received] == [0, 3]


def test_a_delay_holds_request_and_reply_back(proxy: FaultProxy, client: socket.socket) -> None:
    proxy.next(Delay(request=0.02, reply=0.03))
    start = time.monotonic()
    exchange(client, call())
    assert time.monotonic() - start >= 0.05
    eventually(lambda: proxy.calls()[0].answered is not None)
    (record,) = proxy.calls()
    assert record.forwarded is not None
    assert record.replied is not None
    assert record.answered is not None
    assert record.forwarded - record.received >= 0.02
    assert record.answered - record.replied >= 0.03


def test_a_throttled_call_takes_as_long_as_its_bytes(
    proxy: FaultProxy, client: socket.socket
) -> None:
    message = call(payload="x" * 1000)
    size = len(message.encode())
    proxy.next(Throttle(rate=size / 0.05))
    start = time.monotonic()
    assert exchange(client, message) == reply_to(message)
    assert time.monotonic() - start >= 0.1


def test_refused_connections_find_nobody_listening_and_others_stay(
    proxy: FaultProxy, client: socket.socket
) -> None:
    exchange(client, call(seqid=1))
    for _ in range(3):
        proxy.refuse()
        with pytest.raises(ConnectionRefusedError):
            connected(proxy)
        exchange(client, call(seqid=2))
        proxy.accept()
        with connected(proxy) as other:
            exchange(other, call(seqid=3))
    proxy.refuse()
    proxy.refuse()
    proxy.clear()
    connected(proxy).close()


def test_a_frozen_proxy_holds_all_back_until_it_thaws(
    proxy: FaultProxy, server: EchoServer, client: socket.socket
) -> None:
    exchange(client, call(seqid=1))
    proxy.freeze()
    client.sendall(call(seqid=2).encode())
    eventually(lambda: len(proxy.calls()) == 2)
    assert nothing_comes(client)
    assert len(server.received) == 1
    proxy.thaw()
    assert next(replies(client)).seqid == 2


@pytest.mark.parametrize("how", Ending)
def test_a_cut_of_everything_ends_all_connections(
    proxy: FaultProxy, server: EchoServer, how: Ending
) -> None:
    clients = [connected(proxy) for _ in range(5)]
    for client in clients:
        exchange(client, call())
    proxy.cut(how)
    assert proxy.statistics().open == 0
    for client in clients:
        with client:
            if how is Ending.RESET:
                with pytest.raises(ConnectionResetError):
                    client.recv(1)
            else:
                assert client.recv(1) == b""
    with connected(proxy) as after:
        exchange(after, call())


def test_faults_for_a_method_count_its_calls_only(
    proxy: FaultProxy, server: EchoServer, client: socket.socket
) -> None:
    proxy.on("movej2", ApplicationError(), skip=1, times=2)
    kinds = [
        exchange(client, call(name)).kind for name in ["movej2", "stop", "movej2", "stop", "movej2"]
    ]
    assert kinds == [
        MessageType.REPLY,
        MessageType.REPLY,
        MessageType.EXCEPTION,
        MessageType.REPLY,
        MessageType.EXCEPTION,
    ]
    assert exchange(client, call("movej2")).kind is MessageType.REPLY
    proxy.on("stop", ApplicationError(), times=None)
    assert {exchange(client, call("stop")).kind for _ in range(5)} == {MessageType.EXCEPTION}
    proxy.clear()
    assert exchange(client, call("stop")).kind is MessageType.REPLY


def test_a_plan_with_the_same_seed_does_the_same(proxy: FaultProxy) -> None:
    menu: list[Fault] = [ApplicationError(), Delay(request=0.0001), WrongKind()]

    def run(seed: int) -> list[Fault | None]:
        before = len(proxy.calls())
        proxy.schedule(Chaos(seed, menu, rate=0.7))
        with connected(proxy) as client:
            for seqid in range(40):
                exchange(client, call(seqid=seqid))
        return [record.fault for record in proxy.calls()[before:]]

    first = run(1)
    assert first == run(1)
    assert first != run(2)
    assert set(first) == {None, *menu}


@pytest.mark.slow
def test_serves_many_connections_at_once(proxy: FaultProxy, server: EchoServer) -> None:
    wrong = []

    def work(number: int) -> None:
        with connected(proxy) as client:
            for seqid in range(50):
                message = call("read_word_reg", seqid, f"{number}/{seqid}")
                if exchange(client, message) != reply_to(message):
                    wrong.append(message)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
    assert proxy.statistics().calls == 400


async def test_can_be_used_on_an_event_loop(server: EchoServer) -> None:
    async with FaultProxy("127.0.0.1", server.port) as proxy:
        proxy.next(ApplicationError(6, "first"))
        async with await anyio.connect_tcp(proxy.host, proxy.port) as stream:
            await stream.send(call().encode())
            assert b"first" in await stream.receive()
        assert proxy.statistics().faults == 1


def test_what_is_going_on_ends_with_the_proxy(server: EchoServer) -> None:
    with no_leaks(), ExitStack() as clients, FaultProxy("127.0.0.1", server.port) as proxy:
        proxy.next(Delay(request=1000), Throttle(0.001), HalfOpen(), DropReply())
        for number in range(5):
            clients.enter_context(connected(proxy)).sendall(call(f"f{number}").encode())
            eventually(partial(proxy.calls, f"f{number}"))


def test_a_proxy_that_cannot_start_leaves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def taken(*args: object) -> None:
        raise OSError(errno.EADDRINUSE, "taken")

    with no_leaks():
        monkeypatch.setattr(socket.socket, "listen", taken)
        with pytest.raises(OSError, match="taken"):
            FaultProxy("127.0.0.1", 1).__enter__()


def test_without_descriptors_a_client_waits_and_the_proxy_does_not_spin(
    proxy: FaultProxy, monkeypatch: pytest.MonkeyPatch
) -> None:
    accept, sleep = socket.socket.accept, anyio.sleep
    rests: list[float] = []

    def exhausted(sock: socket.socket) -> Any:
        if len(rests) < 2:
            raise OSError(errno.EMFILE, "no descriptor left")
        return accept(sock)

    async def rest(seconds: float) -> None:
        rests.append(seconds)
        await sleep(0)

    monkeypatch.setattr(socket.socket, "accept", exhausted)
    monkeypatch.setattr(anyio, "sleep", rest)
    with connected(proxy) as client:
        client.sendall(call().encode())
        assert next(replies(client)).name == "read_word_reg"
    assert rests == [0.1, 0.1]


def test_a_fault_of_a_function_that_no_controller_has_is_refused(proxy: FaultProxy) -> None:
    with pytest.raises(ParameterError, match=r"method is 'movej3', .*did you mean 'movej'"):
        proxy.on("movej3", DropReply())
    for wrong in ("cut", Cut, None):
        with pytest.raises(ParameterError, match="a fault, such as Cut"):
            proxy.on("movej2", wrong)  # type: ignore[arg-type]  # the wrong type is the point


#: what is called, and with which arguments
WRONG: list[tuple[Any, ...]] = [
    *((Delay, math.nan), (Delay, 0.0, -1.0), (Delay, "0.1"), (Throttle, 0.0)),
    *((Cut, "before the reply"), (Cut, Place.IN_REPLY, "reset")),
    *((Cut, Place.IN_REPLY, Ending.RESET, math.nan), (RepeatReply, -1), (WrongSeqid, 1 << 32)),
    *((ApplicationError, "6"), (Chaos, 1, []), (Chaos, 1, Delay(0.1)), (Chaos, 1, [Cut])),
    *((partial(Chaos, rate=math.nan), 1, [Delay(0.1)]), (Script().next, "cut")),
    *((Script().on, "stop", Cut), (partial(Script().on, skip=-1), "stop", DropReply())),
]


@for_each("wrong", WRONG)
def test_a_fault_that_would_do_nothing_is_refused(wrong: tuple[Any, ...]) -> None:
    make, *arguments = wrong
    with pytest.raises(ParameterError):
        make(*arguments)
