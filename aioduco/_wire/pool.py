"""Connections of threads: for calls that block at the controller, and for a program's threads.

The manual (1.5.1) asks for a client of its own for each thread that calls.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from queue import SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING, Any, Final

from aioduco._wire.channel import Call, Carrier, LaneCall
from aioduco._wire.failures import of_two
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.lifecycle import Progress
from aioduco._wire.own_connection import OwnConnection
from aioduco._wire.owner_loop import loop_callback
from aioduco.errors import ConnectError, ConnectionLost

if TYPE_CHECKING:
    from collections import deque
    from collections.abc import Callable

    from aioduco._wire.connection import Connection
    from aioduco._wire.deadline_socket import DeadlineSocket
    from aioduco._wire.endpoint import Endpoint


#: seconds to wait for the end of a thread, which has nothing to wait for any more but a name
_JOIN_LIMIT: Final = 1.0
#: seconds after which a stop is sent on a second connection as well
_SECOND_STOP_AFTER: Final = 0.1


def _carry_out(
    own: OwnConnection, call: Call, meanwhile: Callable[[], object] | None = None
) -> Any:
    """Call a function and wait for its answer, on another connection if this one has ended."""
    if own.idle:
        try:
            return _exchange(own.connection, call, meanwhile)
        except ConnectionLost as exc:
            if own.given_up or not call.may_move(own.connection.progress):
                raise
            call.first = exc
    try:
        return _exchange(own.ready(call.deadline), call, meanwhile)
    except (ConnectError, ConnectionLost) as exc:
        raise of_two(call.first, exc) from exc.__cause__


def _exchange(connection: Connection, call: Call, meanwhile: Callable[[], object] | None) -> Any:
    # if the call was given up before, its connection is poisoned and sends nothing
    call.handed_over = True
    return connection.exchange(
        call.function, call.arguments, call.deadline, meanwhile, call.further, call.permit
    )


class PoolThread(Carrier):
    """A thread with a connection of its own.

    Guarantees: a call that was given up sends nothing afterwards, and its thread comes back at
    once, or, if it is being connected, within the time limit for that. The thread is a daemon: a
    program that does not close a lane must still be able to end.
    """

    def __init__(
        self, loop: asyncio.AbstractEventLoop, endpoint: Endpoint, waiting: deque[LaneCall]
    ) -> None:
        super().__init__(loop, endpoint, waiting)
        self._inbox: SimpleQueue[LaneCall | Callable[[], object]] = SimpleQueue()
        self._own = OwnConnection(endpoint)
        self._thread: Thread | None = None
        self._ended = asyncio.Event()

    @property
    def undelivered(self) -> int:
        """Number of sent bytes that the other side has not acknowledged."""
        return self._own.connection.undelivered

    def take(self, call: LaneCall) -> bool:
        """Pass a call to the thread, which sends it and keeps its deadline."""
        self.call, call.carrier, self._own.given_up = call, self, ""
        if self._thread is None:
            name = f"aioduco-{self._endpoint.purpose}"
            thread = Thread(target=self._run, name=name, daemon=True)
            try:
                thread.start()
            except RuntimeError as exc:
                lost = ConnectionLost(f"{call.name} was not sent: no thread for it ({exc})")
                lost.__cause__ = exc
                self._end(error=lost)
                return False
            self._thread = thread
        self._inbox.put(call)
        return False

    def send(self, call: LaneCall) -> None:
        """Do nothing: the thread sends what it is passed."""

    def expire(self, call: LaneCall) -> None:
        """Do nothing: the thread keeps the deadline of its call."""

    def give_up(self, call: LaneCall, reason: str, exc: BaseException) -> None:
        """Make the thread drop its call. It is free when it has come back."""
        if self.call is call and not self._own.given_up:
            self._own.give_up(reason)
            # The thread may be within the send: the system may have bytes of which nothing says so.
            progress = Progress.SENT if call.handed_over else Progress.NOTHING_SENT
            call.end(error=of_two(call.first, call.failed(progress, exc, reason)))

    async def open(self, deadline: float) -> None:
        """Do nothing: the thread opens its connection for its first call."""

    def close(self, reason: str) -> None:
        """Make the thread close its connection and end."""
        if self.call is not None:
            self.give_up(self.call, reason, EOFError())
        self._inbox.put(loop_callback(self._ended.set))

    async def closed(self) -> None:
        """Wait for the end of the thread, but not long: nothing ends a wait for a name server."""
        if self._thread is not None:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_JOIN_LIMIT):
                    await self._ended.wait()
                self._thread.join(_JOIN_LIMIT)

    def forget(self) -> None:
        """Make the thread end, although nobody waits for that."""
        self._inbox.put(self._ended.is_set)

    def forked(self) -> None:
        """Do nothing: the connection closes its copy, and the thread does not run in the child."""

    def _run(self) -> None:
        while isinstance(item := self._inbox.get(), LaneCall):
            value: Any = None
            error: BaseException | None = None
            try:
                value = _carry_out(self._own, item)
            except BaseException as exc:
                error = exc  # raised where the call is awaited
            with contextlib.suppress(RuntimeError):  # the loop is closed: no task waits any more
                self._loop.call_soon_threadsafe(self._end, value, error)
            del item, value, error
        self._own.close()
        item()


class ThreadCalls:
    """Calls that block a thread or a signal handler: without a lock, and without an event loop.

    A call takes the spare connection, and opens one if that is in use, so it never waits behind
    another call. One connection that was used is kept as the spare one. A connection belongs to the
    thread that took it, until it is put back.

    Args:
        endpoint: where the connections lead.
    """

    def __init__(self, endpoint: Endpoint) -> None:
        self._endpoint = endpoint
        # Lists take and give their last element in one step, which no signal can divide.
        self._spare: list[OwnConnection] = []
        self._closed = False

    def keep(self, stream: DeadlineSocket) -> None:
        """Keep a stream that is connected as the spare connection."""
        own = OwnConnection(self._endpoint, hurried=True)
        own.connection.take_over(stream)
        self._put_back(own)

    def close(self) -> None:
        """Close the spare connection; a call that is under way closes its own at its end."""
        self._closed = True
        while self._spare:
            self._take().close()

    def call(self, call: Call) -> Any:
        """Carry out a call and block until its answer has arrived."""
        own = self._take()
        again: list[Any] = []

        def stop_again() -> None:
            left = _SECOND_STOP_AFTER
            if call.deadline is not None:
                left = min(left, call.deadline - time.monotonic())
            if again or own.connection.answers_within(max(0.0, left)):
                return
            other = OwnConnection(self._endpoint, hurried=True)
            try:
                again.append(_carry_out(other, call))
            except (ConnectError, ConnectionLost):
                return  # the first may be answered yet
            finally:
                self._put_back(other)
            own.give_up("a second stop was answered")

        try:
            return _carry_out(
                own, call, stop_again if call_kind(call.name) is CallKind.STOP else None
            )
        except ConnectionLost:
            if again:
                return again[0]
            raise
        finally:
            self._put_back(own)

    def _take(self) -> OwnConnection:
        try:
            own = self._spare.pop()
        except IndexError:
            return OwnConnection(self._endpoint, hurried=True)
        own.connection.hand_over()
        return own

    def _put_back(self, own: OwnConnection) -> None:
        if self._spare or not own.idle:
            own.close()
            return
        self._spare.append(own)
        if self._closed:
            self.close()
