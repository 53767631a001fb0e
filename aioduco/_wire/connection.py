"""A connection to the controller: one call at a time, each answered truly or not at all."""

from __future__ import annotations

import math
import socket
import struct
import threading
import time
import warnings
from typing import Any, Final, NamedTuple

from aioduco._wire import codec, idl
from aioduco._wire.framing import Malformed
from aioduco._wire.lifecycle import ConnectionState, Lifecycle, Progress
from aioduco._wire.rpc import RpcClient
from aioduco._wire.semantics import Kind, kind
from aioduco.errors import (
    CallTimeout,
    ConnectError,
    ConnectionLost,
    ControllerError,
    NotSent,
    OutcomeUnknown,
    ProtocolError,
)

#: A peer that vanished without a word is given up after about eight seconds, whether the
#: connection idles (probes from the fifth second on) or bytes are on their way.
_KEEP_ALIVE: Final = (("TCP_KEEPIDLE", 5), ("TCP_KEEPINTVL", 1), ("TCP_KEEPCNT", 3))
_USER_TIMEOUT_MS: Final = 8000

#: seconds by which the system's own limit on a read or write may be longer than what is left
_SLACK: Final = 0.02

_CHUNK: Final = 16384

#: time limit of calls through `Connection.rpc`, in seconds
_CALL_TIMEOUT: Final = 2.0


class ConnectionStatistics(NamedTuple):
    """Figures of one connection.

    Attributes:
        calls: calls that were begun.
        answered: calls whose answer came, application errors included.
        bytes_sent: bytes handed to the system.
        bytes_received: bytes that came.
    """

    calls: int
    answered: int
    bytes_sent: int
    bytes_received: int


class _Deadline(Exception):
    """The time for the call is over."""


class _Ended(Exception):
    """The other side closed the connection."""


class Connection:
    """One TCP connection, owned by the thread that opened it (manual 1.5.1).

    Guarantees: a value is returned only if it is the answer to this very call, by function and
    sequence id. After any other end of a call the connection is POISONED: its socket is
    closed, and no later call can meet a late answer. Only `abandon` may be called from other
    threads, and from signal handlers.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        connect_timeout: most seconds that `open` takes, over all addresses of the host.
    """

    def __init__(self, host: str, port: int, *, connect_timeout: float = 3.0) -> None:
        self.host = host
        self.port = port
        self.connect_timeout = connect_timeout
        self._life = Lifecycle()
        # Reentrant: a signal handler may abandon the connection whose state its own thread is
        # just changing. Guards the state and the closing of the socket, so that `abandon` never
        # shuts a socket down whose number belongs to another file by then.
        self._guard = threading.RLock()
        self._socket: socket.socket | None = None
        self._owner: int | None = None
        self._sequence = 0
        self._limit: float | None = -1.0
        self._calls = 0
        self._answered = 0
        self._bytes_sent = 0
        self._bytes_received = 0

    @property
    def state(self) -> ConnectionState:
        """State of the connection."""
        return self._life.state

    @property
    def progress(self) -> Progress:
        """How far the last call came."""
        return self._life.progress

    @property
    def reason(self) -> str:
        """Why the connection is not used any more; empty while it is."""
        return self._life.reason

    def statistics(self) -> ConnectionStatistics:
        """Figures since the connection was made."""
        return ConnectionStatistics(
            self._calls, self._answered, self._bytes_sent, self._bytes_received
        )

    def __repr__(self) -> str:
        state = self.state.name
        reason = f": {self.reason}" if self.reason else ""
        return f"<Connection {self.host}:{self.port} {state}{reason}, {self._calls} calls>"

    def __del__(self) -> None:
        if getattr(self, "_socket", None) is not None:
            warnings.warn(f"unclosed {self!r}", ResourceWarning, source=self, stacklevel=2)
            self.close()

    def open(self, deadline: float | None = None) -> None:
        """Connect; the calling thread becomes the owner.

        Args:
            deadline: time of `time.monotonic()` by which it must have happened, if that is
                sooner than the connection's own limit.

        Raises:
            ConnectError: there is no controller, or it does not answer in time.
            ConnectionLost: the connection was abandoned, or has been used before.
        """
        if self.state is not ConnectionState.NEW:
            raise ConnectionLost(f"{self!r} cannot be opened again; nothing was sent")
        self._owner = threading.get_ident()
        limit = time.monotonic() + self.connect_timeout
        self._connect(limit if deadline is None else min(limit, deadline))

    def _connect(self, deadline: float) -> None:
        # the name is resolved anew each time: the address may have changed with the controller
        try:
            found = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_STREAM)
        except (OSError, UnicodeError) as exc:
            self._end("its host is unknown")
            raise ConnectError(self.host, self.port, f"unknown host ({exc})") from exc
        error: OSError = TimeoutError("no time left after the name was resolved")
        for family, type_, protocol, _, address in found:
            left = deadline - time.monotonic()
            if left <= 0 or self.state is not ConnectionState.NEW:
                break
            try:
                made = socket.socket(family, type_, protocol)
            except OSError as exc:
                error = exc
                continue
            with self._guard:
                self._socket = made
            try:
                _configure(made)
                made.settimeout(left)
                made.connect(address)
                # from here on the system limits reads and writes, see `_time`
                made.settimeout(None)
            except OSError as exc:
                error = exc
                self._drop()
                continue
            break
        with self._guard:
            if self._socket is not None and self._life.opened():
                return
            abandoned = self.state is not ConnectionState.NEW
        if abandoned:
            self._drop()
            raise ConnectionLost(
                f"the connection to {self.host}:{self.port} was given up while it was made: "
                f"{self.reason}; nothing was sent"
            )
        self._end("it could not be made")
        timed_out = isinstance(error, TimeoutError)
        reason = "no answer in time" if timed_out else error.strerror or str(error)
        raise ConnectError(self.host, self.port, reason) from error

    @property
    def rpc(self) -> RpcClient:
        """The functions of the wire, each within two seconds."""
        return RpcClient(lambda name, args: self.call(name, args, _CALL_TIMEOUT))

    def call(self, name: str, args: tuple[Any, ...], timeout: float | None) -> Any:
        """Call a function of the wire and wait for its answer; only on the owner's thread.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: most seconds for the whole call, however slowly bytes come; None: no limit.

        Returns:
            The result; None for a function without one.

        Raises:
            ParameterError: a value cannot be sent; nothing was, and the connection is usable.
            ControllerError: the controller answered by an error; the connection is usable.
            ConnectionLost: nothing was sent, or a function that only reads was not answered.
            CallTimeout: a function that only reads was not answered in time.
            ProtocolError: a function that only reads was answered by something else.
            OutcomeUnknown: a command was sent and its answer did not come.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        function = idl.functions()[name]
        return self.exchange(function, codec.encode(function, args), deadline)

    def exchange(self, function: idl.Function, arguments: bytes, deadline: float | None) -> Any:
        """Send a call whose arguments are encoded, and wait for its answer.

        Args:
            function: the function of the wire.
            arguments: what `codec.encode` made of the arguments.
            deadline: time of `time.monotonic()` by which the answer must be whole.

        Returns:
            The result, as `call` does.
        """
        if threading.get_ident() != self._owner:
            raise RuntimeError(f"{self!r} belongs to the thread that opened it")
        if deadline is not None and deadline <= time.monotonic():
            raise NotSent(f"{function.name} was not sent: there was no time left for it")
        with self._guard:
            if not self._life.begin():
                raise ConnectionLost(f"{function.name} cannot use {self!r}; nothing was sent")
            sock = self._socket
        assert sock is not None
        self._calls += 1
        self._sequence = self._sequence % codec.LAST_SEQUENCE + 1
        reply = codec.ReplyReader(function, self._sequence)
        try:
            self._check_quiet(sock)
            self._send(sock, codec.message(function, self._sequence, arguments), deadline)
            data = self._receive(sock, reply, deadline)
            value = self._decode(reply, data)
        except BaseException as exc:
            raised = self._failure(function, exc)
            if raised is exc:
                raise
            raise raised from exc
        with self._guard:
            if not self._life.complete():
                # abandoned while the last bytes came: the caller has been told otherwise
                lost = self._failure(function, _Ended())
                raise lost
        self._answered += 1
        if len(data) > reply.length:
            # this answer is true, but whose are the bytes behind it?
            self._end("bytes came behind an answer")
        if isinstance(value, ControllerError):
            raise value
        return value

    @staticmethod
    def _decode(reply: codec.ReplyReader, data: bytes | bytearray) -> Any:
        """The value, or the controller's error: an answer too, after which the call is over."""
        try:
            return reply.value(data)
        except ControllerError as exc:
            return exc

    def _check_quiet(self, sock: socket.socket) -> None:
        """Find a connection that the peer closed, or wrote to unasked, before anything is sent."""
        try:
            stray = sock.recv(64, socket.MSG_PEEK | socket.MSG_DONTWAIT)
        except BlockingIOError:
            return
        if stray:
            raise Malformed(f"bytes came that nobody asked for: {stray!r}")
        raise _Ended

    def _send(self, sock: socket.socket, data: bytes, deadline: float | None) -> None:
        self._time(sock, deadline)
        sent = sock.send(data)
        self._life.sent()
        self._bytes_sent += sent
        while sent < len(data):
            self._time(sock, deadline)
            try:
                more = sock.send(data[sent:])
            except BlockingIOError:
                continue
            sent += more
            self._bytes_sent += more

    def _receive(
        self, sock: socket.socket, reply: codec.ReplyReader, deadline: float | None
    ) -> bytes | bytearray:
        data: bytes | bytearray = b""
        while True:
            try:
                chunk = sock.recv(_CHUNK)
            except BlockingIOError:
                self._time(sock, deadline)
                continue
            if not chunk:
                raise _Ended
            self._bytes_received += len(chunk)
            if not data:
                self._life.answering()
                data = chunk
            else:
                # most answers come in one piece; the others are gathered without copies
                data = bytearray(data) if isinstance(data, bytes) else data
                data += chunk
            if reply.whole(data):
                return data
            self._time(sock, deadline)

    def _time(self, sock: socket.socket, deadline: float | None) -> None:
        """See that the next read or write ends at the deadline at the latest.

        The limit is the system's own (SO_RCVTIMEO), not Python's: a read is then one blocking
        system call that gives the interpreter's lock away once instead of twice. It is set anew
        only if what is left differs.
        """
        if deadline is None:
            left = None
            if self._limit is None:
                return
        else:
            left = deadline - time.monotonic()
            if left <= 0:
                raise _Deadline
            if self._limit is not None and left <= self._limit <= left + min(_SLACK, left / 8):
                return
        # a little longer, so that it also fits the next call with the same time
        limit = None if left is None else left + min(_SLACK, left / 8) / 2
        microseconds = 0 if limit is None else math.ceil(limit * 1e6)
        packed = struct.pack("@ll", *divmod(microseconds, 1_000_000))
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, packed)
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, packed)
        self._limit = limit

    def _failure(self, function: idl.Function, exc: BaseException) -> BaseException:
        """Poison the connection and say what the caller is told: the one place for that."""
        match exc:
            case _Deadline():
                reason = "no answer came in time"
            case _Ended():
                reason = "the controller closed the connection"
            case BlockingIOError():
                reason = "it could not be sent in time"
            case OSError():
                reason = f"the connection broke ({exc.strerror or exc})"
            case Malformed():
                reason = f"something else than its answer came: {exc}"
            case Exception():
                reason = f"its answer could not be read ({type(exc).__name__}: {exc})"
            case _:
                reason = f"it was interrupted ({type(exc).__name__})"
        self._end(reason)
        # an abandoned connection has its own reason, and the system's error is only its echo
        reason = self.reason
        if not isinstance(exc, Exception):
            return exc
        name = function.name
        late = isinstance(exc, _Deadline | BlockingIOError)
        if self.progress is Progress.NOTHING_SENT:
            return (NotSent if late else ConnectionLost)(f"{name} was not sent, since {reason}")
        if kind(name) is not Kind.READ:
            return OutcomeUnknown(name, reason)
        if late:
            return CallTimeout(f"{name}: {reason}; the connection was closed")
        if isinstance(exc, _Ended | OSError):
            return ConnectionLost(f"{name}: {reason}; it only reads, so it may be called again")
        return ProtocolError(f"{name}: {reason}; the connection was closed")

    def abandon(self, reason: str = "the call was given up") -> None:
        """Poison the connection from any thread; a call that is under way returns at once."""
        with self._guard:
            if not self._life.poison(reason) or self._socket is None:
                return
            try:
                self._socket.shutdown(socket.SHUT_RDWR)
            except OSError:
                # not connected yet, or already broken: there is nothing to wake
                return

    def _end(self, reason: str) -> None:
        with self._guard:
            self._life.poison(reason)
            self._drop()

    def _drop(self) -> None:
        with self._guard:
            sock, self._socket = self._socket, None
        if sock is not None:
            sock.close()

    def close(self) -> None:
        """Close the connection; on the owner's thread, or on any when no call is under way."""
        with self._guard:
            self._life.close()
            self._drop()


def _configure(sock: socket.socket) -> None:
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in _KEEP_ALIVE:
        if hasattr(socket, name):
            sock.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
    # without it, bytes that nobody acknowledges are repeated for some fifteen minutes
    if hasattr(socket, "TCP_USER_TIMEOUT"):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _USER_TIMEOUT_MS)
