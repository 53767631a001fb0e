"""Passing a call from a task to a thread and back. Of `_wire`, only this module imports asyncio.

The task sends the call, and passes it by a `SimpleQueue` to the thread that owns the connection, as
the manual requires (1.5.1). That thread wakes up while the controller works, reads the answer, and
returns it by `call_soon_threadsafe`.
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

#: seconds after its deadline at which a call fails although its thread has not finished it
GRACE: Final = 0.25


class Call(ABC):
    """One call under way: its function, arguments and deadline, and its result.

    Each attribute has one writer: the thread writes `value`, `error` and `handed_over`, then calls
    `notify`; the waiting side writes `abandoned`. The side that submits the call writes
    `handed_over` before the thread has the call.

    Args:
        function: the function of the wire; None only opens the connection.
        arguments: its encoded arguments.
        deadline: time of `time.monotonic()`, or None.

    Attributes:
        further: functions that only read, with their encoded arguments. They are sent after it;
            its value is then a list of `codec.ReadResult`, its own result first.
        permit: called before its first byte is sent; it raises if it may not be sent any more.
    """

    __slots__ = (
        "abandoned",
        "arguments",
        "deadline",
        "error",
        "function",
        "further",
        "handed_over",
        "permit",
        "value",
        "worker",
    )

    def __init__(self, function: Function | None, arguments: bytes, deadline: float | None) -> None:
        self.function = function
        self.arguments = arguments
        self.deadline = deadline
        self.further: Sequence[tuple[Function, bytes]] = ()
        self.permit: Callable[[], object] | None = None
        self.value: Any = None
        self.error: BaseException | None = None
        self.abandoned = False
        #: whether the call was passed to a connection to be sent
        self.handed_over = False
        self.worker: Worker | None = None

    @property
    def name(self) -> str:
        """Name of the function, for messages."""
        return self.function.name if self.function is not None else "open"

    @property
    def undelivered(self) -> int:
        """Number of sent bytes that the other side has not acknowledged; from any thread."""
        connection = None if self.worker is None else self.worker.connection
        return 0 if connection is None else connection.undelivered

    @abstractmethod
    def notify(self) -> None:
        """Wake the waiting side; called on the worker's thread."""


class OwnerLoop:
    """The event loop that owns a lane, or a robot with all its lanes: the first one that uses it.

    On any other loop, under any other library and in a forked child, nothing is sent. The check
    takes a fifth of a microsecond: in Python 3.11 asyncio asks the system for the process id before
    it returns the running loop. Comparing threads would be faster, but could not distinguish a
    loop from another one that runs inside it, as in some notebooks.

    Args:
        owner: name of the object that belongs to the loop, for messages.
        moves: whether the object moves to another loop by itself when its own has been closed.
    """

    __slots__ = ("__weakref__", "_loop", "_moves", "_owner", "in_forked_child")

    def __init__(self, owner: str = "the lane", *, moves: bool = True) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._owner = owner
        self._moves = moves
        #: whether this is a child that was forked from the owner's process
        self.in_forked_child: bool = False
        fork_hooks.add(self)

    def require(self, what: str) -> asyncio.AbstractEventLoop:
        """Require that this loop runs here, in the process that opened it.

        Args:
            what: name of the operation, for messages.

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
            what: name of the operation, for messages.

        Raises:
            WrongProcess: this is a forked child.
        """
        if self.in_forked_child:
            raise self._refusal(what)

    @property
    def closed(self) -> bool:
        """Whether the loop has been closed: nothing can run on it any more."""
        return self._loop is not None and self._loop.is_closed()

    def move(self, what: str) -> None:
        """Move to the running loop, since the own loop has been closed.

        Args:
            what: name of the operation, for messages.

        Raises:
            WrongLoop: the loop has not been closed, or asyncio runs none.
        """
        if self.closed:
            self._loop = None
        self.require(what)

    def forked(self) -> None:
        """In a forked child: refuse all calls, and detach its copy of the loop."""
        self.in_forked_child = True
        if self._loop is not None and not self._loop.is_closed():
            _detach_copy(self._loop)

    def _adopt(self, loop: asyncio.AbstractEventLoop, what: str) -> None:
        # where trio runs as a guest of this loop, there is no asyncio task: nothing can be awaited
        if self.in_forked_child or asyncio.current_task() is None:
            raise self._refusal(what)
        if self._loop is not None and not (self._moves and self._loop.is_closed()):
            raise self._refusal(what)
        self._loop = loop

    def _refusal(self, what: str) -> WrongLoop | WrongProcess:
        if self.in_forked_child:
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

    Parent and child share one epoll. If the child closes its copy of the loop, for example by
    `sys.exit`, this removes the pipe that wakes the loop from that epoll. Then no thread can wake
    the parent's loop any more. So the child gets its own epoll and its own pipe, and its signals no
    longer wake the parent's loop.
    """
    with contextlib.suppress(ValueError):
        signal.set_wakeup_fd(-1)
    ours: Any = loop
    if hasattr(ours, "_get_backend_id"):  # uvloop
        number = ours._get_backend_id()
    elif (selector := getattr(ours, "_selector", None)) is not None and hasattr(selector, "fileno"):
        number = selector.fileno()
    else:
        return  # the loop has no object of the system
    if hasattr(select, "epoll"):
        with select.epoll() as own:
            os.dup2(own.fileno(), number, inheritable=False)
    # A kqueue is not inherited: there, the copy must only not use its descriptor again.
    if hasattr(select, "epoll") and hasattr(ours, "_make_self_pipe"):
        ours._close_self_pipe()
        ours._make_self_pipe()
        return
    # libuv also shares memory with the system. The child's copy would still disturb the parent's
    # loop by that, so this copy never runs again.
    for task in asyncio.all_tasks(loop):
        asyncio.tasks._unregister_task(task)
    ours.run_forever = ours.close = _noop
    ours.run_until_complete = _close_coroutine


def _noop() -> None:
    """Do nothing: replaces the methods of a copy of a loop that never runs again."""


def _close_coroutine(work: Any) -> None:
    """Like `_noop`, for a method that gets a coroutine: close it."""
    if asyncio.iscoroutine(work):
        work.close()


class _Answer(asyncio.Future[Any]):
    """A future that resumes its waiting task in the same iteration of the loop.

    If an asyncio future is set, its task resumes in the next iteration, after the loop has checked
    all sockets and timers: that takes a fifth of the time of a call. A callback of the loop that
    sets this future resumes the task at once.
    """

    def resume(self, set_it: Callable[[], None]) -> None:
        """Set the future and resume the task; in a callback of the loop, where no other task runs.

        If an interrupt ends this half-way, the loop resumes the task later. If the future was not
        set yet, this happens when it is set again or cancelled.
        """
        if self.done():
            # the loop resumes the task: it was cancelled, or did not wait yet
            return
        # Read from the future, which registers a waiting task at once. Python code that recorded
        # the task could be interrupted before it did so, and the task would never resume.
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
            # The task may have raised it after it resumed. It then has ended, or waits for
            # something else.
            if getattr(task, "_fut_waiter", None) is self:
                self.remove_done_callback(fn)
                self.add_done_callback(fn, context=context)
            raise


class AwaitedCall(Call):
    """A call that a task of the event loop awaits.

    Args:
        owner_loop: owner of the loop on which the task runs.
        finished: callback on the loop, called when the thread has finished the call.
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
        #: whether its deadline has passed and `Deadlines` has reported it once
        self.overdue = False

    @property
    def settled(self) -> bool:
        """Whether no task waits for it any more; such a call is not passed to a thread."""
        return self._answer.done()

    @property
    def due(self) -> float:
        """Time of the next check whether the call is over: its deadline, then `GRACE` later."""
        if self.deadline is None:
            return math.inf
        return self.deadline + GRACE if self.overdue else self.deadline

    def __await__(self) -> Generator[Any, None, Any]:
        """Wait for the value; raises the error of the call."""
        return self._answer.__await__()

    def notify(self) -> None:
        """Schedule `finished` on the loop."""
        try:
            self.loop.call_soon_threadsafe(self._finished, self)
        except RuntimeError:
            # the loop is closed: no task waits any more, and the thread serves the next call
            return

    def settle(self) -> None:
        """Give the waiting task the result, and resume it; in a callback of the loop."""
        if not self.loop.is_closed():
            self._answer.resume(self._set)
        # not kept: its traceback refers to this call, which makes a reference cycle
        self.error = None

    def _set(self) -> None:
        if self.error is not None:
            self._answer.set_exception(self.error)
        else:
            self._answer.set_result(self.value)

    def fail(self, error: BaseException) -> None:
        """Raise an error in the waiting task, in the loop's next iteration; on the loop."""
        # if the loop was closed meanwhile, its task no longer waits
        if not self._answer.done() and not self.loop.is_closed():
            self._answer.set_exception(error)

    def cancel(self) -> None:
        """Ignore the outcome, unless a task waits for it; on the loop."""
        if not self._answer._callbacks:
            self._answer.cancel()

    def release_error(self) -> None:
        """Release the error: the task no longer waits."""
        self.error = None


def _due(call: AwaitedCall) -> float:
    return call.due


class Deadlines:
    """Ensures that no task waits past its deadline, even if a thread hangs.

    One timer serves all calls of a lane: it is set for the earliest deadline, and set again when it
    expires. A timer for each call would take a tenth of the time of a call.

    Args:
        expired: callback on the loop. It gets a call whose deadline has passed and False. If the
            call is not over `GRACE` later, it gets the call and True.
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
        """Stop watching a call. The timer stays as it is: the next call will use it."""
        self.calls.discard(call)

    def stop(self) -> None:
        """Stop watching all calls."""
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
            second_time, call.overdue = call.overdue, True
            self._expired(call, second_time)
            if second_time:
                self.calls.discard(call)
        next_due = min((call.due for call in self.calls), default=math.inf)
        if self._loop is not None and next_due < math.inf:
            self._set(self._loop, next_due)


class BlockingCall(Call):
    """A call for which a thread or a signal handler waits, without an event loop."""

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

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for the thread.

        Args:
            timeout: maximum time to wait [s]; None: until `GRACE` after the deadline.

        Returns:
            Whether the thread has finished the call.
        """
        if timeout is None and self.deadline is not None:
            timeout = self.deadline + GRACE - time.monotonic()
        try:
            self._done.get(timeout=timeout if timeout is None else max(timeout, 0.0))
        except Empty:
            return False
        return True

    def outcome(self) -> Any:
        """Return the value after the thread has finished; raises the error of the call."""
        error, self.error = self.error, None
        if error is not None:
            raise error
        return self.value

    def notify(self) -> None:
        """Wake the waiting thread."""
        self._done.put(None)
        self._released()


def loop_callback(callback: Callable[[], None]) -> Callable[[], None]:
    """Return a function for any thread that schedules the callback on the running event loop."""
    loop = asyncio.get_running_loop()

    def call() -> None:
        try:
            loop.call_soon_threadsafe(callback)
        except RuntimeError:
            # the loop is closed: no task waits for this any more
            return

    return call


class ThreadEnd:
    """Notifies a task of the running event loop that a thread is about to end."""

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
