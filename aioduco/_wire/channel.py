"""A connection on the event loop: one call at a time, each with its own answer or an error."""

from __future__ import annotations

import asyncio
import errno
import os
import socket
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from aioduco._wire import codec, failures
from aioduco._wire.deadline_socket import DeadlineSocket
from aioduco._wire.endpoint import Address, Endpoint, Lookup
from aioduco._wire.framing import Malformed
from aioduco._wire.lifecycle import ConnectionState, Lifecycle, Progress
from aioduco._wire.owner_loop import loop_callback
from aioduco.errors import (
    ConnectError,
    ConnectionLost,
    DucoError,
    NotSent,
    OutcomeUnknown,
    WrongProcess,
)

if TYPE_CHECKING:
    from collections import deque
    from collections.abc import Callable, Coroutine, Sequence

    from aioduco._wire.idl import Function


@dataclass(slots=True, eq=False)
class Call:
    """One call under way.

    Attributes:
        function: the function of the wire.
        arguments: its encoded arguments.
        deadline: time of `time.monotonic()` by which it must be over, or None.
        permit: called as the very last thing before the bytes are handed to the socket; its error
            ends the call, of which nothing was sent.
        further: functions that only read, with their encoded arguments. They are sent after it;
            its value is then a list of `codec.ReadResult`, its own result first.
        handed_over: whether a connection was asked to send it.
        fresh: whether it is the first call on its connection: it is not sent on another one.
        first: error of its first attempt, if this is the second.
    """

    function: Function
    arguments: bytes
    deadline: float | None
    permit: Callable[[], object] | None = None
    further: Sequence[tuple[Function, bytes]] = ()
    handed_over: bool = False
    fresh: bool = False
    first: ConnectionLost | None = None

    @property
    def name(self) -> str:
        """Name of the function, for messages."""
        return self.function.name

    def late(self) -> bool:
        """Whether its deadline has passed."""
        return self.deadline is not None and self.deadline <= time.monotonic()

    def failed(self, progress: Progress, exc: BaseException, reason: str) -> ConnectionLost:
        """Make its error after its connection failed or was given up, see `failure`."""
        error = failures.failure(self.function, progress, exc, reason)
        error.__cause__ = exc
        return error

    def may_move(self, progress: Progress) -> bool:
        """Whether it may be sent on another connection, since its own failed."""
        again = bool(self.further) or failures.may_send_again(self.function, progress)
        return again and not self.fresh and not self.late()


@dataclass(slots=True, eq=False)
class LaneCall(Call):
    """A call of a lane. It goes on to its end whether or not a task waits for it.

    Attributes:
        args: its arguments as they were given, for reports.
        over: resolved when it is over; then one of `value` and `error` is set.
        ended: called once, when it is over.
        begun: when it was made [s of `time.monotonic`].
        ended_at: when it was over; None before.
        carrier: what carries it; None while it waits for that.
        abandoned: whether it was given up by its caller.
        value: the answer.
        error: why there is no answer.
    """

    args: tuple[Any, ...] = field(kw_only=True)
    over: asyncio.Future[None] = field(kw_only=True)
    ended: Callable[[LaneCall], object] = field(kw_only=True)
    begun: float = field(kw_only=True)
    ended_at: float | None = None
    carrier: Carrier | None = None
    abandoned: bool = False
    value: Any = None
    error: BaseException | None = None

    def __repr__(self) -> str:
        sent = "handed over" if self.handed_over else "not sent yet"
        return f"<LaneCall {self.name} {sent if self.ended_at is None else 'over'}>"

    @property
    def undelivered(self) -> int:
        """Number of sent bytes that the other side has not acknowledged."""
        carrier = self.carrier
        return carrier.undelivered if carrier is not None and carrier.call is self else 0

    @property
    def answered(self) -> bool:
        """Whether its result is certain: it was answered, also by an error, or it was not sent."""
        if self.ended_at is None or isinstance(self.error, OutcomeUnknown):
            return False
        return self.error is None or isinstance(self.error, DucoError)

    async def wait(self, timeout: float | None = None) -> bool:
        """Wait until it is over. Cancelling this changes nothing: the call goes on.

        Args:
            timeout: most seconds to wait; None for no limit.

        Returns:
            Whether it is over.
        """
        if self.ended_at is None:
            await asyncio.wait([self.over], timeout=timeout)
        return self.ended_at is not None

    async def answer(self) -> Any:
        """Wait for the answer and return it; cancelling this abandons the call.

        Raises:
            The errors of `WireLane.call`.
        """
        try:
            await self.over
        except BaseException:
            self.abandon()
            raise
        error, self.error = self.error, None
        if error is None:
            return self.value
        try:
            raise error
        finally:
            del error  # its traceback refers to this frame, which makes a reference cycle

    def abandon(self, reason: str = "the call was cancelled", *, late: bool = False) -> None:
        """End it, unless it is over. Bytes that were not delivered by now never will be.

        Args:
            reason: why, for its error and that of its connection, which is reset.
            late: whether its time is over, which is then its error.
        """
        if self.ended_at is not None:
            return
        self.abandoned = True
        if self.carrier is None:
            self.end(error=NotSent(f"{self.name} was not sent, since {reason}"))
        else:
            self.carrier.give_up(self, reason, failures.DeadlinePassed() if late else EOFError())

    def end(self, value: Any = None, error: BaseException | None = None) -> None:
        """Note the outcome, and wake the task that waits for it."""
        try:
            if self.ended_at is None:
                self.ended_at = time.monotonic()
                self.value = value
                self.error = error
                self.ended(self)
        finally:  # there may be no memory to report it
            if not self.over.done() and not self.over.get_loop().is_closed():
                self.over.set_result(None)


class Carrier(ABC):
    """What carries the calls of a lane, one at a time: a `Channel` or a `PoolThread`.

    Args:
        loop: the event loop, on which all methods are called.
        endpoint: where its connections lead.
        waiting: calls that wait for one of the lane's carriers; whenever it is free, it takes the
            next of them.

    Attributes:
        call: the call under way.
    """

    def __init__(
        self, loop: asyncio.AbstractEventLoop, endpoint: Endpoint, waiting: deque[LaneCall]
    ) -> None:
        self._loop = loop
        self._endpoint = endpoint
        self._waiting = waiting
        #: whether the calls that wait are being taken: their ends do not take others
        self._taking = False
        self.call: LaneCall | None = None

    @property
    def undelivered(self) -> int:
        """Number of sent bytes that the other side has not acknowledged."""
        return 0

    @abstractmethod
    def take(self, call: LaneCall) -> bool:
        """Take a call; there must be none. Returns whether the caller must now `send` it."""

    @abstractmethod
    def send(self, call: LaneCall) -> None:
        """Send the call that was taken, before anything else runs on the loop."""

    @abstractmethod
    def expire(self, call: LaneCall) -> None:
        """End a call whose deadline has passed, unless its end is certain anyway."""

    @abstractmethod
    def give_up(self, call: LaneCall, reason: str, exc: BaseException) -> None:
        """End a call that was abandoned, or whose lane is closed; its connection is reset.

        Args:
            call: the call.
            reason: why, in words.
            exc: the same as for `failure`.
        """

    def _end(self, value: Any = None, error: BaseException | None = None) -> None:
        call, self.call = self.call, None
        try:
            if not self._taking:
                self._take_next()
        finally:  # there may be no memory to send the next call
            if call is not None:
                call.end(value, error)

    def _take_next(self) -> None:
        self._taking = True
        try:
            while self._waiting and self.call is None:
                following = self._waiting.popleft()
                if not following.over.done() and self.take(following):
                    self.send(following)
        finally:
            self._taking = False


class Channel(Carrier):
    """One of a lane's connections on its event loop; opened again when a call needs it.

    Guarantees: a value is returned only if it is the answer to the present call, by function and
    sequence id. If a call ends in any other way, its connection is reset at once, so that no
    later call can receive a late answer. Nothing here blocks, and all of it runs on the loop.
    """

    def __init__(
        self, loop: asyncio.AbstractEventLoop, endpoint: Endpoint, waiting: deque[LaneCall]
    ) -> None:
        super().__init__(loop, endpoint, waiting)
        #: state, progress of the present or the last call, and end of the connection
        self.life: Lifecycle = Lifecycle()
        self._stream: DeadlineSocket | None = None
        self._exchange = codec.Exchange(time.monotonic)
        #: the part of the message that the system has not accepted yet
        self._rest = b""
        #: whether the loop reports that bytes have come; else a task waits for each answer
        self._reports = True
        #: opens the connection for the present call
        self._opening: asyncio.Task[None] | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        #: whether this is a forked child, whose parent has the calls
        self._inherited = False

    @property
    def undelivered(self) -> int:
        """Number of sent bytes that the other side has not acknowledged."""
        return 0 if self._stream is None else self._stream.undelivered

    @property
    def connected(self) -> bool:
        """Whether its connection is open, as far as this system knows; between calls."""
        return self._stream is not None and self._stream.silent

    # A call

    def take(self, call: LaneCall) -> bool:
        """Take a call; there must be none. Returns whether the caller must now `send` it.

        If not, a connection is opened for it first, or the call is over.
        """
        self.call, call.carrier = call, self
        if self._not_to_be_sent(call):
            return False
        stream = self._stream
        if stream is not None:
            # a batch only reads, and is sent again if the connection is lost
            if (call.further or stream.silent) and self.life.begin():
                return True
            self._drop("the controller closed the connection, or sent what nobody asked for")
        self._open_for(call)
        return False

    def send(self, call: LaneCall) -> None:
        """Send the call that was taken, before anything else runs on the loop."""
        stream = self._stream
        assert stream is not None
        message = self._exchange.begin(call.function, call.arguments, call.further)
        if call.permit is not None:
            try:
                call.permit()
            except Exception as exc:
                self.life.complete()
                self._exchange.forget()
                self._end(error=exc)
                return
        call.handed_over = True
        sent = stream.send_at_once(message)
        if sent > 0:
            self.life.sent()
        if sent != len(message):
            self._rest = message[max(sent, 0) :]
        if not self._reports:
            self._begin(self._receive(call, stream))
        elif self._rest:
            self._loop.add_writer(stream.socket.fileno(), self._writable)

    def expire(self, call: LaneCall) -> None:
        # a connection that is being opened for it has the same deadline
        if self.call is call and self._opening is None:
            self._lost(failures.DeadlinePassed())

    def give_up(self, call: LaneCall, reason: str, exc: BaseException) -> None:
        """End a call that was abandoned, or whose lane is closed; its connection is reset."""
        if self.call is not call:
            return
        progress = self.life.progress
        if self._opening is not None:
            self._opening.cancel()
            self._opening, progress = None, Progress.NOTHING_SENT
        self._drop(reason)
        self._end(error=failures.of_two(call.first, call.failed(progress, exc, reason)))

    # Its connection

    async def open(self, deadline: float) -> None:
        """Open the connection before a call needs it."""
        stream = await connect(self._loop, self._endpoint, deadline)
        stream.connected(blocking=False)
        self.life = Lifecycle()
        self.life.opened()
        self._stream = stream
        try:
            self._loop.add_reader(stream.socket.fileno(), self._readable)
        except NotImplementedError:  # Windows' default loop, which reports no readiness
            self._reports = False

    def close(self, reason: str) -> None:
        """Close the connection; on the loop."""
        if self.call is not None:
            self.give_up(self.call, reason, EOFError())
        stream = self._stream
        if stream is not None and self.life.state is ConnectionState.IDLE:
            self._stream = None
            self.life.close()
            self._detach(stream)
            stream.close()
            self._endpoint.ended(self.life.reason)

    def forget(self) -> None:
        """Close the connection although its loop has been closed: no task waits any more."""
        self.call = self._opening = None
        self._drop("its event loop was closed")

    def forked(self) -> None:
        """In a forked child: close the child's copy of the socket; the parent's stays open.

        The parent goes on with the calls: the child's copies of them end, and none is sent again.
        """
        self._inherited = True
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.socket.close()

    async def closed(self) -> None:
        """Wait until nothing runs for it any more."""
        await asyncio.gather(*self._tasks, return_exceptions=True)

    def _not_to_be_sent(self, call: LaneCall) -> bool:
        """End a call that is too late, or its parent's, before it is sent; return whether it is."""
        error: DucoError
        if self._inherited:
            error = WrongProcess(
                f"{call.name} was not sent: its robot belongs to the process that forked this one. "
                "Open another one in this process"
            )
        elif call.late():
            error = NotSent(f"{call.name} was not sent: there was no time left for it")
        else:
            return False
        self._end(error=failures.of_two(call.first, error))
        return True

    def _open_for(self, call: LaneCall) -> None:
        call.fresh = True
        self._opening = self._begin(self._reopen(call))

    async def _reopen(self, call: LaneCall) -> None:
        limit = time.monotonic() + self._endpoint.connect_timeout
        try:
            await self.open(limit if call.deadline is None else min(limit, call.deadline))
            self._opening = None
            # Its deadline may have passed just now; nothing would end it after that.
            if not self._not_to_be_sent(call) and self.life.begin():
                self.send(call)
        except ConnectError as exc:
            self._opening = None
            self._end(error=failures.of_two(call.first, exc))
        except BaseException:
            self.give_up(call, "the wait for its connection was interrupted", EOFError())
            raise

    def _begin(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        task = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    # Bytes

    def _writable(self) -> None:
        """Send a part of the rest; the controller executes nothing of which a part is missing."""
        stream, call = self._stream, self.call
        if stream is None:  # a forked child, whose handler was due already
            return
        if call is not None and call.permit is not None:
            try:
                call.permit()
            except Exception as exc:
                self._drop("the permit of its call ended before all of it was sent")
                self._end(error=exc)
                return
        sent = max(stream.send_at_once(self._rest), 0)
        if sent:
            self.life.sent()
            self._rest = self._rest[sent:]
        if not self._rest:
            self._loop.remove_writer(stream.socket.fileno())

    def _readable(self) -> None:
        stream = self._stream
        if stream is None:  # as above
            return
        try:
            data = stream.receive_at_once()
        except BlockingIOError:
            return
        except (EOFError, OSError) as exc:
            self._lost(exc)
            return
        self._received(data)

    def _received(self, data: bytes) -> None:
        exchange = self._exchange
        if not exchange.expects:
            self._lost(Malformed(f"bytes came that nobody asked for: {data[:64]!r}"))
            return
        self.life.answering()
        try:
            if not exchange.receive(data):
                return
        except Exception as exc:
            self._lost(exc)
            return
        self.life.complete()
        answer = exchange.take()
        if exchange.surplus or self._rest:
            self._drop("bytes came behind an answer")  # the answer itself is valid
        self._end(answer.value, answer.error)

    async def _receive(self, call: LaneCall, stream: DeadlineSocket) -> None:
        """Send the rest and wait for the answer, on a loop that reports nothing."""
        try:
            if self._rest:
                await self._loop.sock_sendall(stream.socket, self._rest)
                self._rest = b""
                self.life.sent()
            while self.call is call and self._stream is stream:
                data = await self._loop.sock_recv(stream.socket, 16384)
                if self.call is not call or self._stream is not stream:
                    return
                if not data:
                    raise EOFError  # noqa: TRY301  # one way out for all failures
                self._received(data)
        except (EOFError, OSError) as exc:
            if self.call is call and self._stream is stream:
                self._lost(exc)

    # Ends

    def _lost(self, exc: BaseException) -> None:
        """Drop a connection that failed; its call moves to another one, or has an error."""
        call, progress = self.call, self.life.progress
        reason = self._drop(failures.reason_of(exc, progress))
        if call is None:
            return
        error = call.failed(progress, exc, reason)
        if call.may_move(progress) and not self._inherited:
            call.first = error
            self._open_for(call)
        else:
            self._end(error=failures.of_two(call.first, error))

    def _drop(self, reason: str) -> str:
        """Reset the connection, and return why it is not used any more."""
        stream, self._stream = self._stream, None
        self._exchange.forget()
        self._rest = b""
        self.life.poison(reason)
        if stream is not None:
            self._detach(stream)
            self._endpoint.ended(self.life.reason)
        return self.life.reason

    def _detach(self, stream: DeadlineSocket) -> None:
        """Take a stream from the loop, and discard it unless it is idle."""
        ended = self._loop.is_closed()
        if self._reports and not ended:
            self._loop.remove_reader(stream.socket.fileno())
            self._loop.remove_writer(stream.socket.fileno())
        if self.life.state is ConnectionState.CLOSED:
            return
        waiting = [task for task in self._tasks if task is not self._opening]
        if self._reports or ended or not waiting:
            stream.discard()
            return
        # The loop waits for its bytes: the descriptor may be used again only when it does no more.
        stream.shutdown()
        for task in waiting:
            task.cancel()
            task.add_done_callback(lambda _: stream.discard())


async def connect(
    loop: asyncio.AbstractEventLoop, endpoint: Endpoint, deadline: float
) -> DeadlineSocket:
    """Connect without blocking the event loop; its name is resolved on a thread.

    Args:
        loop: the running event loop.
        endpoint: where to.
        deadline: time of `time.monotonic()` by which it must be done.

    Raises:
        ConnectError: there is no controller, or it does not answer in time.
    """
    begin = time.monotonic()
    error: BaseException = TimeoutError("no time was left to connect")
    addresses = await resolve(endpoint, deadline)
    for each, until in endpoint.route.tries(addresses, deadline):
        try:
            stream = DeadlineSocket(each)
            try:
                stream.prepare()
                try:
                    async with asyncio.timeout(max(0.0, until - time.monotonic())):
                        await _connect(loop, stream.socket, each[-1])
                except TimeoutError:
                    # a loop that stood still is told of the connection and of the time at once
                    if not stream.has_peer:
                        raise
            except BaseException:
                stream.discard()
                raise
        except OSError as exc:
            error = exc
            continue
        endpoint.route.address = each[-1]
        endpoint.made(begin, addresses)
        return stream
    raise endpoint.refused(error) from error


async def resolve(endpoint: Endpoint, deadline: float) -> list[Address]:
    """As `Endpoint.resolve`, without blocking the event loop.

    Raises:
        ConnectError: there are none, or they are not known in time.
    """
    found = endpoint.lookup()
    if not isinstance(found, Lookup):
        return found
    over = asyncio.Event()
    found.when_over(loop_callback(over.set))
    try:
        async with asyncio.timeout(max(0.0, deadline - time.monotonic())):
            await over.wait()
        return found.addresses()
    except (OSError, UnicodeError) as exc:
        raise endpoint.refused(exc) from exc


async def _connect(loop: asyncio.AbstractEventLoop, sock: socket.socket, address: Any) -> None:
    """Connect a non-blocking socket to an address of `socket.getaddrinfo`.

    uvloop's `sock_connect` resolves the address again, on threads of libuv's; a child that is
    forked after that crashes at its end (`uv__threadpool_cleanup`).
    """
    writable = asyncio.Event()
    number = sock.fileno()  # a forked child closes its copy
    try:
        loop.add_writer(number, writable.set)
    except NotImplementedError:  # Windows' default loop
        await loop.sock_connect(sock, address)
        return
    loop.remove_writer(number)  # a socket that does not connect yet counts as writable
    error = sock.connect_ex(address)
    if error in (errno.EINPROGRESS, errno.EINTR):
        loop.add_writer(number, writable.set)
        try:
            await writable.wait()
        finally:
            loop.remove_writer(number)
        error = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
    if error:
        raise OSError(error, os.strerror(error))
