"""A thread that owns a connection, and the hand-off between it and the event loop.

The only module that knows asyncio. A call is handed over by a `SimpleQueue` and comes back by
`call_soon_threadsafe`: measured, a third cheaper than `anyio.to_thread`, and the thread can own
its connection, as the manual asks (1.5.1).
"""

from __future__ import annotations

import asyncio
import enum
import math
import threading
import time
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final, Protocol

from aioduco._wire.lifecycle import ConnectionState, Progress
from aioduco._wire.semantics import kind
from aioduco.errors import ConnectError, ConnectionLost, NotSent

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from aioduco._wire.connection import Connection
    from aioduco._wire.idl import Function

#: seconds after its deadline at which a call is given up although its thread has not come back
GRACE: Final = 0.25


class Dropped(enum.Enum):
    """What became of a call that was abandoned."""

    OVER = "it was over before"
    UNSENT = "nothing of it was sent, or will be"
    UNKNOWN = "something of it may have been sent"


class Call:
    """One call on its way: what is sent, by when, and what came of it.

    Its parts have one writer each: the thread writes `value` and `error`, then calls `notify`;
    whoever waits writes `abandoned`.

    Args:
        function: the function of the wire; None only opens the connection.
        arguments: its encoded arguments.
        deadline: time of `time.monotonic()`, or None.
    """

    __slots__ = ("abandoned", "arguments", "deadline", "error", "function", "value", "worker")

    def __init__(self, function: Function | None, arguments: bytes, deadline: float | None) -> None:
        self.function = function
        self.arguments = arguments
        self.deadline = deadline
        self.value: Any = None
        self.error: BaseException | None = None
        self.abandoned = False
        self.worker: Worker | None = None

    @property
    def name(self) -> str:
        """What is called, for messages."""
        return self.function.name if self.function is not None else "open"

    def notify(self) -> None:
        """Wake whoever waits; on the worker's thread."""
        raise NotImplementedError


class AwaitedCall(Call):
    """A call that a task of the running event loop awaits.

    Args:
        finished: called on the loop when the thread is done with the call.
    """

    __slots__ = ("_finished", "_future", "loop", "overdue")

    def __init__(
        self,
        function: Function | None,
        arguments: bytes,
        deadline: float | None,
        finished: Callable[[AwaitedCall], None],
    ) -> None:
        super().__init__(function, arguments, deadline)
        self.loop = asyncio.get_running_loop()
        self._future: asyncio.Future[Any] = self.loop.create_future()
        self._finished = finished
        #: whether its deadline has been seen to pass once
        self.overdue = False

    @property
    def refused(self) -> bool:
        """Whether nobody waits any more; such a call is not handed to a thread."""
        return self._future.done()

    @property
    def due(self) -> float:
        """When to look whether the call is over: at its deadline, then `GRACE` later."""
        if self.deadline is None:
            return math.inf
        return self.deadline + GRACE if self.overdue else self.deadline

    def __await__(self) -> Generator[Any, None, Any]:
        """Wait for the value; raises what the call raised."""
        return self._future.__await__()

    def notify(self) -> None:
        """Have `finished` called on the loop."""
        try:
            self.loop.call_soon_threadsafe(self._finished, self)
        except RuntimeError:
            # the loop is closed: nobody waits any more, and the thread lives on for the next
            return

    def settle(self) -> None:
        """Give the waiting task what the thread left; on the loop."""
        error, self.error = self.error, None
        if self._future.done():
            return
        if error is not None:
            # not kept here too: its traceback knows this call, which would be a cycle
            self._future.set_exception(error)
        else:
            self._future.set_result(self.value)

    def fail(self, error: BaseException) -> None:
        """Have the waiting task raise this; on the loop."""
        if not self._future.done():
            self._future.set_exception(error)


class Deadlines:
    """Sees that no task waits past its deadline, even if a thread hangs.

    One timer for all calls of a lane: set for the earliest deadline, and looked after when it
    rings. A timer per call would cost as much as a tenth of a call.

    Args:
        expired: called on the loop with a call whose deadline has passed and False, and once
            more with True if the call is still there `GRACE` later.
    """

    def __init__(self, expired: Callable[[AwaitedCall, bool], None]) -> None:
        self._expired = expired
        #: the calls that somebody awaits
        self.calls: set[AwaitedCall] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._rings_at = math.inf

    def add(self, call: AwaitedCall) -> None:
        """Watch a call until it is discarded."""
        self.calls.add(call)
        if call.deadline is None:
            return
        if call.deadline < self._rings_at or call.loop is not self._loop:
            self._set(call.loop, call.deadline)

    def discard(self, call: AwaitedCall) -> None:
        """Watch the call no more. The timer is left as it is: the next call will use it."""
        self.calls.discard(call)

    def stop(self) -> None:
        """Watch nothing any more."""
        self.calls.clear()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        self._rings_at = math.inf

    def _set(self, loop: asyncio.AbstractEventLoop, at: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._loop = loop
        self._rings_at = at
        self._timer = loop.call_later(at - time.monotonic(), self._ring)

    def _ring(self) -> None:
        now = time.monotonic()
        self._timer = None
        self._rings_at = math.inf
        for call in [call for call in self.calls if call.due <= now]:
            again, call.overdue = call.overdue, True
            self._expired(call, again)
            if again:
                self.calls.discard(call)
        next_due = min((call.due for call in self.calls), default=math.inf)
        if self._loop is not None and next_due < math.inf:
            self._set(self._loop, next_due)


class BlockingCall(Call):
    """A call that a thread, or a signal handler, waits for without an event loop."""

    __slots__ = ("_done", "_released")

    def __init__(
        self,
        function: Function,
        arguments: bytes,
        deadline: float | None,
        released: Callable[[], None],
    ) -> None:
        super().__init__(function, arguments, deadline)
        self._done: SimpleQueue[None] = SimpleQueue()
        self._released = released

    def wait(self, patience: float | None) -> bool:
        """Wait for the thread; whether it is done with the call.

        Args:
            patience: most seconds to wait; None: until a little after the deadline.
        """
        if patience is None and self.deadline is not None:
            patience = self.deadline + GRACE - time.monotonic()
        try:
            self._done.get(timeout=patience if patience is None else max(patience, 0.0))
        except Empty:
            return False
        return True

    def outcome(self) -> Any:
        """The value, once the thread is done; raises what the call raised."""
        error, self.error = self.error, None
        if error is not None:
            raise error
        return self.value

    def notify(self) -> None:
        """Wake the thread that waits."""
        self._done.put(None)
        self._released()


class Source(Protocol):
    """Where the connections of workers come from, and who is told about them."""

    def make(self) -> Connection:
        """Make a connection that is not open yet."""
        ...

    def opened(self, connection: Connection, duration: float) -> None:
        """A connection was opened, within so many seconds; called on the worker's thread."""
        ...

    def ended(self, connection: Connection) -> None:
        """A connection is not used any more; called on the worker's thread."""
        ...


class Worker:
    """A thread with a connection of its own.

    Guarantees: one call at a time, given by whoever holds the claim. The connection is opened,
    used and closed on this thread; a call that is abandoned never sends anything afterwards.
    The thread is a daemon, since a program that forgets to close a lane, or whose name server
    hangs, must still come to its end; `farewell` is how a lane sees it end.

    Args:
        name: name of the thread.
        source: where its connections come from.
    """

    def __init__(self, name: str, source: Source) -> None:
        self.name = name
        self._source = source
        self._inbox: SimpleQueue[Call | Callable[[], None]] = SimpleQueue()
        # Held while a call is under way. Only ever tried, never waited for, so that a signal
        # handler can claim a worker in the middle of the loop's own code.
        self._claim = threading.Lock()
        # Held for moments, so that a call cannot end, and the next one begin, while it is being
        # abandoned. Reentrant for the signal handler.
        self._lock = threading.RLock()
        self._current: Call | None = None
        self._connection: Connection | None = None
        self._is_open = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._started = False
        #: set when the lane is done with this worker
        self.retired = False

    @property
    def connection(self) -> Connection | None:
        """The connection that is used now, if any."""
        return self._connection

    @property
    def alive(self) -> bool:
        """Whether the thread runs."""
        return self._thread.is_alive()

    @property
    def busy(self) -> bool:
        """Whether a call is under way."""
        return self._claim.locked()

    def __repr__(self) -> str:
        state = "retired" if self.retired else "busy" if self.busy else "idle"
        return f"<Worker {self.name} {state}, {self._connection!r}>"

    def claim(self) -> bool:
        """Take the worker for one call, if it is free; never waits."""
        return not self.retired and self._claim.acquire(blocking=False)

    def submit(self, call: Call) -> None:
        """Hand a call to the thread; the claim must be held, and is released by the thread."""
        if not self._started:
            self._thread.start()
            self._started = True
        call.worker = self
        self._current = call
        self._inbox.put(call)

    def abandon(self, call: Call | None, reason: str) -> Dropped:
        """Have the thread drop a call, from any thread; at once if it waits for bytes.

        Args:
            call: the call, or None for whichever is under way. A call that is not under way any
                more is left alone, and so is the one after it.
            reason: why.
        """
        with self._lock:
            current = self._current
            if current is None or (call is not None and current is not call):
                return Dropped.OVER
            current.abandoned = True
            # The thread publishes a connection before it looks at `abandoned`, and here it is
            # the other way round: whichever comes second sees the other.
            connection = self._connection
            if connection is None:
                return Dropped.UNSENT
            unsent = connection.state is ConnectionState.NEW
            connection.abandon(reason)
            return Dropped.UNSENT if unsent else Dropped.UNKNOWN

    def farewell(self) -> asyncio.Event:
        """Have the thread close its connection and end; on the loop.

        Returns:
            An event that is set when the thread is about to end.
        """
        gone = asyncio.Event()
        self.retired = True
        if self._started:
            self._inbox.put(doorbell(gone.set))
        else:
            gone.set()
        return gone

    def dismiss(self) -> None:
        """Have the thread end as soon as it is free, without anybody waiting for it."""
        self.retired = True
        if self._started:
            self._inbox.put(lambda: None)

    def join(self, timeout: float) -> bool:
        """Wait for the thread's end; whether it ended."""
        if self._started:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        take = self._inbox.get
        release = self._claim.release
        while True:
            call = take()
            if not isinstance(call, Call):
                self._close()
                call()
                return
            try:
                call.value = self._carry_out(call)
            except BaseException as exc:
                # belongs to whoever waits for the call
                call.error = exc
            with self._lock:
                self._current = None
            # free before the waiter is told, so that it can have this worker again at once
            release()
            call.notify()
            del call

    def _carry_out(self, call: Call) -> Any:
        connection = self._connection
        used = connection is not None and connection.state is ConnectionState.IDLE
        if not used:
            connection = self._open(call)
        assert connection is not None
        if call.function is None:
            return None
        try:
            return self._exchange(connection, call)
        except ConnectionLost as first:
            # A connection that was used before may have died since. The call may have another
            # one if nothing of it was sent, or if a second time does no more than the first.
            in_time = call.deadline is None or time.monotonic() < call.deadline
            again = may_send_again(call.function, connection.progress)
            if not (used and again and in_time and not call.abandoned):
                raise
            try:
                return self._exchange(self._open(call), call)
            except (ConnectError, ConnectionLost) as second:
                if connection.progress is Progress.NOTHING_SENT:
                    raise
                # only the first says that something was sent
                raise first from second

    def _exchange(self, connection: Connection, call: Call) -> Any:
        assert call.function is not None
        if call.abandoned:
            raise ConnectionLost(f"{call.name} was given up before it was sent")
        try:
            return connection.exchange(call.function, call.arguments, call.deadline)
        finally:
            if connection.state is not ConnectionState.IDLE:
                self._close()

    def _open(self, call: Call) -> Connection:
        self._close()
        connection = self._connection = self._source.make()
        if call.abandoned:
            raise ConnectionLost(f"{call.name} was given up before it was sent")
        if call.deadline is not None and call.deadline <= time.monotonic():
            raise NotSent(f"{call.name} was not sent: there was no time left for it")
        begin = time.monotonic()
        connection.open(call.deadline)
        self._is_open = True
        self._source.opened(connection, time.monotonic() - begin)
        return connection

    def _close(self) -> None:
        connection, self._connection = self._connection, None
        if connection is None:
            return
        connection.close()
        if self._is_open:
            self._is_open = False
            self._source.ended(connection)


def may_send_again(function: Function, progress: Progress) -> bool:
    """Whether a call that came this far on a broken connection may be sent on another one."""
    if progress is Progress.NOTHING_SENT:
        return True
    return progress is Progress.SENT and kind(function.name).repeatable


def doorbell(callback: Callable[[], None]) -> Callable[[], None]:
    """A function that has the callback called on the running event loop, from any thread."""
    loop = asyncio.get_running_loop()

    def ring() -> None:
        try:
            loop.call_soon_threadsafe(callback)
        except RuntimeError:
            # the loop is closed, and with it whatever could wait for this
            return

    return ring
