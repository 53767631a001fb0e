"""A thread that owns a connection and executes calls, one after another."""

from __future__ import annotations

import enum
import math
import threading
import time
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Final

from aioduco._wire.forks import fork_hooks
from aioduco._wire.handoff import Call
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.lifecycle import ConnectionState, Progress
from aioduco.errors import (
    CallTimeout,
    ConnectError,
    ConnectionLost,
    DucoError,
    NotSent,
    OutcomeUnknown,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.connection import Connection
    from aioduco._wire.connection_factory import ConnectionFactory
    from aioduco._wire.idl import Function


#: seconds within which a thread must notice that its call was abandoned
_LEAVING_TIME: Final = 1.0


class AbandonOutcome(enum.Enum):
    """Outcome of a call that was abandoned."""

    OVER = "it was over before"
    UNSENT = "nothing of it was sent, or will be"
    UNKNOWN = "something of it may have been sent"


class Worker:
    """A thread with its own connection.

    Guarantees: one call at a time, submitted by the holder of the claim. The connection is opened,
    used and closed on this thread. An abandoned call never sends anything afterwards. The thread is
    a daemon, since a program that does not close a lane, or whose name server hangs, must still be
    able to end. A callback of `dismiss` reports the end of the thread.

    Args:
        name: name of the thread.
        source: factory of its connections.
    """

    def __init__(self, name: str, source: ConnectionFactory) -> None:
        self.name = name
        self._source = source
        self._inbox: SimpleQueue[Call | Callable[[], None]] = SimpleQueue()
        # The holder of the claim, under the key None. A claim is only tried, never waited for, so
        # that a signal handler can claim a worker in the middle of the loop's own code. The holder
        # is stored, since an interrupt can come between any two steps: the claim is then released.
        self._claims: dict[None, object] = {}
        # Held only briefly, so that a call cannot end, and the next one start, while it is being
        # abandoned. Reentrant for the signal handler.
        self._lock = threading.RLock()
        self._current: Call | None = None
        self._connection: Connection | None = None
        self._is_open = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._ended = False
        #: whether the lane no longer uses this worker
        self.retired = False
        self._retired_at = math.inf
        fork_hooks.add(self)

    @property
    def connection(self) -> Connection | None:
        """The present connection, if any."""
        return self._connection

    @property
    def alive(self) -> bool:
        """Whether the thread runs."""
        return self._thread.is_alive()

    @property
    def _started(self) -> bool:
        return self._thread.ident is not None

    @property
    def stuck(self) -> bool:
        """Whether the thread still runs long after it was dismissed."""
        return self.alive and time.monotonic() > self._retired_at + _LEAVING_TIME

    @property
    def busy(self) -> bool:
        """Whether a call is under way."""
        return self._current is not None

    def __repr__(self) -> str:
        state = "retired" if self.retired else "busy" if self.busy else "idle"
        return f"<Worker {self.name} {state}, {self._connection!r}>"

    def forked(self) -> None:
        """In a forked child: replace the lock, which the parent's thread may have held."""
        self._lock = threading.RLock()

    def start(self) -> None:
        """Start the thread, if it was not started before.

        Raises:
            RuntimeError: the system has no more threads.
        """
        if not self._started:
            self._thread.start()

    def claim(self, call: object) -> bool:
        """Claim the worker for a call, if it is free or already claimed for it; never waits."""
        return not self.retired and self._claims.setdefault(None, call) is call

    def submit(self, call: Call) -> None:
        """Pass a call to the thread. The caller must hold the claim; the thread releases it."""
        if not self._started:
            self._thread.start()
        call.worker = self
        self._current = call
        connection = self._connection
        if connection is not None and call.function is not None and _permitted(call):
            # The thread may have to wait for the interpreter's lock; so send the bytes here.
            call.handed_over = True  # set first: a concurrent `abandon` must see it
            call.handed_over = connection.send_ahead(
                call.function, call.arguments, call.deadline, call.further
            )
        self._inbox.put(call)

    def recover(self, call: Call) -> None:
        """Complete or undo a claim and a `submit` that an interrupt may have left half done.

        A submit that had not started is undone, and one that had started is completed. Otherwise it
        has no effect: a call that is queued twice has no claim the second time, so the thread skips
        it.
        """
        if self._claims.get(None) is not call:
            return  # without the lock: only the caller claims for this call
        with self._lock:
            if self._claims.get(None) is not call:
                return
            if self._current is call:
                self._inbox.put(call)
            else:
                self._claims.clear()

    def abandon(self, call: Call | None, reason: str) -> AbandonOutcome:
        """Make the thread drop a call, from any thread; at once if it waits for bytes.

        Args:
            call: the call, or None for the present one. If the call is no longer under way, nothing
                happens, also not to the next call.
            reason: reason, for messages.
        """
        with self._lock:
            current = self._current
            if current is None or (call is not None and current is not call):
                return AbandonOutcome.OVER
            current.abandoned = True
            # The thread sets `_connection` before it reads `abandoned`, and sets `handed_over`
            # before it uses the connection. Here the order is reversed, so the later side always
            # sees the earlier one's write: a call without `handed_over` is never sent.
            if self._connection is not None:
                self._connection.abandon(reason)
            return AbandonOutcome.UNKNOWN if current.handed_over else AbandonOutcome.UNSENT

    def dismiss(self, on_end: Callable[[], None] = lambda: None) -> None:
        """Make the thread close its connection and end, as soon as it is free.

        Args:
            on_end: callback, called on the thread when it is about to end; called at once if the
                thread was never started, or has already ended.
        """
        self.retired = True
        self._retired_at = time.monotonic()
        with self._lock:
            if self._started and not self._ended:
                self._inbox.put(on_end)
                return
        on_end()

    def join(self, timeout: float) -> bool:
        """Wait for the thread's end, at most `timeout` [s]; return whether it ended."""
        if self._started:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        take = self._inbox.get
        while True:
            item = take()
            if not isinstance(item, Call):
                self._shut_down(item)
                return
            if self._claims.get(None) is not item:
                continue
            try:
                item.value = self._carry_out(item)
            except BaseException as exc:
                # raised where the call is awaited
                item.error = exc
            self._release(item)
            del item

    def _release(self, call: Call) -> None:
        # free the worker before the waiter wakes up, so that it can claim this worker again at once
        with self._lock:
            self._current = None
            self._claims.clear()
        call.notify()

    def _shut_down(self, on_end: Callable[[], None]) -> None:
        self._close()
        callbacks = [on_end]
        # Keep the claim forever, so that no more calls can be submitted. If another thread holds
        # the claim, it will submit its call, which then fails here.
        while self._claims.setdefault(None, self) is not self:
            self._fail_pending(self._inbox.get(), callbacks)
        with self._lock:
            while not self._inbox.empty():
                self._fail_pending(self._inbox.get(), callbacks)
            self._ended = True
        for callback in callbacks:
            callback()

    def _fail_pending(
        self, item: Call | Callable[[], None], callbacks: list[Callable[[], None]]
    ) -> None:
        if isinstance(item, Call):
            if self._claims.get(None) is not item:
                return
            item.error = (
                OutcomeUnknown(item.name, "its lane was closed")
                if item.handed_over
                else ConnectionLost(f"{item.name} was not sent, since its lane was closed")
            )
            self._release(item)
        else:
            callbacks.append(item)

    def _carry_out(self, call: Call) -> Any:
        connection = self._connection
        # a connection that was abandoned after the call was sent on it determines the right error
        used = connection is not None and (connection.usable or call.handed_over)
        if not used:
            connection = self._open(call)
        assert connection is not None
        if call.function is None:
            return None
        try:
            return self._exchange(connection, call)
        except ConnectionLost as first:
            # A connection that was used before may have broken since. The call may use another
            # connection if nothing of it was sent, or if a second call has no additional effect.
            in_time = call.deadline is None or time.monotonic() < call.deadline
            again = bool(call.further) or may_send_again(call.function, connection.progress)
            if not (used and again and in_time and not call.abandoned):
                raise
            try:
                return self._exchange(self._open(call), call)
            except (ConnectError, ConnectionLost) as second:
                if isinstance(first, OutcomeUnknown) and not isinstance(second, OutcomeUnknown):
                    # a stop that was sent the first time, but not the second time
                    raise first from second
                raise

    def _exchange(self, connection: Connection, call: Call) -> Any:
        assert call.function is not None
        # if the call was abandoned earlier, its connection is poisoned and sends nothing
        call.handed_over = True
        try:
            return connection.exchange(
                call.function,
                call.arguments,
                call.deadline,
                further=call.further,
                permit=call.permit,
            )
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


def _permitted(call: Call) -> bool:
    """Whether a call may be sent now. If not, its thread finds the same, and the call fails."""
    try:
        if call.permit is not None:
            call.permit()
    except DucoError:
        return False
    return True


def may_send_again(function: Function, progress: Progress) -> bool:
    """Whether a call with this progress on a broken connection may be sent on another one."""
    if progress is Progress.NOTHING_SENT:
        return True
    if progress is Progress.SENT:
        return call_kind(function.name).repeatable
    # an incomplete answer shows that the call was received; only a stop is repeated to be sure
    return call_kind(function.name) is CallKind.STOP


def hung(name: str, dropped: AbandonOutcome) -> ConnectionLost:
    """Return the error for the caller of a call whose thread hangs.

    Args:
        name: the function that was called.
        dropped: outcome of the abandoned call.
    """
    if dropped is AbandonOutcome.UNSENT:
        return NotSent(f"{name} was not sent: no connection could be made in time")
    if call_kind(name) is CallKind.READ:
        return CallTimeout(f"{name}: its thread did not come back in time")
    return OutcomeUnknown(name, "its thread did not come back in time")
