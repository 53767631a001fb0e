"""An event loop on a thread of its own, which runs one robot.

Guarantees:
- A call that is interrupted (by Ctrl-C, or by another exception of a signal handler) is cancelled
  on the loop, and runs to its end there, before the interrupt is raised: a motion that the call
  waited for has been stopped by then. A second Ctrl-C does not shorten this.
- If the main thread ends without closing the robot, the loop's thread closes it, which stops this
  program's motions. The loop's thread keeps the process alive until then.
- A motion without an end of its own is stopped when the thread that holds it has made no call for
  `hold_limit`.
"""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import anyio
from anyio.from_thread import BlockingPortal

from aioduco._process import trial
from aioduco._process.reporting import BackgroundLogger
from aioduco._wire.forks import fork_hooks
from aioduco.errors import DucoError, RobotStateError, WrongProcess
from aioduco.models.ranges import TIMEOUT
from aioduco.supervision.concurrency import every
from aioduco.sync._presence import CallTimes

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Coroutine

    from aioduco.robot import Robot
    from aioduco.supervision.task import Task
    from aioduco.sync._presence import CallRecord


_log = BackgroundLogger(__name__)

#: seconds between two checks of the main thread, and of the threads that hold motions
_WATCH_EVERY = 0.05
#: seconds between two wake-ups of a waiting thread, at which it can take an interrupt on systems
#: that do not wake it for one
_WAKE_EVERY = 0.2

T = TypeVar("T")


class StartedCall(Generic[T]):
    """A coroutine that runs on the loop while a thread waits for it."""

    def __init__(self, work: Coroutine[Any, Any, T]) -> None:
        self._work = work
        self._scope: anyio.CancelScope | None = None
        self._withdrawn = False
        self.over: threading.Event = threading.Event()
        self.answers: list[T] = []
        self.error: BaseException | None = None

    async def run(self) -> None:
        """Run the coroutine; on the loop."""
        try:
            if self._withdrawn:
                return
            with anyio.CancelScope() as self._scope:
                self.answers.append(await self._work)
        # It is raised in the waiting thread: also the end of the program that a function of the
        # program asked for, such as a predicate. It would end the loop, and be lost.
        except (Exception, SystemExit, KeyboardInterrupt) as exc:
            self.error = exc
        finally:
            self._work.close()
            self.over.set()

    def withdraw(self) -> bool:
        """Cancel the work, or prevent its start; on the loop.

        Returns:
            Whether it has begun: then the caller must wait for its end.
        """
        self._withdrawn = True
        if self._scope is None:
            self._work.close()
            return False
        self._scope.cancel()
        return True

    def wait(self) -> None:
        """Wait for the end."""
        while not self.over.wait(_WAKE_EVERY):
            pass


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
        #: the calls of the thread that holds a task, by the task's id
        self._holders: dict[int, CallRecord] = {}
        #: ids of the tasks that were stopped because their thread made no call for too long
        self._stopped_unheld: set[int] = set()
        #: functions that are awaited after the robot has been closed: the ends of its streams
        self._at_close: list[Callable[[], Awaitable[None]]] = []
        self._portal: BlockingPortal | None = None
        self._in_forked_child = False
        fork_hooks.add(self)
        self._ready = threading.Event()
        self._asked_to_end = False
        self._thread = threading.Thread(
            target=anyio.run, args=(self._main,), name=f"aioduco-sync {robot.host}", daemon=False
        )

    @property
    def running(self) -> bool:
        """Whether the loop runs."""
        return self._thread.is_alive()

    def open(self) -> None:
        """Start the thread, and connect."""
        if self._thread.ident is not None:
            raise RobotStateError("a robot is opened once: make another one by connect()")
        self._thread.start()
        try:
            with trial.untimed():  # until the loop of the thread waits
                while not self._ready.wait(_WAKE_EVERY):
                    pass
                self.call(self.robot.open())
        except BaseException:
            self._asked_to_end = True
            _uninterrupted(self._thread.join)
            raise

    def close(self) -> None:
        """Close the robot, and end the thread."""
        if not self.running:
            return
        try:
            self.call(self.robot.aclose())
        finally:
            self._asked_to_end = True
            _uninterrupted(self._thread.join)

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
        call = StartedCall(work)
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
        call = StartedCall(work)
        self._hand_over(call, work)
        return call

    def call_sync(self, function: Callable[[], T]) -> T:
        """Call a function that does not block, on the loop if it runs."""
        if threading.get_ident() == self._thread.ident or not self.running:
            return function()
        return self.call(_await(function))

    def sleep(self, seconds: float) -> None:
        """Wait; this counts as a call of the thread."""
        self.call(anyio.sleep(seconds))

    def holds(self, task: Task) -> None:
        """Note that the calling thread holds a task."""
        self._holders[task.id] = self._call_times.here

    def was_stopped_unheld(self, task: Task) -> bool:
        """Whether a task was stopped because its thread made no call for too long."""
        return task.id in self._stopped_unheld

    def _hand_over(self, call: StartedCall[T], work: Coroutine[Any, Any, T]) -> None:
        portal = self._portal
        if self._in_forked_child:
            work.close()
            raise WrongProcess(
                "refused, since the robot belongs to the process that forked this one; nothing was "
                "sent. Open another one in this process"
            )
        if portal is None or not self.running:
            work.close()
            raise RobotStateError("the robot is not open: nothing was sent")
        if threading.get_ident() == self._thread.ident:
            work.close()
            raise RuntimeError(
                "this is called on the thread of the robot's event loop, as predicates are: it "
                "would wait for itself. Nothing was sent"
            )
        try:
            portal.start_task_soon(call.run)
        except RuntimeError as exc:
            work.close()
            raise RobotStateError("the robot is being closed: nothing was sent") from exc

    def _cancel_call(
        self, call: StartedCall[T], undo: Callable[[T], Coroutine[Any, Any, object]] | None
    ) -> None:
        portal = self._portal
        if portal is None or threading.get_ident() == self._thread.ident:
            return

        def withdraw() -> None:
            try:
                begun = portal.call(call.withdraw)
            except RuntimeError:  # the loop ends, and with it all work that was begun
                return
            if begun:
                call.wait()

        _uninterrupted(withdraw)
        if call.answers and undo is not None:
            undoing = StartedCall(undo(call.answers[0]))
            portal.start_task_soon(undoing.run)
            _uninterrupted(undoing.wait)
            call.error = undoing.error

    def forked(self) -> None:
        """In a forked child, where the loop's thread does not run: refuse all calls."""
        self._in_forked_child = True
        self._portal = None

    # The methods below run on the loop.

    def at_close(self, work: Callable[[], Awaitable[None]]) -> None:
        """Register a function that is awaited after the robot has been closed."""
        self._at_close.append(work)

    def remove_at_close(self, work: Callable[[], Awaitable[None]]) -> None:
        """Remove a function that was registered by `at_close`, if it was."""
        if work in self._at_close:
            self._at_close.remove(work)

    async def _main(self) -> None:
        async with BlockingPortal() as self._portal:
            self._ready.set()
            await self._watch()

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
        live = {task.id: task for task in self.robot.tasks}
        for task_id in [known for known in self._holders if known not in live]:
            del self._holders[task_id]
        unheld = []
        for task_id, thread in self._holders.items():
            limit = self._limit(live[task_id])
            if limit is not None and thread.idle_time(now) > limit:
                unheld.append(task_id)
        if not unheld:
            return
        for task_id in unheld:
            _log.warning("%r is stopped: the program made no call for too long", live[task_id])
            self._stopped_unheld.add(task_id)
            del self._holders[task_id]
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


def _uninterrupted(wait: Callable[[], object]) -> None:
    """Wait, and ignore every further Ctrl-C; the caller raises the first one."""
    while True:
        try:
            wait()
        except KeyboardInterrupt:
            continue
        return
