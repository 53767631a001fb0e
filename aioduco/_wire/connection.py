"""A connection to the controller: one call at a time, each with its own answer or an error."""

from __future__ import annotations

import errno
import threading
import time
import warnings
from typing import TYPE_CHECKING, Any

from aioduco._wire import codec, idl
from aioduco._wire.deadline_socket import DeadlineSocket
from aioduco._wire.failures import DeadlinePassed, failure, is_failure, reason_of
from aioduco._wire.forks import fork_hooks
from aioduco._wire.framing import Malformed
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.lifecycle import ConnectionState, Lifecycle, Progress
from aioduco.errors import ConnectError, ConnectionLost, NotSent
from aioduco.models.host_port import host_port

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco._wire.endpoint import Address, Endpoint


class Connection:
    """One TCP connection, owned by the thread that opened it or took it over (manual 1.5.1).

    Guarantees: a value is returned only if it is the answer to the present call, by function and
    sequence id. If a call ends in any other way, the connection is POISONED: its socket is closed,
    so that no later call can receive a late answer. Other threads and signal handlers may use only
    `abandon`, `undelivered` and, while no call is under way, `close`.

    Args:
        endpoint: where it leads; `open` must connect within its connect_timeout, for all addresses
            of the host and the resolution of its name together.
        keeps_overdue: whether the connection stays open for `late_answer` if a command was
            delivered completely, but its answer is late. It carries no other call in either case.
        waiting: called every tenth of a second while a call waits for its answer.
    """

    def __init__(
        self,
        endpoint: Endpoint,
        *,
        keeps_overdue: bool = False,
        waiting: Callable[[], object] | None = None,
    ) -> None:
        self.host: str = endpoint.host
        self.port: int = endpoint.port
        self._endpoint = endpoint
        self._waiting = waiting
        self._keeps_overdue = keeps_overdue
        self._life = Lifecycle()
        # Reentrant: a signal handler may abandon the connection while the interrupted code of the
        # same thread changes its state. The lock protects the state and the closing of the socket:
        # `abandon` must never shut down a descriptor that the system has reused for another file.
        self._guard = threading.RLock()
        self._stream: DeadlineSocket | None = None
        #: whether the answer to the last command may still arrive: `late_answer` waits for it
        self.overdue: bool = False
        self._owner: int | None = None
        self._exchange = codec.Exchange(time.monotonic)
        self._was_open = False
        self._calls = 0

    @property
    def state(self) -> ConnectionState:
        """State of the connection."""
        return self._life.state

    @property
    def progress(self) -> Progress:
        """Progress of the last call."""
        return self._life.progress

    @property
    def reason(self) -> str:
        """Why the connection is no longer used; empty while it is in use."""
        return self._life.reason

    def __repr__(self) -> str:
        state = self.state.name
        reason = f": {self.reason}" if self.reason else ""
        return (
            f"<Connection {host_port(self.host, self.port)} {state}{reason}, {self._calls} calls>"
        )

    def __del__(self) -> None:
        if getattr(self, "_stream", None) is not None:
            unclosed = f"unclosed {self!r}"
            self.close()
            # last, since it raises if warnings are turned into errors
            warnings.warn(unclosed, ResourceWarning, source=self, stacklevel=2)

    def open(
        self, deadline: float | None = None, addresses: Sequence[Address] | None = None
    ) -> None:
        """Connect; the calling thread becomes the owner.

        Args:
            deadline: time of `time.monotonic()` by which the connection must be open, if that is
                sooner than the connection's own limit.
            addresses: addresses of the host, if they are known: its name is then not resolved.

        Raises:
            ConnectError: there is no controller, or it does not answer in time.
            ConnectionLost: the connection was abandoned, or has been used before.
        """
        if self.state is not ConnectionState.NEW:
            raise ConnectionLost(f"{self!r} cannot be opened again; nothing was sent")
        self.hand_over()
        fork_hooks.add(self)
        begin = time.monotonic()
        limit = begin + self._endpoint.connect_timeout
        limit = limit if deadline is None else min(limit, deadline)
        try:
            found = list(addresses) if addresses else self._endpoint.resolve(limit)
            self._connect(found, limit)
        except (OSError, UnicodeError, EOFError) as exc:
            given_up = self.state is not ConnectionState.NEW
            self._end("it could not be made")
            if isinstance(exc, OSError) and not is_failure(exc):
                raise  # of a signal handler
            if given_up:
                where = host_port(self.host, self.port)
                raise ConnectionLost(
                    f"the connection to {where} was given up while it was made: {self.reason}; "
                    "nothing was sent"
                ) from None
            if isinstance(exc, ConnectError):
                raise
            raise self._endpoint.refused(exc) from exc
        self._was_open = True
        self._endpoint.made(begin, found)

    def take_over(self, stream: DeadlineSocket) -> None:
        """Use a stream that is connected already; `hand_over` names the owner."""
        fork_hooks.add(self)
        stream.connected(blocking=True)
        self._stream = stream
        self._was_open = self._life.opened()

    def _connect(self, addresses: list[Address], deadline: float) -> None:
        error: OSError = TimeoutError(errno.ETIMEDOUT, "no time was left to connect")
        for address, until in self._endpoint.route.tries(addresses, deadline):
            try:
                stream = DeadlineSocket(address, self._waiting)
                with self._guard:
                    # An `abandon` before this line found no stream to shut down; the state below
                    # shows it. A later `abandon` ends the handshake.
                    self._stream = stream
                    if self._life.state is not ConnectionState.NEW:
                        raise EOFError  # one way out for all ends
                stream.connect(until)
            except OSError as exc:
                self._drop()
                if not is_failure(exc):
                    raise
                error = exc
                continue
            with self._guard:
                if not self._life.opened():
                    raise EOFError
            self._endpoint.route.address = address[-1]
            return
        raise error

    def call(
        self,
        name: str,
        args: tuple[Any, ...],
        timeout: float | None,
        permit: Callable[[], object] | None = None,
    ) -> Any:
        """Call a function of the wire and wait for its answer; only on the owner's thread.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: seconds within which the whole call must end, even if bytes arrive slowly;
                None: no limit.
            permit: as for `exchange`.

        Returns:
            The result; None for a function without one.

        Raises:
            ParameterError: a value cannot be sent; nothing was sent, and the connection is usable.
            ControllerError: the controller answered with an error; the connection is usable.
            ConnectionLost: nothing was sent, or a function that only reads was not answered.
            CallTimeout: a function that only reads was not answered in time.
            ProtocolError: the bytes that came for a function that only reads are not its answer.
            OutcomeUnknown: a command was sent and not answered.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        function = idl.functions()[name]
        return self.exchange(function, codec.encode(function, args), deadline, permit=permit)

    def hand_over(self) -> None:
        """Make the calling thread the owner; no call may be under way or start meanwhile."""
        self._owner = threading.get_ident()

    def exchange(
        self,
        function: idl.Function,
        arguments: bytes,
        deadline: float | None,
        meanwhile: Callable[[], object] | None = None,
        further: Sequence[tuple[idl.Function, bytes]] = (),
        permit: Callable[[], object] | None = None,
    ) -> Any:
        """Send a call whose arguments are encoded, and wait for its answer.

        Args:
            function: the function of the wire.
            arguments: the encoded arguments, from `codec.encode`.
            deadline: time of `time.monotonic()` by which the answer must be complete.
            meanwhile: callback that is called after the call was sent, while the controller
                works.
            further: functions that only read, with their encoded arguments. They are sent right
                after the call; the controller answers all in their order.
            permit: called as the very last thing before the bytes are handed to the socket. If it
                raises, nothing was sent, the connection stays usable, and its error is raised.

        Returns:
            The result, as for `call`; with `further`, a list of `codec.ReadResult`.
        """
        if threading.get_ident() != self._owner:
            raise RuntimeError(f"{self!r} belongs to the thread that opened it")
        if deadline is not None and deadline <= time.monotonic():
            raise NotSent(f"{function.name} was not sent: there was no time left for it")
        with self._guard:
            if not self._life.begin():
                raise ConnectionLost(f"{function.name} cannot use {self!r}; nothing was sent")
            stream = self._stream
        assert stream is not None
        refused = False
        try:
            message = self._exchange.begin(function, arguments, further)
            self._calls += 1 + len(further)
            if stray := stream.unasked():
                raise Malformed(f"bytes came that nobody asked for: {stray!r}")  # noqa: TRY301
            if permit is not None:
                try:
                    permit()
                except Exception:
                    refused = True
                    raise
            self._send(stream, message, deadline)
            if meanwhile is not None:
                meanwhile()
            answer = self._receive(stream, deadline)
        except BaseException as exc:
            if refused:
                self._life.complete()
                raise
            raised = self._failure(function, exc)
            if raised is exc:
                raise
            raise raised from exc
        with self._guard:
            if not self._life.complete():
                # abandoned while the last bytes arrived: the caller already has an error
                raise self._failure(function, EOFError())
        if self._exchange.surplus:
            self._end("bytes came behind an answer")  # the answer itself is valid
        return answer.get()

    def answers_within(self, seconds: float) -> bool:
        """Wait for the first byte of the answer, in `meanwhile`; return whether it has come."""
        return self._stream is None or self._stream.answers_within(seconds)

    def _send(self, stream: DeadlineSocket, data: bytes, deadline: float | None) -> None:
        sent = stream.send(data, deadline)
        self._life.sent()
        while sent < len(data):
            sent += stream.send(memoryview(data)[sent:], deadline)

    def _receive(self, stream: DeadlineSocket, deadline: float | None) -> codec.ReadResult:
        try:
            data = stream.receive(deadline)
        except DeadlinePassed:
            if stream.silent:
                raise
            data = stream.receive_at_once()  # it came while this thread did not run
        self._life.answering()
        while not self._exchange.receive(data):
            data = stream.receive(deadline)
        return self._exchange.take()

    def _failure(self, function: idl.Function, exc: BaseException) -> BaseException:
        """Poison the connection and choose the error for the caller; only this method does so."""
        reason = reason_of(exc, self.progress)
        self._end(reason, keep=isinstance(exc, DeadlinePassed) and self._may_be_late(function))
        # an abandoned connection already has a reason, which caused the error of the system
        reason = self.reason
        if not is_failure(exc):
            return exc
        return failure(function, self.progress, exc, reason)

    def _may_be_late(self, function: idl.Function) -> bool:
        """Whether a command was delivered completely, so that its answer may still arrive."""
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
            self.overdue = keep and self._stream is not None
            if not keep:
                self._drop()

    def _drop(self) -> None:
        with self._guard:
            stream, self._stream = self._stream, None
            self.overdue = False
            if stream is not None:
                stream.discard()
        if self._was_open:
            self._was_open = False
            self._endpoint.ended(self.reason)

    def forked(self) -> None:
        """In a forked child: close the child's copy of the socket; the parent's stays open."""
        self._guard = threading.RLock()
        self._life.poison("it belongs to the process that forked this one")
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.socket.close()

    def close(self) -> None:
        """Close the connection; on the owner's thread, or on any while no call is under way."""
        with self._guard:
            idle = self._life.state is ConnectionState.IDLE
            self._life.close()
            if idle and self._stream is not None:
                stream, self._stream = self._stream, None
                stream.close()
            self._drop()

    @property
    def undelivered(self) -> int:
        """Number of sent bytes that the other side has not acknowledged; from any thread.

        The operating system still holds them. 0 without a connection.
        """
        with self._guard:
            return 0 if self._stream is None else self._stream.undelivered

    def late_answer(self, deadline: float) -> bool:
        """Wait for the late answer to a command; only on the owner's thread.

        It waits only if the connection `keeps_overdue` and every byte of the command was
        acknowledged. The controller may not have read the command yet; only the answer shows that
        it has.

        Args:
            deadline: time of `time.monotonic()` until which to wait.

        Returns:
            Whether the answer arrived; the connection is dropped then.
        """
        stream = self._stream
        if stream is None or not self.overdue:
            return False
        try:
            stream.receive(deadline)
        except DeadlinePassed:
            return False
        except (EOFError, OSError):
            self._drop()
            return False
        self._drop()
        return True
