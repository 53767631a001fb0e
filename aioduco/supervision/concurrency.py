"""How the supervision runs code: to its end, on a thread, in the background, on a schedule.

`run_to_completion`: anyio's shield protects against cancel scopes, but not against
`asyncio.Task.cancel`, which `asyncio.timeout`, task groups and Ctrl-C use; a second Ctrl-C cancels
once more, while the first is being handled. A stop of the arm must survive all of them, so it is
repeated until it is done. A function that runs this way must therefore be safe to repeat, and must
end by itself: it has a deadline.

`DaemonThread`, and not `anyio.to_thread`: a program whose event loop was broken, by the third
Ctrl-C for instance, waits at exit for anyio's threads, and never exits. After a cancellation, a
caller can wait again for a call that has begun, so that no result is lost.

`BackgroundTasks`, and no task group: a task group must be left in the task that entered it. A robot
may be opened in one task and closed in another: by the set-up and the tear-down of a test fixture,
or in two cells of a notebook.

`every`: an absolute schedule. A late cycle does not delay the later ones.

`Alarm`: a wait that ends at a given time, or earlier. A cancel scope with a deadline costs half as
much again, and the tasks of a robot without a feed are polled about thirty times a second.

`Silence`: what reports nothing for a while may be dead; a program that stood still did not hear it.

`on_grid`: waits of many robots on one loop are due at the same moments, where they need not be
exact. Most of the cost of a wait is the iteration of the loop, which then serves several waits.
"""

from __future__ import annotations

import asyncio
import threading
import time
import traceback
from collections.abc import Coroutine
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Self, TypeVar

import anyio

from aioduco._process.reporting import BackgroundLogger
from aioduco._wire.forks import fork_hooks
from aioduco._wire.owner_loop import loop_callback
from aioduco.errors import DucoError, WrongProcess

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Generator
    from types import CodeType


#: time between two moments of `on_grid` [s]
GRID = 0.01
#: seconds after which a coroutine that is to end, and has not, is cancelled again
_CANCEL_AGAIN = 5.0
#: seconds by which the event loop may be late between two looks; more counts as a standstill of it
_LATE = 0.05

T = TypeVar("T")

_log = BackgroundLogger(__name__)


class Ticker:
    """Cycles of a loop on an absolute schedule; `every` makes one.

    Args:
        period: seconds between two cycles.
        first: when the first cycle is due [s of `time.monotonic`]; it starts without a wait.

    Attributes:
        period: seconds until the next cycle; may be changed at any time.
        due: when this cycle was due [s of `time.monotonic`].
    """

    __slots__ = ("_begun", "due", "period")

    def __init__(self, period: float, first: float) -> None:
        self.period: float = period
        self.due: float = first
        self._begun = False

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> float:
        if self._begun:
            await self.wait()
        self._begun = True
        return self.due

    async def wait(self) -> None:
        """Wait for the next cycle, or not at all if it is late. Missed cycles are skipped."""
        now = time.monotonic()
        self.due = max(self.due + self.period, now)
        await anyio.sleep(self.due - now)

    def postpone(self, seconds: float) -> None:
        """Delay the next cycle until a period after `seconds` from now, or later."""
        self.due = max(self.due, time.monotonic() + seconds)

    def restart(self) -> None:
        """Start the next cycle at once, and a new schedule with it."""
        self.due = time.monotonic()
        self._begun = False


def every(period: float, first: float | None = None) -> Ticker:
    """Return the cycles of a loop, a period apart: `async for due in every(0.01):`.

    The first cycle starts at once. A late cycle does not delay the later ones, and missed cycles
    are skipped.

    Args:
        period: seconds between two cycles.
        first: when the first cycle was due [s of `time.monotonic`]; None for now.

    Returns:
        An iterator over the times when the cycles were due [s of `time.monotonic`].
    """
    return Ticker(period, time.monotonic() if first is None else first)


class Silence:
    """How long nothing new came, without the time in which the event loop stood still.

    Args:
        period: seconds between two looks.

    Attributes:
        seconds: how long nothing new had come at the last look [s].
    """

    __slots__ = ("_heard_at", "_longest", "_looked_at", "seconds")

    def __init__(self, period: float) -> None:
        self._longest = period + _LATE
        self._heard_at: float | None = None
        self._looked_at = 0.0
        self.seconds: float = 0.0

    def look(self, now: float, heard_at: float) -> float:
        """Take in when the newest thing came; return how long nothing has come since [s]."""
        if heard_at == self._heard_at:
            self.seconds += min(now - self._looked_at, self._longest)
        else:
            self._heard_at, self.seconds = heard_at, 0.0
        self._looked_at = now
        return self.seconds


def on_grid(at: float) -> float:
    """Round a time down to the grid [s of `time.monotonic`]."""
    return at - at % GRID


class Alarm:
    """Wakes the task that waits for it at a given time, or earlier when it is rung."""

    __slots__ = ("_rung", "_timer", "_waiter")

    def __init__(self) -> None:
        self._rung = False
        self._waiter: asyncio.Future[None] | None = None
        self._timer: asyncio.TimerHandle | None = None

    @property
    def awaited(self) -> bool:
        """Whether a task waits: there is room for one."""
        return self._waiter is not None and not self._waiter.done()

    def ring(self) -> None:
        """Wake the task that waits, or the next one that will wait; on the event loop."""
        self._rung = True
        if self._waiter is not None:
            _wake(self._waiter)

    async def wait(self, due: float | None = None) -> None:
        """Wait until it is rung, or until the given time.

        Args:
            due: the time [s of `time.monotonic`]; None: until it is rung.
        """
        if self._rung:
            self._rung = False
            return
        waiter = self._waiter = asyncio.get_running_loop().create_future()
        if due is not None:
            self._set(waiter, due)
        try:
            await waiter
        finally:
            if self._waiter is waiter:
                self._cancel()
                self._waiter, self._rung = None, False

    def postpone(self, due: float) -> None:
        """Let the task that waits until a time wait until another one [s of `time.monotonic`]."""
        if self._timer is not None and self._waiter is not None:
            self._cancel()
            self._set(self._waiter, due)

    def _set(self, waiter: asyncio.Future[None], due: float) -> None:
        seconds = max(due - time.monotonic(), 0.0)
        self._timer = waiter.get_loop().call_later(seconds, _wake, waiter)

    def _cancel(self) -> None:
        timer, self._timer = self._timer, None
        if timer is not None:
            timer.cancel()


def _wake(waiter: asyncio.Future[None]) -> None:
    if not waiter.done():
        waiter.set_result(None)


async def run_to_completion(step: Callable[[], Awaitable[T]]) -> tuple[T, BaseException | None]:
    """Await `step()`, again after each cancellation, until it returns or raises.

    What a signal handler raises during `step()` is treated like a cancellation: a keyboard
    interrupt, an exit, or any other error that is not this package's. A step's own error of that
    kind is raised if it comes again, from the same place.

    Args:
        step: returns the awaitable; called once, and once more for each cancellation.

    Returns:
        The result, and the last cancellation that came meanwhile: the caller must raise it.
    """
    cancelled: BaseException | None = None
    results: list[T] = []
    with anyio.CancelScope(shield=True):
        while not results:
            try:
                results.append(await step())
            except (anyio.get_cancelled_exc_class(), KeyboardInterrupt, SystemExit) as exc:
                cancelled = exc
            except DucoError:
                raise
            except Exception as exc:
                if isinstance(cancelled, type(exc)) and _raised_at(cancelled) == _raised_at(exc):
                    raise
                cancelled = exc
    return results[0], cancelled


def first_error(error: BaseException) -> BaseException:
    """Return the first error of a group, which caused the others; of any other error, itself."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error


def _raised_at(error: BaseException) -> list[tuple[CodeType, int]]:
    """The place where an error was raised, and the calls that led to it."""
    return [(frame.f_code, line) for frame, line in traceback.walk_tb(error.__traceback__)]


class DaemonThread:
    """A daemon thread for blocking calls. It starts at once: later there may be no threads left.

    Args:
        name: the thread's name.

    Raises:
        RuntimeError: the system has no more threads.
    """

    def __init__(self, name: str) -> None:
        self._inbox: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._in_forked_child = False
        #: ends the wait for the present call
        self._give_up: Callable[[], None] = lambda: None
        fork_hooks.add(self)
        threading.Thread(target=_serve, args=(self._inbox,), name=name, daemon=True).start()

    def __del__(self) -> None:
        if (inbox := getattr(self, "_inbox", None)) is not None:
            inbox.put(None)

    async def run(self, work: Callable[[], T]) -> tuple[T, BaseException | None]:
        """Call a blocking function on the thread, to its end even if this is cancelled.

        Args:
            work: the function; it must end by itself.

        Returns:
            Its result, and the last cancellation that came meanwhile: the caller must raise it.

        Raises:
            What the function raised, or the last cancellation if one came meanwhile.
            WrongProcess: this is a forked child, which has no such thread.
        """
        over = anyio.Event()
        ring = loop_callback(over.set)
        results: list[T] = []
        errors: list[BaseException] = []

        def job() -> None:
            try:
                results.append(work())
            except BaseException as exc:
                errors.append(exc)  # raised in the task that waits
            ring()

        def give_up() -> None:
            errors.append(
                WrongProcess(
                    "refused, since the robot belongs to the process that forked this one; nothing "
                    "was sent. Open another one in this process"
                )
            )
            over.set()

        self._give_up = give_up
        if self._in_forked_child:
            give_up()
        self._inbox.put(job)
        _, cancelled = await run_to_completion(over.wait)
        if errors:
            if cancelled is not None:  # it must not be lost
                raise cancelled from errors[0]
            raise errors[0]
        return results[0], cancelled

    def forked(self) -> None:
        """In a forked child: the thread runs in the parent alone, and so does its call."""
        self._in_forked_child = True
        self._give_up()

    def end(self) -> None:
        """End the thread after the calls that are queued; no call may follow."""
        self._inbox.put(None)


def _serve(inbox: SimpleQueue[Callable[[], None] | None]) -> None:
    while (work := inbox.get()) is not None:
        work()


class BackgroundTasks:
    """Runs coroutines beside the program, and keeps those that still run.

    Args:
        crashed: called with the exception of a coroutine, other than its cancellation.
        on_foreign_cancel: called when other code cancelled a coroutine, mostly because its event
            loop ends.
    """

    def __init__(
        self,
        crashed: Callable[[BaseException], None],
        on_foreign_cancel: Callable[[], None] = lambda: None,
    ) -> None:
        self._crashed = crashed
        self._on_foreign_cancel = on_foreign_cancel
        self._closing = False
        self._in_forked_child = False
        self._tasks: set[asyncio.Task[Any]] = set()
        fork_hooks.add(self)

    def __len__(self) -> int:
        return len(self._tasks)

    def start(
        self,
        work: Coroutine[Any, Any, object],
        name: str,
        then: Callable[[], object] | None = None,
    ) -> None:
        """Begin to run `work`.

        Args:
            work: the coroutine.
            name: the name of its task.
            then: called when it has ended, also if it was cancelled before it began. In that case
                not even its `finally` runs, and a task that waits for it would wait for ever.
        """
        task = asyncio.get_running_loop().create_task(_Watched(work), name=name)
        self._tasks.add(task)
        if then is not None:
            task.add_done_callback(lambda _: then())
        task.add_done_callback(self._ended)

    def forked(self) -> None:
        """Note that this is a forked child: coroutines that end here continue in the parent."""
        self._in_forked_child = True

    async def aclose(self) -> None:
        """Cancel the coroutines that still run, and wait until they have ended.

        One that can never end, since an interrupt in the middle of its cancellation took its turn,
        is not waited for.
        """
        self._closing = True
        # tasks of a closed loop can neither run nor be cancelled any more
        self._tasks = {task for task in self._tasks if not task.get_loop().is_closed()}
        stuck: set[asyncio.Task[Any]] = set()
        while self._tasks:
            for task in self._tasks:
                task.cancel()
            # again after a while: an error that comes with a cancellation may hide it
            done, late = await asyncio.wait(self._tasks, timeout=_CANCEL_AGAIN)
            self._tasks -= done  # also those whose `_ended` was not called, due to an interrupt
            # twice, since one that was just woken looks the same
            before, stuck = stuck, {task for task in late if _to_be_woken(task)}
            self._tasks -= before & stuck

    async def ended(self) -> None:
        """Wait until no coroutine runs any more."""
        while self._tasks:
            done, _ = await asyncio.wait(self._tasks)
            self._tasks -= done

    def _ended(self, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if self._in_forked_child:
            if not task.cancelled():
                task.exception()  # it is retrieved, so that asyncio does not log it
            return
        if task.cancelled():
            if not self._closing:
                self._on_foreign_cancel()
        elif (error := task.exception()) is not None:
            self._crashed(error)
            if isinstance(error, Exception):  # a signal's handler may raise anywhere: Ctrl-C
                _log.error("%s failed", task.get_name(), exc_info=error)


class _Watched(Coroutine[Any, Any, object]):
    """A coroutine that knows what it awaits; its task does not tell.

    Args:
        work: the coroutine.
    """

    __slots__ = ("_work", "awaited")

    def __init__(self, work: Coroutine[Any, Any, object]) -> None:
        self._work = work
        #: what it waits for, as its task sees it
        self.awaited: object = None

    def __await__(self) -> Generator[Any, Any, object]:
        return self._work.__await__()

    def send(self, value: object) -> object:
        """Go on until the next await, whose future this returns."""
        self.awaited = awaited = self._work.send(value)
        return awaited

    def throw(self, *error: Any) -> object:
        """Raise an error where it waits, and go on as `send` does."""
        self.awaited = awaited = self._work.throw(*error)
        return awaited

    def close(self) -> None:
        """End it where it waits."""
        self._work.close()


def _to_be_woken(task: asyncio.Task[Any]) -> bool:
    """Whether what the task awaits is over, so that its turn comes next, or was lost."""
    awaited = getattr(task.get_coro(), "awaited", None)
    return isinstance(awaited, asyncio.Future) and awaited.done()
