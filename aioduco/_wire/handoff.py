"""How a call gets from a task to a thread and back: the only module that knows asyncio.

A call is handed over by a `SimpleQueue` and comes back by `call_soon_threadsafe`: measured, a
third cheaper than `anyio.to_thread`, and the thread can own its connection, as the manual asks
(1.5.1).
"""

from __future__ import annotations

import asyncio
import math
import time
from abc import ABC, abstractmethod
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final

from aioduco._wire.semantics import Kind, kind

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from aioduco._wire.idl import Function
    from aioduco._wire.worker import Worker

#: seconds after its deadline at which a call is given up although its thread has not come back
GRACE: Final = 0.25


class Call(ABC):
    """One call on its way: what is sent, by when, and what came of it.

    Its parts have one writer each: the thread writes `value`, `error` and `handed_over`, then
    calls `notify`; whoever waits writes `abandoned`. Only of an urgent one, whoever hands it over
    writes `handed_over`, before the thread has it.

    Args:
        function: the function of the wire; None only opens the connection.
        arguments: its encoded arguments.
        deadline: time of `time.monotonic()`, or None.
    """

    __slots__ = (
        "abandoned",
        "arguments",
        "deadline",
        "error",
        "function",
        "handed_over",
        "value",
        "worker",
    )

    def __init__(self, function: Function | None, arguments: bytes, deadline: float | None) -> None:
        self.function = function
        self.arguments = arguments
        self.deadline = deadline
        self.value: Any = None
        self.error: BaseException | None = None
        self.abandoned = False
        #: whether a connection was asked to send it
        self.handed_over = False
        self.worker: Worker | None = None

    @property
    def urgent(self) -> bool:
        """Whether it is to be on its way before its thread gets to run."""
        return self.function is not None and kind(self.function.name) is Kind.STOP

    @property
    def name(self) -> str:
        """What is called, for messages."""
        return self.function.name if self.function is not None else "open"

    @abstractmethod
    def notify(self) -> None:
        """Wake whoever waits; on the worker's thread."""


class Home:
    """The event loop on which a lane is used.

    Kept, since asking asyncio for the running loop costs a system call in Python 3.11. A lane
    may go on to another loop when its own has ended.
    """

    __slots__ = ("_loop",)

    def __init__(self) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None

    def loop(self) -> asyncio.AbstractEventLoop:
        """The loop that runs; only on its own thread."""
        loop = self._loop
        if loop is None or not loop.is_running():
            loop = self._loop = asyncio.get_running_loop()
        return loop


class AwaitedCall(Call):
    """A call that a task of the event loop awaits.

    Args:
        home: where to find the loop.
        finished: called on the loop when the thread is done with the call.
    """

    __slots__ = ("_finished", "_future", "loop", "overdue")

    def __init__(
        self,
        home: Home,
        function: Function | None,
        arguments: bytes,
        deadline: float | None,
        finished: Callable[[AwaitedCall], None],
    ) -> None:
        super().__init__(function, arguments, deadline)
        self.loop = home.loop()
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
        if error is not None:
            # not kept here too: its traceback knows this call, which would be a cycle
            self.fail(error)
        elif not self._future.done():
            self._future.set_result(self.value)

    def fail(self, error: BaseException) -> None:
        """Have the waiting task raise this; on the loop."""
        # a task of a loop that was closed meanwhile waits no more
        if not self._future.done() and not self.loop.is_closed():
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

    def wait(self, patience: float | None = None) -> bool:
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


class Farewell:
    """Tells a task of the running event loop that a thread is about to end."""

    def __init__(self) -> None:
        self._gone = asyncio.Event()
        #: called by the thread
        self.ring = doorbell(self._gone.set)

    @property
    def said(self) -> bool:
        """Whether the thread has told."""
        return self._gone.is_set()

    async def wait(self) -> None:
        """Wait until the thread tells."""
        await self._gone.wait()
