"""A connection to the controller: one call at a time, each with its own answer or an error."""

from __future__ import annotations

import os
import socket
import threading
import time
import warnings
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from aioduco._wire import codec, idl
from aioduco._wire.deadline_socket import DeadlinePassed, DeadlineSocket, Ended
from aioduco._wire.forks import fork_hooks
from aioduco._wire.framing import Malformed
from aioduco._wire.host import HOST_RULE, is_host
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.lifecycle import ConnectionState, Lifecycle, Progress
from aioduco._wire.resource_errors import resource_error
from aioduco._wire.rpc import RpcClient
from aioduco.errors import (
    CallTimeout,
    ConnectError,
    ConnectionLost,
    ControllerError,
    NotSent,
    OutcomeUnknown,
    ProtocolError,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

#: time limit of calls through `Connection.rpc`, in seconds
_CALL_TIMEOUT: Final = 2.0


class ConnectionStatistics(NamedTuple):
    """Figures of one connection.

    Attributes:
        calls: calls that were begun.
        answered: calls whose answer came, application errors included.
        bytes_sent: bytes handed to the system.
        bytes_received: bytes of whole answers.
    """

    calls: int
    answered: int
    bytes_sent: int
    bytes_received: int


class Connection:
    """One TCP connection, owned by the thread that opened it or took it over (manual 1.5.1).

    Guarantees: a value is returned only if it is the answer to this very call, by function and
    sequence id. After any other end of a call the connection is POISONED: its socket is
    closed, and no later call can meet a late answer. Only `abandon` and `send_ahead` may be called
    from other threads, and from signal handlers.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        connect_timeout: most seconds that `open` takes, over all addresses of the host. Only the
            resolution of a name takes as long as the system lets it.
        keeps_overdue: whether a command whose answer is late, although all of it was delivered,
            leaves the connection open for `late_answer`. It carries no other call either way.
    """

    def __init__(
        self, host: str, port: int, *, connect_timeout: float = 3.0, keeps_overdue: bool = False
    ) -> None:
        self.host = host
        self.port = port
        self.connect_timeout = connect_timeout
        self._keeps_overdue = keeps_overdue
        self._life = Lifecycle()
        # Reentrant: a signal handler may abandon the connection whose state its own thread is
        # just changing. Guards the state and the closing of the socket, so that `abandon` never
        # shuts a socket down whose number belongs to another file by then.
        self._guard = threading.RLock()
        self._stream: DeadlineSocket | None = None
        #: the stream on which an answer is overdue that may still come
        self._overdue: DeadlineSocket | None = None
        self._owner: int | None = None
        # Begun anywhere: a stray or forged answer must not fit by chance, as one with a low
        # number would on most connections.
        # Of the system: the program's own random numbers stay as it has seeded them.
        self._sequence = int.from_bytes(os.urandom(4)) % codec.LAST_SEQUENCE
        #: the answer to a call that was sent before its owner came to it
        self._ahead: codec.ReplyReader | codec.RepliesReader | None = None
        self._calls = 0
        self._answered = 0
        self._bytes_sent = 0
        self._bytes_received = 0

    @property
    def state(self) -> ConnectionState:
        """State of the connection."""
        return self._life.state

    @property
    def usable(self) -> bool:
        """Whether the owner can exchange a call: the next one, or the one that was sent ahead."""
        return self.state is ConnectionState.IDLE or (
            self._ahead is not None and self.state is ConnectionState.ACTIVE
        )

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
        if getattr(self, "_stream", None) is not None:
            unclosed = f"unclosed {self!r}"
            self.close()
            # last: where warnings are errors, it raises
            warnings.warn(unclosed, ResourceWarning, source=self, stacklevel=2)

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
        fork_hooks.add(self)
        limit = time.monotonic() + self.connect_timeout
        self._connect(limit if deadline is None else min(limit, deadline))

    def _connect(self, deadline: float) -> None:
        if not is_host(self.host):
            self._end("its host is no name and no address")
            raise ConnectError(self.host, self.port, f"the host must be {HOST_RULE}")
        # the name is resolved anew each time: the address may have changed with the controller
        try:
            found = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_STREAM)
        except (OSError, UnicodeError) as exc:
            self._end("its host is unknown")
            reason = resource_error(exc) or f"unknown host ({exc})"
            raise ConnectError(self.host, self.port, reason) from exc
        error: OSError = TimeoutError("no time left after the name was resolved")
        for family, type_, protocol, _, address in found:
            if self.state is not ConnectionState.NEW or time.monotonic() >= deadline:
                break
            try:
                stream = DeadlineSocket(family, type_, protocol)
                with self._guard:
                    # an abandon that came before finds no stream to shut down, but is seen below;
                    # one that comes later ends the handshake
                    self._stream = stream
                    if self._life.state is not ConnectionState.NEW:
                        break
                stream.connect(address, deadline)
            except OSError as exc:
                error = exc
                self._drop()
                continue
            except Ended:
                break
            break
        with self._guard:
            if self._stream is not None and self._life.opened():
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
        reason = resource_error(error) or reason
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

    def hand_over(self) -> None:
        """The calling thread becomes the owner; no call may be under way, nor begun elsewhere."""
        self._owner = threading.get_ident()

    def exchange(
        self,
        function: idl.Function,
        arguments: bytes,
        deadline: float | None,
        meanwhile: Callable[[], object] | None = None,
        further: Sequence[tuple[idl.Function, bytes]] = (),
    ) -> Any:
        """Send a call whose arguments are encoded, and wait for its answer.

        Args:
            function: the function of the wire.
            arguments: what `codec.encode` made of the arguments.
            deadline: time of `time.monotonic()` by which the answer must be whole.
            meanwhile: called once the call is sent: work to be done while the controller does
                its own.
            further: functions that only read, with their encoded arguments, that are sent right
                behind it: the controller answers one after the other.

        Returns:
            The result, as `call` does; with further ones a list of `codec.ReadResult`.
        """
        if threading.get_ident() != self._owner:
            raise RuntimeError(f"{self!r} belongs to the thread that opened it")
        reply, self._ahead = self._ahead, None
        if reply is None and deadline is not None and deadline <= time.monotonic():
            raise NotSent(f"{function.name} was not sent: there was no time left for it")
        with self._guard:
            if reply is None and not self._life.begin():
                raise ConnectionLost(f"{function.name} cannot use {self!r}; nothing was sent")
            stream = self._stream
        assert stream is not None
        try:
            if reply is None:
                reply, message = self._next(function, arguments, further)
                _check_silent(stream)
                self._send(stream, message, deadline)
            if meanwhile is not None:
                meanwhile()
            data = self._receive(stream, reply, deadline)
            value = self._decode(reply, data)
        except BaseException as exc:
            raised = self._failure(function, exc)
            if raised is exc:
                raise
            raise raised from exc
        with self._guard:
            if not self._life.complete():
                # abandoned while the last bytes came: the caller already has an error
                raise self._failure(function, Ended())
        self._answered += reply.count
        if len(data) > reply.length:
            # this answer is valid, but the bytes behind it belong to no call
            self._end("bytes came behind an answer")
        if isinstance(value, ControllerError):
            raise value
        return value

    def send_ahead(
        self,
        function: idl.Function,
        arguments: bytes,
        deadline: float | None,
        further: Sequence[tuple[idl.Function, bytes]] = (),
    ) -> bool:
        """Send a call before its owner's thread gets to run, from any thread; never waits.

        The caller must hold the claim to the next call. The owner's `exchange` of this call then
        only waits for the answer. A connection that does not take the whole of it at once is
        poisoned: the controller, which never has the rest, carries nothing of it out.

        Returns:
            Whether it was sent.
        """
        if deadline is not None and deadline <= time.monotonic():
            return False
        if not self._guard.acquire(blocking=False):
            return False
        try:
            stream = self._stream
            # What came unasked, or a closed connection, is for the owner to tell.
            if stream is None or not stream.silent or not self._life.begin():
                return False
            reply, message = self._next(function, arguments, further)
            if stream.send_at_once(message) != len(message):
                self._life.poison("it did not take a whole call at once")
                return False
            self._life.sent()
            self._bytes_sent += len(message)
            self._ahead = reply
            return True
        finally:
            self._guard.release()

    def _next(
        self,
        function: idl.Function,
        arguments: bytes,
        further: Sequence[tuple[idl.Function, bytes]],
    ) -> tuple[codec.ReplyReader | codec.RepliesReader, bytes]:
        """The next calls: what reads their answers, and what is sent."""
        first = self._next_one(function, arguments)
        if not further:
            return first
        each = [first, *(self._next_one(*one) for one in further)]
        replies = codec.RepliesReader([reply for reply, _ in each], time.monotonic)
        return replies, b"".join(message for _, message in each)

    def _next_one(
        self, function: idl.Function, arguments: bytes
    ) -> tuple[codec.ReplyReader, bytes]:
        self._calls += 1
        self._sequence = self._sequence % codec.LAST_SEQUENCE + 1
        message = codec.message(function, self._sequence, arguments)
        return codec.ReplyReader(function, self._sequence), message

    @staticmethod
    def _decode(reply: codec.ReplyReader | codec.RepliesReader, data: bytes | bytearray) -> Any:
        """The value, or the controller's error: an answer too, after which the call is over."""
        try:
            return reply.value(data)
        except ControllerError as exc:
            return exc

    def _send(self, stream: DeadlineSocket, data: bytes, deadline: float | None) -> None:
        sent = stream.send(data, deadline)
        self._life.sent()
        while sent < len(data):
            sent += stream.send(memoryview(data)[sent:], deadline)
        self._bytes_sent += sent

    def _receive(
        self,
        stream: DeadlineSocket,
        reply: codec.ReplyReader | codec.RepliesReader,
        deadline: float | None,
    ) -> bytes | bytearray:
        data: bytes | bytearray = stream.receive(deadline)
        self._life.answering()
        while not reply.whole(data):
            # most answers come in one piece; the others are gathered without copies
            data = bytearray(data) if isinstance(data, bytes) else data
            data += stream.receive(deadline)
        self._bytes_received += len(data)
        return data

    def _failure(self, function: idl.Function, exc: BaseException) -> BaseException:
        """Poison the connection and choose the error for the caller: the one place for that."""
        match exc:
            case DeadlinePassed() if self.progress is Progress.NOTHING_SENT:
                reason = "the system did not take it in time"
            case DeadlinePassed():
                reason = "no answer came in time"
            case Ended():
                reason = "the controller closed the connection"
            case OSError():
                reason = f"the connection broke ({exc.strerror or exc})"
            case Malformed():
                reason = f"something else than its answer came: {exc}"
            case Exception():
                reason = f"its answer could not be read ({type(exc).__name__}: {exc})"
            case _:
                reason = f"it was interrupted ({type(exc).__name__})"
        self._end(reason, keep=isinstance(exc, DeadlinePassed) and self._may_be_late(function))
        # an abandoned connection has its own reason, and the system's error only follows from it
        reason = self.reason
        if not isinstance(exc, Exception):
            return exc
        name = function.name
        late = isinstance(exc, DeadlinePassed)
        if self.progress is Progress.NOTHING_SENT:
            return (NotSent if late else ConnectionLost)(f"{name} was not sent, since {reason}")
        if call_kind(name) is not CallKind.READ:
            return OutcomeUnknown(name, reason)
        if late:
            return CallTimeout(f"{name}: {reason}; the connection was closed")
        if isinstance(exc, Ended | OSError):
            return ConnectionLost(f"{name}: {reason}; it only reads, so it may be called again")
        return ProtocolError(f"{name}: {reason}; the connection was closed")

    def _may_be_late(self, function: idl.Function) -> bool:
        """Whether a command was delivered to the last byte, so that its answer may still come."""
        return (
            self._keeps_overdue
            and self.progress is not Progress.NOTHING_SENT
            and call_kind(function.name) is CallKind.COMMAND
            and self.undelivered == 0
        )

    def abandon(self, reason: str = "the call was given up") -> None:
        """Poison the connection from any thread; a call that is under way returns at once."""
        with self._guard:
            if self._life.poison(reason) and self._stream is not None:
                self._stream.shutdown()

    def _end(self, reason: str, *, keep: bool = False) -> None:
        with self._guard:
            self._life.poison(reason)
            if keep:
                self._overdue = self._stream
            else:
                self._drop()

    def _drop(self) -> None:
        with self._guard:
            stream, self._stream = self._stream, None
            self._overdue = None
            if stream is not None:
                stream.discard()

    def forked(self) -> None:
        """This is a forked child: close its copy of the socket, which leaves the parent's open."""
        self._guard = threading.RLock()
        self._life.poison("it belongs to the process that forked this one")
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close_copy()

    def close(self) -> None:
        """Close the connection; on the owner's thread, or on any when no call is under way."""
        with self._guard:
            idle = self._life.state is ConnectionState.IDLE
            self._life.close()
            if idle and self._stream is not None:
                stream, self._stream = self._stream, None
                stream.close()
            self._drop()

    @property
    def undelivered(self) -> int:
        """How many bytes of calls the system still holds; from any thread.

        They are on their way, or the other side does not acknowledge them. 0 without a connection.
        """
        with self._guard:
            return 0 if self._stream is None else self._stream.undelivered

    def late_answer(self, deadline: float) -> bool:
        """Wait for the answer to a command that came too late; only on the owner's thread.

        Only if the connection `keeps_overdue`, and every byte of the command was acknowledged: it
        may be waiting to be read; only its answer shows that it was.

        Args:
            deadline: time of `time.monotonic()` until which to wait.

        Returns:
            Whether it came; the connection is dropped then.
        """
        stream = self._overdue
        if stream is None:
            return False
        try:
            stream.receive(deadline)
        except DeadlinePassed:
            return False
        except (Ended, OSError):
            self._drop()
            return False
        self._drop()
        return True

    @property
    def overdue(self) -> bool:
        """Whether there is an answer for which `late_answer` can wait."""
        return self._overdue is not None


def _check_silent(stream: DeadlineSocket) -> None:
    """Before anything is sent, find out whether the other side closed it or sent bytes."""
    stray = b"" if stream.silent else stream.waiting_bytes()
    if stray:
        raise Malformed(f"bytes came that nobody asked for: {stray!r}")
