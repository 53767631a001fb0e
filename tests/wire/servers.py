"""A server that follows a script, call by call: true answers and every kind of false one."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Self

from thriftpy2.protocol import TCyBinaryProtocol
from thriftpy2.thrift import TType
from thriftpy2.transport import TCyMemoryBuffer

from aioduco._wire import idl, rpc
from aioduco._wire.messages import Inbox, application_error
from aioduco._wire.messages import Message as Raw

_protocol: Any = TCyBinaryProtocol

#: most seconds that anything in these tests waits for anything
PATIENCE = 20.0


@dataclass(frozen=True)
class Received:
    """A call that came, and its place among all calls of the server."""

    raw: Raw
    name: str
    args: tuple[Any, ...]
    index: int


def zero(name: str) -> Any:
    """A plausible result of a function."""
    results: dict[str, Any] = {
        "getRobotStatus": rpc.RobotStatus(jointActualPosition=[0.5] * 6, slaveReady=[True] * 6),
        "get_files_list": {"a.jspf": 1, "名": 2},
        "get_last_error": ["Joint 4 检测到碰撞"],
        "get_actual_joints_position": [0.0, 0.1, 0.2, 0.3, 0.4, 0.5],
        "get_robot_version": "3.8",
    }
    if name in results:
        return results[name]
    return [] if idl.functions()[name].result.thrift_spec[0][0] == TType.LIST else 0


def decode(raw: Raw) -> tuple[Any, ...]:
    function = idl.functions()[raw.name]
    args = function.args()
    _protocol(TCyMemoryBuffer(raw.body)).read_struct(args)
    return tuple(getattr(args, name) for name in function.parameters)


def reply(raw: Raw, value: Any = None) -> bytes:
    """The bytes of a true answer."""
    function = idl.functions()[raw.name]
    result = function.result()
    if not function.void:
        result.success = zero(raw.name) if value is None else value
    buffer = TCyMemoryBuffer()
    _protocol(buffer).write_struct(result)
    head = b"\x80\x01\x00\x02" + function.head + struct.pack("!i", raw.seqid)
    return head + bytes(buffer.getvalue())


def exception(raw: Raw, code: int, text: str) -> bytes:
    """The bytes of an application error."""
    return application_error(raw, code, text).encode()


class Peer:
    """The server's end of one connection."""

    def __init__(self, server: ScriptedServer, sock: socket.socket, number: int) -> None:
        self.server = server
        self.sock = sock
        self.number = number
        self._inbox = Inbox()
        self._pending: list[Raw] = []

    def receive(self) -> Received | None:
        """The next call; None when the client has gone."""
        while not self._pending:
            try:
                data = self.sock.recv(65536)
            except OSError:
                return None
            if not data:
                return None
            self._pending += self._inbox.messages(data)
        raw = self._pending.pop(0)
        return self.server.note(raw)

    def take(self) -> Received:
        """The next call, which must come."""
        call = self.receive()
        assert call is not None
        return call

    def send(self, data: bytes) -> None:
        with contextlib.suppress(OSError):
            self.sock.sendall(data)

    def answer(self, call: Received, value: Any = None) -> None:
        self.send(reply(call.raw, value))

    def close(self) -> None:
        self.sock.close()

    def reset(self) -> None:
        """Close the connection by RST."""
        self.sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.sock.close()

    def wait_gone(self) -> bool:
        """Wait until the client has closed the connection; whether it did."""
        self.sock.settimeout(PATIENCE)
        try:
            while self.sock.recv(65536):
                pass
        except TimeoutError:
            return False
        except OSError:
            pass
        return True


Script = Callable[[Peer], None]


def honest(peer: Peer) -> None:
    """Answer every call truly."""
    while (call := peer.receive()) is not None:
        peer.answer(call)


def held(gate: threading.Event, then: Script = honest) -> Script:
    """Hold the first answer back until the gate is open; go on with another script."""

    def script(peer: Peer) -> None:
        call = peer.take()
        assert gate.wait(PATIENCE)
        peer.answer(call)
        then(peer)

    return script


def silent(peer: Peer) -> None:
    """Take calls, and answer none."""
    while peer.receive() is not None:
        pass


def ending(peer: Peer) -> None:
    """Take a call, and end the connection."""
    peer.receive()


class ScriptedServer:
    """Accepts connections on a free port of the loopback; each runs a script on a thread.

    Args:
        scripts: one per connection, in the order in which they come; the last one for all
            that follow.
        port: the port, if not a free one.
    """

    def __init__(self, *scripts: Script, port: int = 0) -> None:
        self._scripts = scripts or (honest,)
        self._listener = socket.create_server(("127.0.0.1", port), backlog=64)
        self.host, self.port = self._listener.getsockname()
        self._threads: list[threading.Thread] = []
        self._peers: list[Peer] = []
        self._change = threading.Condition()
        self.calls: list[Received] = []
        self.finished = 0
        self._accepting = threading.Thread(target=self._accept, name="scripted-accept")

    @property
    def connections(self) -> int:
        """Connections that were accepted."""
        return len(self._peers)

    @property
    def names(self) -> list[str]:
        """The functions that were called, in order."""
        return [call.name for call in self.calls]

    def note(self, raw: Raw) -> Received:
        args = decode(raw)
        with self._change:
            call = Received(raw, raw.name, args, len(self.calls))
            self.calls.append(call)
            self._change.notify_all()
        return call

    def wait_for(self, condition: Callable[[], bool]) -> None:
        """Wait until something is so; it is looked at after each call and each script's end."""
        with self._change:
            assert self._change.wait_for(condition, PATIENCE), "the condition never came true"

    def wait_calls(self, count: int) -> None:
        """Wait until so many calls have come."""
        self.wait_for(lambda: len(self.calls) >= count)

    def wait_finished(self, count: int) -> None:
        """Wait until so many connections have run to the end of their scripts."""
        self.wait_for(lambda: self.finished >= count)

    def __enter__(self) -> Self:
        self._accepting.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop_listening()
        for peer in self._peers:
            with contextlib.suppress(OSError):
                peer.sock.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            thread.join(PATIENCE)
            assert not thread.is_alive(), f"{thread} hangs"

    def stop_listening(self) -> None:
        """Refuse connections from now on; those that are open stay."""
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._accepting.join(PATIENCE)
        self._listener.close()

    def _accept(self) -> None:
        while True:
            try:
                sock, _ = self._listener.accept()
            except OSError:
                return
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            number = len(self._peers)
            peer = Peer(self, sock, number)
            script = self._scripts[min(number, len(self._scripts) - 1)]
            thread = threading.Thread(
                target=self._serve, args=(peer, script), name=f"scripted-{number}"
            )
            with self._change:
                self._peers.append(peer)
                self._threads.append(thread)
                self._change.notify_all()
            thread.start()

    def _serve(self, peer: Peer, script: Script) -> None:
        try:
            script(peer)
        finally:
            peer.sock.close()
            with self._change:
                self.finished += 1
                self._change.notify_all()


@contextlib.contextmanager
def black_hole() -> Iterator[tuple[str, int]]:
    """An address whose connections are never answered: its queue of connections is full."""
    with contextlib.ExitStack() as stack:
        listener = stack.enter_context(socket.socket())
        listener.bind(("127.0.0.1", 0))
        listener.listen(0)
        address = listener.getsockname()
        # the queue takes one more than it was told; each further handshake stays unfinished
        for _ in range(4):
            filler = stack.enter_context(socket.socket())
            filler.setblocking(False)
            with contextlib.suppress(BlockingIOError):
                filler.connect(address)
        yield address
