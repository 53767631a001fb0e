"""How the supervision runs code: to its end, on a thread, in the background, on a schedule.

`run_to_completion`: anyio's shield keeps cancel scopes away, but not `asyncio.Task.cancel`, which
`asyncio.timeout`, task groups and Ctrl-C use; a second Ctrl-C cancels once more, while the first
is being served. A stop of the arm must survive all of them, so it is repeated until it is done.
What runs this way must therefore be safe to do twice, and must end by itself: it has a deadline.

`DaemonThread`, and not `anyio.to_thread`: a program whose event loop was broken, by the third
Ctrl-C for instance, waits at its end for anyio's threads, and never ends. What was begun can be
waited for again after a cancellation, so that no result is lost.

`BackgroundTasks`, and no task group: that must be left in the task that entered it. A robot may be
opened in one task and closed in another: by the set-up and the tear-down of a test fixture, or in
two cells of a notebook.

`every`: an absolute schedule. A turn that comes late does not move the later ones.

`Alarm`: a wait that ends at a time, or before. A cancel scope with a deadline costs half as much
again, and tasks are asked about thirty times a second for each robot.

`on_grid`: what waits for many robots of one loop is due at the same moments, where it need not be
exact. Most of what a wait costs is the turn of the loop, which then serves several.
"""

from __future__ import annotations

import asyncio
import threading
import time
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import anyio

from aioduco._wire.forks import fork_hooks
from aioduco._wire.handoff import loop_callback
from aioduco.reporting import BackgroundLogger

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Coroutine
    from typing import Self

__all__ = [
    "GRID",
    "Alarm",
    "BackgroundTasks",
    "DaemonThread",
    "Ticker",
    "every",
    "on_grid",
    "run_to_completion",
]

#: time between two moments of `on_grid` [s]
GRID = 0.002

T = TypeVar("T")

_log = BackgroundLogger(__name__)


class Ticker:
    """Turns of a loop on an absolute schedule; `every` makes one.

    Args:
        period: seconds between two turns.
        first: when the first turn is due [s of `time.monotonic`]; it comes without a wait.

    Attributes:
        period: seconds until the next turn; may be changed at any time.
        due: when this turn was due [s of `time.monotonic`].
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
        """Wait for the next turn; one whose time has passed is due now, others are left out."""
        now = time.monotonic()
        self.due = max(self.due + self.period, now)
        await anyio.sleep(self.due - now)

    def postpone(self, seconds: float) -> None:
        """Let the next turn come a period after `seconds` from now, or later."""
        self.due = max(self.due, time.monotonic() + seconds)

    def restart(self) -> None:
        """Let the next turn come at once, and the schedule begin anew with it."""
        self.due = time.monotonic()
        self._begun = False


def every(period: float, first: float | None = None) -> Ticker:
    """The turns of a loop, a period apart: `async for due in every(0.01):`.

    The first turn comes at once. A turn that comes late does not move the later ones, and what was
    missed is left out.

    Args:
        period: seconds between two turns.
        first: when the first turn was due [s of `time.monotonic`]; None for now.

    Returns:
        An iterator over the times when the turns were due [s of `time.monotonic`].
    """
    return Ticker(period, time.monotonic() if first is None else first)


def on_grid(at: float) -> float:
    """The last moment of the grid before a time, or the time itself [s of `time.monotonic`]."""
    return at - at % GRID


class Alarm:
    """Wakes the task that waits for it when its time has come, or when it is rung before."""

    __slots__ = ("_rung", "_waiter")

    def __init__(self) -> None:
        self._rung = False
        self._waiter: asyncio.Future[None] | None = None

    def ring(self) -> None:
        """Wake the task that waits, or the next one that comes to wait; on the event loop."""
        self._rung = True
        if self._waiter is not None:
            _wake(self._waiter)

    async def wait(self, due: float | None = None) -> None:
        """Wait until it is rung, or until the time has come.

        Args:
            due: the time [s of `time.monotonic`]; None: until it is rung.
        """
        if self._rung:
            self._rung = False
            return
        loop = asyncio.get_running_loop()
        waiter = self._waiter = loop.create_future()
        timer = None
        if due is not None:
            timer = loop.call_later(max(due - time.monotonic(), 0.0), _wake, waiter)
        try:
            await waiter
        finally:
            self._waiter, self._rung = None, False
            if timer is not None:
                timer.cancel()


def _wake(waiter: asyncio.Future[None]) -> None:
    if not waiter.done():
        waiter.set_result(None)


async def run_to_completion(step: Callable[[], Awaitable[T]]) -> tuple[T, BaseException | None]:
    """Await `step()`, again whenever it is cancelled, until it returns or raises.

    An interrupt from the keyboard, or an exit from a signal handler, that lands in the middle of
    it is treated like a cancellation.

    Args:
        step: makes what is awaited; called once, and once more for each cancellation.

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
    return results[0], cancelled


class _Job(Generic[T]):
    """A function that runs on the thread, and its result."""

    def __init__(self, work: Callable[[], T]) -> None:
        self._work = work
        self._results: list[T] = []
        self._error: BaseException | None = None
        self._over = anyio.Event()
        self._ring = loop_callback(self._over.set)

    def run(self) -> None:
        """Call the function; on the thread."""
        try:
            self._results.append(self._work())
        except BaseException as exc:
            # belongs to whoever waits
            self._error = exc
        self._ring()

    async def wait(self) -> T:
        """Wait for the result; raise what the function raised."""
        await self._over.wait()
        if self._error is not None:
            raise self._error
        return self._results[0]


class DaemonThread:
    """A daemon thread for blocking calls. It starts at once: later the system may have none left.

    Raises:
        RuntimeError: the system has no more threads.
    """

    def __init__(self) -> None:
        self._inbox: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        threading.Thread(
            target=_serve, args=(self._inbox,), name="aioduco-guard-wait", daemon=True
        ).start()

    def __del__(self) -> None:
        if (inbox := getattr(self, "_inbox", None)) is not None:
            inbox.put(None)

    async def run(self, work: Callable[[], T]) -> tuple[T, BaseException | None]:
        """Call a function that blocks, to its end even if this is cancelled.

        Args:
            work: called on the thread; it must end by itself.

        Returns:
            Its result, and the last cancellation that came meanwhile: the caller must raise it.
        """
        job = _Job(work)
        self._inbox.put(job.run)
        return await run_to_completion(job.wait)

    def end(self) -> None:
        """Let the thread end after the calls that it was given; no call may follow."""
        self._inbox.put(None)


def _serve(inbox: SimpleQueue[Callable[[], None] | None]) -> None:
    while (work := inbox.get()) is not None:
        work()


class BackgroundTasks:
    """Runs coroutines beside the program, and knows which still run.

    Args:
        crashed: called with what a coroutine raised, other than its cancellation.
        cut_off: called when somebody else cancelled one: its event loop ends, mostly.
    """

    def __init__(
        self,
        crashed: Callable[[BaseException], None],
        cut_off: Callable[[], None] = lambda: None,
    ) -> None:
        self._crashed = crashed
        self._cut_off = cut_off
        self._closing = False
        self._forked_off = False
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
            work: what runs.
            name: the name of its task.
            then: called when it is over, also if it was cancelled before it began: then not even
                its `finally` runs, and whoever waits for it would wait for ever.
        """
        task = asyncio.get_running_loop().create_task(work, name=name)
        self._tasks.add(task)
        if then is not None:
            task.add_done_callback(lambda _: then())
        task.add_done_callback(self._ended)

    def forked(self) -> None:
        """This is a forked child: what ends here goes on in the parent."""
        self._forked_off = True

    async def aclose(self) -> None:
        """Cancel what still runs, and wait until it has ended."""
        self._closing = True
        # what belongs to a loop that was closed can neither run nor be cancelled any more
        self._tasks = {task for task in self._tasks if not task.get_loop().is_closed()}
        while self._tasks:
            for task in self._tasks:
                task.cancel()
            done, _ = await asyncio.wait(self._tasks)
            self._tasks -= done  # also those of which an interrupt kept `_ended` from knowing

    async def ended(self) -> None:
        """Wait until nothing runs any more."""
        while self._tasks:
            done, _ = await asyncio.wait(self._tasks)
            self._tasks -= done

    def _ended(self, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if self._forked_off:
            if not task.cancelled():
                task.exception()  # it is looked at, so that asyncio says nothing of it
            return
        if task.cancelled():
            if not self._closing:
                self._cut_off()
        elif (error := task.exception()) is not None:
            self._crashed(error)
            _log.error("%s failed", task.get_name(), exc_info=error)
