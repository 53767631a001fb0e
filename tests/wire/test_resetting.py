"""A connection that is given up delivers nothing more, whoever else holds its socket."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from for_each import for_each

from aioduco._wire.connection import Connection
from aioduco._wire.deadline_socket import DeadlineSocket
from aioduco._wire.endpoint import Endpoint
from aioduco.errors import DucoError, OutcomeUnknown
from aioduco.testing import DropReply, FaultProxy, RecordingServer

pytestmark = pytest.mark.linux("a connection that is reset before it is closed")

#: family, kind, protocol and name of an address
TCP = socket.AF_INET, socket.SOCK_STREAM, 0, ""
#: more than a peer takes that does not read
LARGE = bytes(8_000_000)


@contextmanager
def peer() -> Iterator[socket.socket]:
    """A listener whose connections take little and are not read."""
    with socket.socket() as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        yield listener


def stuck(listener: socket.socket) -> tuple[DeadlineSocket, socket.socket]:
    """A stream that holds bytes which its peer has not taken, and the peer."""
    stream = DeadlineSocket((*TCP, listener.getsockname()))
    deadline = time.monotonic() + 30.0
    stream.connect(deadline)
    accepted, _ = listener.accept()
    assert stream.undelivered == 0
    while not stream.undelivered:
        stream.send_at_once(LARGE)
    return stream, accepted


def drained(accepted: socket.socket) -> bool:
    """Read all that comes. Returns whether the connection was reset, not ended."""
    with accepted:
        accepted.settimeout(30.0)
        try:
            while accepted.recv(1 << 20):
                pass
        except ConnectionResetError:
            return True
    return False


GIVEN_UP: list[Callable[[DeadlineSocket], None]] = [DeadlineSocket.shutdown, DeadlineSocket.discard]


@for_each("give_up", GIVEN_UP)
def test_what_is_undelivered_is_forgotten(give_up: Callable[[DeadlineSocket], None]) -> None:
    with peer() as listener:
        stream, accepted = stuck(listener)
        held = stream.undelivered
        assert held > 0
        give_up(stream)
        assert drained(accepted)
        stream.discard()


def test_a_copy_of_the_socket_keeps_nothing_alive() -> None:
    """As a child has it that was forked."""
    with peer() as listener:
        stream, accepted = stuck(listener)
        copy = os.dup(stream.socket.fileno())
        try:
            stream.discard()
            assert drained(accepted)
        finally:
            os.close(copy)


def test_a_thread_that_waits_is_woken() -> None:
    with peer() as listener:
        stream, accepted = stuck(listener)
        ended: list[BaseException] = []

        def wait() -> None:
            try:
                stream.receive(None)
            except (EOFError, OSError) as exc:
                ended.append(exc)

        thread = threading.Thread(target=wait)
        thread.start()
        stream.shutdown()
        thread.join(30.0)
        assert ended
        stream.discard()
        assert drained(accepted)


def test_an_ordinary_end_is_no_reset() -> None:
    with peer() as listener:
        stream = DeadlineSocket((*TCP, listener.getsockname()))
        stream.connect(time.monotonic() + 30.0)
        accepted, _ = listener.accept()
        stream.close()
        assert not drained(accepted)


PROGRAM = """
import socket, sys, time
from aioduco._wire.deadline_socket import DeadlineSocket

address = "127.0.0.1", int(sys.argv[1])
stream = DeadlineSocket((socket.AF_INET, socket.SOCK_STREAM, 0, "", address))
stream.connect(time.monotonic() + 30.0)
while not stream.undelivered:
    stream.send_at_once(bytes(8_000_000))
print("stuck", flush=True)
sys.stdin.read()
"""


def test_a_process_that_is_killed_leaves_nothing_to_deliver() -> None:
    with peer() as listener:
        port = str(listener.getsockname()[1])
        with subprocess.Popen(
            [sys.executable, "-c", PROGRAM, port], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        ) as program:
            accepted, _ = listener.accept()
            assert program.stdout is not None
            assert program.stdout.readline() == b"stuck\n"
            program.send_signal(signal.SIGKILL)
            assert drained(accepted)


FORKING = """
import os, socket, sys
from aioduco._wire.deadline_socket import DeadlineSocket

address = "127.0.0.1", int(sys.argv[1])
stream = DeadlineSocket((socket.AF_INET, socket.SOCK_STREAM, 0, "", address))
stream.prepare()  # as for a loop, which waits until it is connected
stream.socket.connect_ex(address)
child = os.fork()
if child == 0:
    stream.discard()
    os._exit(0)
assert os.waitpid(child, 0)[1] == 0
sent = stream.send_at_once(b"parent's")
stream.close()
sys.exit(sent != 8)
"""


def test_a_forked_child_that_gives_up_a_connection_does_not_reset_that_of_its_parent() -> None:
    """Its copy of a task that connects has a deadline, after which it discards the socket."""
    with peer() as listener:
        port = str(listener.getsockname()[1])
        command = [sys.executable, "-W", "ignore", "-c", FORKING, port]
        with subprocess.Popen(command) as program:
            accepted, _ = listener.accept()
            with accepted:
                assert accepted.recv(8) == b"parent's"
        assert program.returncode == 0


# -- an answer that is overdue -----------------------------------------------------------------


def test_a_late_answer_to_a_command_can_be_waited_for() -> None:
    gate = threading.Event()

    def late(*_: object) -> int:
        gate.wait(30.0)
        return 4

    with RecordingServer({"stop": 4, "servoj": late}) as server:
        connection = Connection(Endpoint(server.host, server.port), keeps_overdue=True)
        connection.open()
        with pytest.raises(OutcomeUnknown):
            connection.call("servoj", ([0.0] * 6, 1.0, 1.0, False, 200.0, 25.0, 10.0, 1.0), 0.05)
        assert connection.overdue
        with pytest.raises(DucoError, match="nothing was sent"):
            connection.call("stop", (False,), 1.0)
        assert not connection.late_answer(time.monotonic() + 0.01)
        gate.set()
        assert connection.late_answer(time.monotonic() + 30.0)
        assert not connection.late_answer(time.monotonic() + 30.0)  # it comes once
        connection.close()


def test_no_answer_is_waited_for_on_a_connection_that_ended() -> None:
    with RecordingServer({"servoj": 1001}) as server, FaultProxy(server.host, server.port) as proxy:
        proxy.on("servoj", DropReply())
        connection = Connection(Endpoint(proxy.host, proxy.port), keeps_overdue=True)
        connection.open()
        with pytest.raises(OutcomeUnknown):
            connection.call("servoj", ([0.0] * 6, 1.0, 1.0, False, 200.0, 25.0, 10.0, 1.0), 0.05)
        assert connection.overdue
        proxy.cut()
        assert not connection.late_answer(time.monotonic() + 30.0)
        connection.close()


def test_what_is_undelivered_is_not_waited_for() -> None:
    with peer() as listener:
        host, port = listener.getsockname()
        connection = Connection(Endpoint(host, port), keeps_overdue=True)
        connection.open()
        assert connection._stream is not None
        while not connection.undelivered:
            connection._stream.send_at_once(LARGE)
        with pytest.raises(DucoError):
            connection.call("run_program", ("x" * 1000, False), 0.1)
        assert not connection.overdue
        connection.close()
