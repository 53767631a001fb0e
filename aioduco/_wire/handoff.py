"""How a call gets from a task to a thread and back. Of `_wire`, only this module imports asyncio.

A call is sent by its task, and handed by a `SimpleQueue` to the thread that owns the connection, as
the manual asks (1.5.1). That thread is woken while the controller works, reads the answer, and
brings it back by `call_soon_threadsafe`.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
import select
import signal
import time
from abc import ABC, abstractmethod
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final

from aioduco._wire.forks import fork_hooks
from aioduco.errors import WrongLoop, WrongProcess

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from aioduco._wire.idl import Function
    from aioduco._wire.worker import Worker

#: seconds after its deadline at which a call is given up although its thread has not come back
GRACE: Final = 0.25


class Call(ABC):
    """One call on its way: what is sent, by when, and what came of it.

    Each attribute has one writer: the thread writes `value`, `error` and `handed_over`, then calls
    `notify`; the waiting side writes `abandoned`. The side that hands it over writes `handed_over`
    before the thread has it.

    Args:
        function: the function of the wire; None only opens the connection.
        arguments: its encoded arguments.
        deadline: time of `time.monotonic()`, or None.

    Attributes:
        further: functions that only read, with their encoded arguments, that are sent behind it;
            its value is then a list of `codec.ReadResult`, its own first.
    """

    __slots__ = (
        "abandoned",
        "arguments",
        "deadline",
        "error",
        "function",
        "further",
        "handed_over",
        "value",
        "worker",
    )

    def __init__(self, function: Function | None, arguments: bytes, deadline: float | None) -> None:
        self.function = function
        self.arguments = arguments
        self.deadline = deadline
        self.further: Sequence[tuple[Function, bytes]] = ()
        self.value: Any = None
        self.error: BaseException | None = None
        self.abandoned = False
        #: whether a connection was asked to send it
        self.handed_over = False
        self.worker: Worker | None = None

    @property
    def name(self) -> str:
        """What is called, for messages."""
        return self.function.name if self.function is not None else "open"

    @property
    def undelivered(self) -> int:
        """How many of its bytes the system still holds; from any thread."""
        connection = None if self.worker is None else self.worker.connection
        return 0 if connection is None else connection.undelivered

    @abstractmethod
    def notify(self) -> None:
        """Wake the waiting side; on the worker's thread."""


class OwnerLoop:
    """The event loop that owns a lane, or a robot with all its lanes: the first one that uses it.

    On any other loop, under any other library and in a forked child, nothing is sent. That costs
    a fifth of a microsecond: in Python 3.11 asyncio asks the system for the process id before it
    returns the running loop. Comparing threads would be cheaper, but confuses a loop with another
    one that runs inside of it, as in some notebooks.

    Args:
        owner: what belongs to the loop, for messages.
        moves: whether it goes on to another loop by itself when its own has been closed.
    """

    __slots__ = ("__weakref__", "_loop", "_moves", "_owner", "forked_off")

    def __init__(self, owner: str = "the lane", *, moves: bool = True) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._owner = owner
        self._moves = moves
        #: whether this is a child that was forked from the owner's process
        self.forked_off: bool = False
        fork_hooks.add(self)

    def require(self, what: str) -> asyncio.AbstractEventLoop:
        """Require that this loop runs here, in the process that opened it.

        Args:
            what: what is to be done on it, for messages.

        Returns:
            The loop.

        Raises:
            WrongLoop: another loop runs here, or none.
            WrongProcess: this is a forked child.
        """
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:
            raise self._refusal(what) from None
        if loop is not self._loop:
            self._adopt(loop, what)
        return loop

    def require_process(self, what: str) -> None:
        """Require that this is the owner's process; from any thread.

        Args:
            what: what is to be done, for messages.

        Raises:
            WrongProcess: this is a forked child.
        """
        if self.forked_off:
            raise self._refusal(what)

    @property
    def closed(self) -> bool:
        """Whether the loop has been closed: nothing can run on it any more."""
        return self._loop is not None and self._loop.is_closed()

    def move(self, what: str) -> None:
        """Go on to the loop that runs, since its own has been closed.

        Args:
            what: what is to be done on it, for messages.

        Raises:
            WrongLoop: the loop has not been closed, or asyncio runs none.
        """
        if self.closed:
            self._loop = None
        self.require(what)

    def forked(self) -> None:
        """This is a forked child: refuse, and take its copy of the loop apart from the parent's."""
        self.forked_off = True
        if self._loop is not None and not self._loop.is_closed():
            _detach_copy(self._loop)

    def _adopt(self, loop: asyncio.AbstractEventLoop, what: str) -> None:
        # no task runs where trio is a guest of this loop: nothing could be awaited
        if self.forked_off or asyncio.current_task() is None:
            raise self._refusal(what)
        if self._loop is not None and not (self._moves and self._loop.is_closed()):
            raise self._refusal(what)
        self._loop = loop

    def _refusal(self, what: str) -> WrongLoop | WrongProcess:
        if self.forked_off:
            return WrongProcess(
                f"{what}: refused, since {self._owner} belongs to the process that forked this "
                "one; nothing was sent. Open another one in this process"
            )
        if self._loop is None:
            return WrongLoop(
                f"{what}: refused, since aioduco needs asyncio, and no task of an asyncio event "
                "loop runs here (trio's are none); nothing was sent. Use asyncio.run(...) or "
                'anyio.run(..., backend="asyncio"); a program without an event loop uses '
                "aioduco.sync"
            )
        return WrongLoop(
            f"{what}: refused, since {self._owner} belongs to the event loop on which it was "
            f"opened, {self._loop!r}, and this is not that one; nothing was sent. Open one for "
            "each event loop. From other threads use stop_now() or "
            "asyncio.run_coroutine_threadsafe(..., loop). In notebooks, and wherever several "
            "threads use one robot, use aioduco.sync: its robot has a loop of its own"
        )


def _detach_copy(loop: asyncio.AbstractEventLoop) -> None:
    """In a forked child: detach its copy of the loop from the parent's.

    Parent and child share one epoll. A child that tears its copy down, as `sys.exit` in it does,
    takes the pipe that wakes the loop out of that epoll. From then on no thread can wake the
    parent's loop any more. So the child gets an epoll of its own, and a pipe of its own, and its
    signals no longer wake the parent's loop.
    """
    with contextlib.suppress(ValueError):
        signal.set_wakeup_fd(-1)
    ours: Any = loop
    if hasattr(ours, "_get_backend_id"):  # uvloop
        number = ours._get_backend_id()
    elif (selector := getattr(ours, "_selector", None)) is not None and hasattr(selector, "fileno"):
        number = selector.fileno()
    else:
        return  # nothing of it is in the system
    if hasattr(select, "epoll"):
        with select.epoll() as own:
            os.dup2(own.fileno(), number, inheritable=False)
    # A kqueue is not inherited: there only the copy must not touch its number again.
    if hasattr(select, "epoll") and hasattr(ours, "_make_self_pipe"):
        ours._close_self_pipe()
        ours._make_self_pipe()
        return
    # libuv shares memory with the system too, by which its copy would disturb the parent's even so:
    # this copy never runs again
    for task in asyncio.all_tasks(loop):
        asyncio.tasks._unregister_task(task)
    ours.run_forever = ours.close = _nothing
    ours.run_until_complete = _discard


def _nothing() -> None:
    """What a copy of a loop does that never runs again."""


def _discard(work: Any) -> None:
    """As `_nothing`, for a loop that is given something to run."""
    if asyncio.iscoroutine(work):
        work.close()


class _Answer(asyncio.Future[Any]):
    """What a task waits for, and by which it goes on in the same turn of the loop.

    An asyncio future that is set has its task go on in the next turn, after a look at all sockets
    and timers: a fifth of a call. A callback of the loop that sets this one has it go on at once.
    """

    def resume(self, set_it: Callable[[], None]) -> None:
        """Set it, and have the task go on; in a callback of the loop, where no other task runs.

        If an interrupt ends this half-way, the loop has the task go on: when this is set once more,
        or cancelled, if it was not set yet.
        """
        if self.done():
            # the loop has the task go on: it was cancelled, or did not wait yet
            return
        # Asked of the future, where a task that began to wait is known at once: Python code that
        # noted it could be interrupted before it did, and the task would never go on.
        waiting = self._callbacks
        if not waiting or len(waiting) > 1:
            set_it()
            return
        ((fn, context),) = waiting
        task = getattr(fn, "__self__", None)
        try:
            self.remove_done_callback(fn)
            set_it()
            context.run(fn, self)
        except BaseException:
            # The task's own, once it has gone on; it waits for something else then, or has ended.
            if getattr(task, "_fut_waiter", None) is self:
                self.remove_done_callback(fn)
                self.add_done_callback(fn, context=context)
            raise


class AwaitedCall(Call):
    """A call that a task of the event loop awaits.

    Args:
        owner_loop: where to find the loop.
        finished: called on the loop when the thread is done with the call.
    """

    __slots__ = ("_answer", "_finished", "loop", "overdue")

    def __init__(
        self,
        owner_loop: OwnerLoop,
        function: Function | None,
        arguments: bytes,
        deadline: float | None,
        finished: Callable[[AwaitedCall], None],
    ) -> None:
        super().__init__(function, arguments, deadline)
        self.loop = owner_loop.require(self.name)
        self._answer = _Answer(loop=self.loop)
        self._finished = finished
        #: whether its deadline has been seen to pass once
        self.overdue = False

    @property
    def refused(self) -> bool:
        """Whether no task waits for it any more; such a call is not handed to a thread."""
        return self._answer.done()

    @property
    def due(self) -> float:
        """When to look whether the call is over: at its deadline, then `GRACE` later."""
        if self.deadline is None:
            return math.inf
        return self.deadline + GRACE if self.overdue else self.deadline

    def __await__(self) -> Generator[Any, None, Any]:
        """Wait for the value; raises what the call raised."""
        return self._answer.__await__()

    def notify(self) -> None:
        """Have `finished` called on the loop."""
        try:
            self.loop.call_soon_threadsafe(self._finished, self)
        except RuntimeError:
            # the loop is closed: no task waits any more, and the thread serves the next call
            return

    def settle(self) -> None:
        """Give the waiting task what the thread left, and resume it; in a callback of the loop."""
        if not self.loop.is_closed():
            self._answer.resume(self._set)
        # not kept: its traceback refers to this call: a reference cycle
        self.error = None

    def _set(self) -> None:
        if self.error is not None:
            self._answer.set_exception(self.error)
        else:
            self._answer.set_result(self.value)

    def fail(self, error: BaseException) -> None:
        """Have the waiting task raise this, on the loop's next turn; on the loop."""
        # a task of a loop that was closed meanwhile waits no more
        if not self._answer.done() and not self.loop.is_closed():
            self._answer.set_exception(error)

    def over(self) -> None:
        """The task waits no more."""
        self.error = None


def _due(call: AwaitedCall) -> float:
    return call.due


class Deadlines:
    """Sees that no task waits past its deadline, even if a thread hangs.

    One timer for all calls of a lane: set for the earliest deadline, and set anew when it
    expires. A timer per call would cost as much as a tenth of a call.

    Args:
        expired: called on the loop with a call whose deadline has passed and False, and once
            more with True if the call is still there `GRACE` later.
    """

    def __init__(self, expired: Callable[[AwaitedCall, bool], None]) -> None:
        self._expired = expired
        #: the calls that tasks await
        self.calls: set[AwaitedCall] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._expires_at = math.inf

    def add(self, call: AwaitedCall) -> None:
        """Watch a call until it is discarded."""
        self.calls.add(call)
        if call.deadline is None:
            return
        if call.deadline < self._expires_at or call.loop is not self._loop:
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
        self._expires_at = math.inf

    def _set(self, loop: asyncio.AbstractEventLoop, at: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._loop = loop
        self._expires_at = at
        self._timer = loop.call_later(at - time.monotonic(), self._check)

    def _check(self) -> None:
        now = time.monotonic()
        self._timer = None
        self._expires_at = math.inf
        for call in sorted((call for call in self.calls if call.due <= now), key=_due):
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


def loop_callback(callback: Callable[[], None]) -> Callable[[], None]:
    """A function that has the callback called on the running event loop, from any thread."""
    loop = asyncio.get_running_loop()

    def call() -> None:
        try:
            loop.call_soon_threadsafe(callback)
        except RuntimeError:
            # the loop is closed: nothing waits for this any more
            return

    return call


class ThreadEnd:
    """Tells a task of the running event loop that a thread is about to end."""

    def __init__(self) -> None:
        self._reported = asyncio.Event()
        #: called by the thread
        self.report = loop_callback(self._reported.set)

    @property
    def reported(self) -> bool:
        """Whether the thread has reported its end."""
        return self._reported.is_set()

    async def wait(self) -> None:
        """Wait until the thread reports its end."""
        await self._reported.wait()
