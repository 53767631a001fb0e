"""An event loop on a thread of its own, which runs one robot.

Guarantees:
- A call that is interrupted (by Ctrl-C, or by another exception of a signal handler) is cancelled
  on the loop, and runs to its end there, before the interrupt is raised: a motion that the call
  waited for has been stopped by then. A second interrupt does not shorten this: nothing by which a
  thread of the program waits, or hands its calls over, has a lock that an interrupt could leave
  held or let go of, as `threading.Event` and futures have: see `_process/wakeup.py`.
- A call belongs to the moment in which it was made: a stop of another thread ends it although the
  loop, which was busy, had not begun it.
- If the main thread ends without closing the robot, the loop's thread closes it, which stops this
  program's motions. The loop's thread keeps the process alive until then.
- A motion without an end of its own is stopped when the thread that holds it has made no call for
  `hold_limit`.
"""

from __future__ import annotations

import threading
import time
from contextvars import copy_context
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import anyio

from aioduco._process import trial
from aioduco._process.reporting import BackgroundLogger
from aioduco._process.wakeup import Wakeup
from aioduco._wire.forks import fork_hooks
from aioduco._wire.owner_loop import OwnerLoop
from aioduco.errors import DucoError, RobotStateError, WrongProcess
from aioduco.models.ranges import TIMEOUT
from aioduco.supervision.concurrency import BackgroundTasks, every
from aioduco.sync._presence import CallRecord, CallTimes

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Coroutine

    from aioduco.robot import Robot
    from aioduco.supervision.task import Task


_log = BackgroundLogger(__name__)

#: seconds between two checks of the main thread, and of the threads that hold motions
_WATCH_EVERY = 0.05
#: seconds between two wake-ups of a waiting thread, at which it can take an interrupt on systems
#: that do not wake it for one
_WAKE_EVERY = 0.2
#: errors of one kind during a step, after which the next one is its own, and no signal handler's
_OFTEN = 100
#: seconds after the robot was closed for calls to end by themselves
_GRACE = 1.0

T = TypeVar("T")


class Latch:
    """An event that is set once. An interrupt of the thread that waits leaves it whole."""

    def __init__(self) -> None:
        self._set = False
        self._wakeup = Wakeup()

    def set(self) -> None:
        """Set it."""
        self._set = True
        self._wakeup.set()

    def is_set(self) -> bool:
        """Whether it is set."""
        return self._set

    def wait(self, lost: Callable[[], bool] = lambda: False) -> None:
        """Wait until it is set, or until nothing will set it, as `lost` says."""
        while not self._set and not lost():
            self._wakeup.wait(_WAKE_EVERY)


class StartedCall(Generic[T]):
    """A coroutine that runs on the loop while a thread waits for it.

    Attributes:
        over: set when the work has ended, or will not begin.
    """

    def __init__(self, work: Coroutine[Any, Any, T], runner: Runner) -> None:
        self._work = work
        self._runner = runner
        self._begun = False
        self._scope: anyio.CancelScope | None = None
        #: tells a trial of the program that the wait is over
        self._waited: Callable[[], object] | None = None
        self.over: Latch = Latch()
        self.answers: list[T] = []
        self.error: BaseException | None = None

    def begin(self, calls: BackgroundTasks | None) -> None:
        """Begin the work, once, in a task; on the loop. None: it begins no work any more."""
        if self._begun:
            return
        if calls is not None:
            self._begun = True
            calls.start(self._run(), "aioduco-sync call")
        elif not self.over.is_set():
            self.refuse(RobotStateError("the robot is being closed: nothing was sent"))

    async def _run(self) -> None:
        try:
            if self.over.is_set():
                return
            with anyio.CancelScope() as self._scope:
                self.answers.append(await self._work)
        # It is raised in the waiting thread: also the end of the program, or a cancellation, that a
        # function of the program asked for, such as a predicate. It would be lost here.
        except (Exception, SystemExit, KeyboardInterrupt) as exc:
            self.error = exc
        except anyio.get_cancelled_exc_class() as exc:
            self.error = RobotStateError("the robot was closed") if self._runner.closing else exc
        finally:
            self._end()

    def withdraw(self) -> None:
        """Cancel the work, or prevent its start; on the loop."""
        if self._scope is not None:
            self._scope.cancel()
        elif not self.over.is_set():
            self._end()

    def refuse(self, error: DucoError) -> None:
        """Do not begin the work."""
        self.error = error
        self._end()

    def _end(self) -> None:
        self._work.close()
        if self._waited is not None:
            self._waited()
        self.over.set()

    def wait(self) -> None:
        """Wait for the end."""
        with trial.waiting() as self._waited:
            self.over.wait(lambda: not self._runner.running)
        if self._runner.in_forked_child:  # a handler of a signal forked: the parent has the call
            self.error = WrongProcess(
                "the call goes on in the process that forked this one, to which the robot belongs; "
                "this one sent nothing. Open another robot in this process"
            )
            return
        # handed over when the loop had run for the last time
        self.begin(None)


class Runner:
    """Runs one robot's event loop, and passes calls to it.

    Args:
        robot: the robot, not open yet.
        hold_limit: seconds without a call after which a motion without an end of its own is
            stopped; None for no limit.
        program_limit: the same for every motion.

    Raises:
        ParameterError: a limit is not above 0.
    """

    def __init__(self, robot: Robot, hold_limit: float | None, program_limit: float | None) -> None:
        for name, limit in (("hold_limit", hold_limit), ("program_limit", program_limit)):
            if limit is not None:
                TIMEOUT(name, limit)
        self.robot = robot
        self._hold_limit = hold_limit
        self._program_limit = program_limit
        self._call_times = CallTimes()
        #: the calls of the thread that holds a task; any thread may add one
        self._holders: dict[Task, CallRecord] = {}
        #: the tasks that were stopped because their thread made no call for too long
        self._stopped_unheld: set[Task] = set()
        #: functions that are awaited after the robot has been closed: the ends of its streams
        self._at_close: list[Callable[[], Awaitable[None]]] = []
        self._loop = OwnerLoop("the robot", moves=False)
        #: the calls that run; each keeps its own error
        self._calls = BackgroundTasks(crashed=lambda _: None)
        #: whether no call begins any more, and those that still run end
        self.closing: bool = False
        #: whether this is a forked child, where the loop's thread does not run
        self.in_forked_child: bool = False
        fork_hooks.add(self)
        self._ready = Latch()
        # Not the thread's own: Python 3.11 takes an interrupt of `is_alive` or `join` for its end.
        self._ended = Latch()
        self._asked_to_end = False
        self._thread = threading.Thread(
            target=self._run, name=f"aioduco-sync {robot.host}", daemon=False
        )

    @property
    def running(self) -> bool:
        """Whether the loop runs, or is about to."""
        started = self._thread.ident is not None and not self.in_forked_child
        return started and not self._ended.is_set()

    def open(self) -> None:
        """Start the thread, and connect."""
        if self._thread.ident is not None:
            raise RobotStateError("a robot is opened once: make another one by connect()")
        self._thread.start()
        try:
            with trial.untimed():  # until the loop of the thread waits
                self._ready.wait(lambda: not self.running)
                self.call(self.robot.open())
        except BaseException:
            self._wait_for_end()
            raise

    def close(self) -> None:
        """Close the robot, and end the thread."""
        if not self.running:
            return
        self._require_other_thread()
        try:
            self.call(self.robot.aclose())
        except RobotStateError:
            return  # another thread has closed it
        finally:
            self._wait_for_end()

    def _wait_for_end(self) -> None:
        self._asked_to_end = True
        for interrupt in uninterrupted(self._ended.wait) + uninterrupted(self._thread.join):
            raise interrupt

    def ask_to_close(self) -> None:
        """Request that the loop closes the robot and ends; do not wait. From any thread."""
        self._asked_to_end = True

    def call(
        self,
        work: Coroutine[Any, Any, T],
        undo: Callable[[T], Coroutine[Any, Any, object]] | None = None,
    ) -> T:
        """Run work on the loop, and wait for it.

        Args:
            work: the coroutine to run there.
            undo: called with the result and awaited, if an interrupt comes when the work is done,
                so that the caller does not get the result.

        Returns:
            The result.

        Raises:
            RobotStateError: the robot is not open.
            RuntimeError: this is the loop's own thread.
            WrongProcess: this is a forked child.
        """
        thread = self._call_times.here
        call = StartedCall(work, self)
        thread.enter()
        try:
            self._hand_over(call, work)
            call.wait()
        except BaseException as interrupt:
            # An interrupt may have come at any moment, even before the work was handed over.
            self._cancel_call(call, undo)
            if call.error is not None:
                raise interrupt from call.error
            raise
        finally:
            thread.leave(time.monotonic())
        if call.error is not None:
            try:
                raise call.error
            finally:
                del call  # the error's traceback would keep itself alive
        return call.answers[0]

    def start(self, work: Coroutine[Any, Any, T]) -> StartedCall[T]:
        """Run work on the loop to its end, without waiting for it.

        Raises:
            RobotStateError: the robot is not open.
            RuntimeError: this is the loop's own thread.
        """
        call = StartedCall(work, self)
        self._hand_over(call, work)
        return call

    def call_sync(self, function: Callable[[], T]) -> T:
        """Call a function that does not block, on the loop if it runs."""
        if threading.get_ident() == self._thread.ident or not self.running:
            return function()
        return self.call(_await(function))

    def sleep(self, seconds: float) -> None:
        """Wait; this counts as a call of the thread."""
        self.call(anyio.sleep(seconds if trial.current is None else 0.0))
        if trial.current is not None:
            trial.current.sleep(seconds)

    def holds(self, task: Task) -> None:
        """Note that the calling thread holds a task."""
        self._holders[task] = self._call_times.here

    def was_stopped_unheld(self, task: Task) -> bool:
        """Whether a task was stopped because its thread made no call for too long."""
        return task in self._stopped_unheld

    def _hand_over(self, call: StartedCall[T], work: Coroutine[Any, Any, T]) -> None:
        if self.in_forked_child:
            work.close()
            raise WrongProcess(
                "refused, since the robot belongs to the process that forked this one; nothing was "
                "sent. Open another one in this process"
            )
        if not self._ready.is_set() or not self.running:
            work.close()
            raise RobotStateError("the robot is not open: nothing was sent")
        try:
            self._require_other_thread()
        except RuntimeError:
            work.close()
            raise
        # in a copy of the context: an interrupt leaves nothing in the thread's own
        copy_context().run(self._send_over, call)

    def _require_other_thread(self) -> None:
        if threading.get_ident() == self._thread.ident:
            raise RuntimeError(
                "this is called on the thread of the robot's event loop, as predicates are: it "
                "would wait for itself. Nothing was sent"
            )

    def _send_over(self, call: StartedCall[Any]) -> None:
        with self.robot._supervisor.permits.from_now("a call"):
            self._loop.run(lambda: self._begin(call))

    def _cancel_call(
        self, call: StartedCall[T], undo: Callable[[T], Coroutine[Any, Any, object]] | None
    ) -> None:
        if self.in_forked_child or threading.get_ident() == self._thread.ident:
            return
        undoing: list[StartedCall[object]] = []

        def cancel() -> None:
            self._loop.run(call.withdraw)
            call.wait()
            if not call.answers or undo is None:
                return
            if not undoing:
                undoing.append(StartedCall(undo(call.answers[0]), self))
            self._loop.run(lambda: self._begin(undoing[0]))
            undoing[0].wait()
            call.error = undoing[0].error

        uninterrupted(cancel)

    def forked(self) -> None:
        """In a forked child, where the loop's thread does not run: refuse all calls."""
        self.in_forked_child = True

    # The methods below run on the loop.

    def at_close(self, work: Callable[[], Awaitable[None]]) -> None:
        """Register a function that is awaited after the robot has been closed."""
        self._at_close.append(work)

    def remove_at_close(self, work: Callable[[], Awaitable[None]]) -> None:
        """Remove a function that was registered by `at_close`, if it was."""
        if work in self._at_close:
            self._at_close.remove(work)

    def _run(self) -> None:
        try:
            anyio.run(self._main)
        finally:
            self._ended.set()

    async def _main(self) -> None:
        self._loop.require("the robot")
        self._ready.set()
        try:
            await self._watch()
        except BaseException:
            self.closing = True
            await self._calls.aclose()
            raise
        self.closing = True
        with anyio.move_on_after(_GRACE):
            await self._calls.ended()
        await self._calls.aclose()  # those that wait for a time, as `sleep` does

    def _begin(self, call: StartedCall[Any]) -> None:
        call.begin(None if self.closing else self._calls)

    async def _watch(self) -> None:
        main = threading.main_thread()
        async for _ in every(_WATCH_EVERY):
            if self._asked_to_end:
                break
            if not main.is_alive():
                _log.warning("the program ended and left %r open: it is closed", self.robot)
                break
            await self._stop_unheld()
        try:
            await self.robot.aclose()
        except DucoError:
            _log.exception("closing %r failed", self.robot)
        while self._at_close:
            await self._at_close.pop()()

    async def _stop_unheld(self) -> None:
        now = time.monotonic()
        holders = self._holders.copy()
        live = self.robot.tasks
        unheld = []
        for task, thread in holders.items():
            if task not in live:
                self._holders.pop(task, None)
                continue
            limit = self._limit(task)
            if limit is not None and thread.idle_time(now) > limit:
                unheld.append(task)
        if not unheld:
            return
        for task in unheld:
            _log.warning("%r is stopped: the program made no call for too long", task)
            self._stopped_unheld.add(task)
            self._holders.pop(task, None)
        try:
            await self.robot.stop()
        except DucoError:
            _log.exception("stopping %r failed", self.robot)

    def _limit(self, task: Task) -> float | None:
        held = task.continuous
        # In hand guiding a person moves the arm, and it stands when nobody does.
        endless = held is not None and held.time is None and not held.until_commanded
        limits = [self._program_limit, self._hold_limit if endless else None]
        return min((limit for limit in limits if limit is not None), default=None)


async def _await(function: Callable[[], T]) -> T:
    return function()


def uninterrupted(step: Callable[[], object]) -> list[BaseException]:
    """Take a step to its end, again after each interrupt: Ctrl-C, or what a signal handler raises.

    Args:
        step: it is safe to repeat, and goes on where it was. An error of its own, other than these
            two, is raised if it comes again and again: it comes at once.

    Returns:
        The interrupts; the caller raises one.
    """
    interrupts: list[BaseException] = []
    while True:
        try:
            step()
        except (KeyboardInterrupt, SystemExit) as exc:
            interrupts.append(exc)
        except Exception as exc:
            if sum(isinstance(before, type(exc)) for before in interrupts) >= _OFTEN:
                raise
            interrupts.append(exc)
        else:
            return interrupts
