"""The book finds what it is there to find: clients as they are usually written do not pass."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

import pytest
import thriftpy2
from thriftpy2 import rpc
from thriftpy2.protocol import binary
from thriftpy2.transport import buffered

from aioduco._wire import idl
from aioduco.errors import ConnectionLost
from aioduco.testing import Delay, DropReply, FaultProxy, HoldReply, RecordingServer, eventually

from .calls import ANSWERS, Book, Call, make

_protocol: Any = binary.TBinaryProtocolFactory


@pytest.fixture
def server() -> Iterator[RecordingServer]:
    with RecordingServer(ANSWERS) as server:
        yield server


@pytest.fixture
def proxy(server: RecordingServer) -> Iterator[FaultProxy]:
    with FaultProxy(server.host, server.port) as proxy:
        yield proxy


@pytest.fixture
def book() -> Book:
    return Book(random.Random(1))


@pytest.fixture
def client(proxy: FaultProxy) -> Iterator[Any]:
    """thriftpy2's own client, with a time-out of 50 ms."""
    module = thriftpy2.load(str(idl.path()), module_name="plain_robot_thrift")
    client: Any = rpc.make_client(
        module.RPCRobot,
        proxy.host,
        proxy.port,
        timeout=50,
        proto_factory=_protocol(),
        trans_factory=buffered.TBufferedTransportFactory(),
    )
    yield client
    client.close()


def patient(client: Any) -> None:
    """Have it wait as long as it takes: what follows is answered, on a busy machine late."""
    client._iprot.trans._trans.set_timeout(None)


def wait_for_the_answer(proxy: FaultProxy) -> None:
    """Wait for the server's answer to the first call: the client may have given up sooner."""
    eventually(lambda: any(call.replied is not None for call in proxy.calls()))


def test_an_answer_to_the_call_before_is_found(
    proxy: FaultProxy, server: RecordingServer, book: Book, client: Any
) -> None:
    def lost(method: str, args: tuple[Any, ...], timeout: float) -> Any:
        try:
            return getattr(client, method)(*args)
        except TimeoutError as exc:
            raise ConnectionLost from exc

    proxy.next(HoldReply())
    book.follow_blocking(make("get_system_value_double"), lost, 0.05)
    assert book.outcomes == {"lost": 1}
    wait_for_the_answer(proxy)
    patient(client)
    book.follow_blocking(make("get_system_value_double"), lost, 0.05)
    with pytest.raises(AssertionError, match=r"was answered by \d+\.25"):
        book.check(server)


def test_a_command_that_is_sent_again_is_found(
    proxy: FaultProxy, server: RecordingServer, book: Book, client: Any
) -> None:
    def insisting(method: str, args: tuple[Any, ...], timeout: float) -> Any:
        while True:
            try:
                return getattr(client, method)(*args)
            except Exception:
                wait_for_the_answer(proxy)
                client.close()
                patient(client)
                client._iprot.trans.open()

    proxy.next(DropReply())
    book.follow_blocking(make("write_word_reg"), insisting, 1.0)
    with pytest.raises(AssertionError, match=r"\(answered\) arrived 2 times"):
        book.check(server)


def test_a_command_that_was_said_not_to_be_sent_is_found(
    proxy: FaultProxy, server: RecordingServer, book: Book, client: Any
) -> None:
    def hopeful(method: str, args: tuple[Any, ...], timeout: float) -> Any:
        try:
            return getattr(client, method)(*args)
        except Exception as exc:
            raise ConnectionLost from exc

    proxy.next(DropReply())
    book.follow_blocking(make("write_word_reg"), hopeful, 1.0)
    wait_for_the_answer(proxy)
    with pytest.raises(AssertionError, match=r"\(not sent\) arrived 1 times"):
        book.check(server)


def test_a_call_that_never_arrived_but_was_answered_is_found(
    server: RecordingServer, book: Book
) -> None:
    def dreaming(method: str, args: tuple[Any, ...], timeout: float) -> Any:
        return ANSWERS[method](*args)

    book.follow_blocking(make("write_word_reg"), dreaming, 1.0)
    with pytest.raises(AssertionError, match=r"\(answered\) arrived 0 times"):
        book.check(server)


async def test_a_call_that_outlives_its_deadline_is_found(
    proxy: FaultProxy, server: RecordingServer, book: Book, client: Any
) -> None:
    async def slow(method: str, args: tuple[Any, ...], timeout: float) -> Any:
        return getattr(client, method)(*args)

    patient(client)
    proxy.next(Delay(reply=0.6))
    await book.follow(make("cal_fkine"), slow, timeout=0.01)
    with pytest.raises(AssertionError, match=r"s longer than it may"):
        book.check(server)


def test_a_plain_answer_passes(server: RecordingServer, book: Book, client: Any) -> None:
    calls = [make(method) for method in ANSWERS if method != "stop"]
    calls.append(Call(0, "stop", (True,), 0))

    def plainly(method: str, args: tuple[Any, ...], timeout: float) -> Any:
        return getattr(client, method)(*args)

    patient(client)
    for call in calls:
        book.follow_blocking(call, plainly, 1.0)
    book.check(server)
    assert book.outcomes == {"answered": len(calls)}
