"""Planning outside the cycles: the threads that plan motions, and how they yield to others.

Motions are planned one at a time and in order. The thread whose command queued a motion plans it;
a separate thread plans the motions that the cycle itself queues. Planning runs without the
controller's lock: it changes nothing, and reads only the values that it begins with and the set-up
of active external axes, which must not change while motions wait. The thread takes the lock to
fetch the values and to hand in the result. Between slices of its work it yields to other threads,
and there a stop drops the plan.
"""

from __future__ import annotations

import contextlib
import threading
import time
from typing import TYPE_CHECKING

from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.slices import PlanDropped, yielding

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco.sim.controller import motion_queue
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.planner.mover import Drafted


#: real time for which planning sleeps, so that other threads get the interpreter's lock at once;
#: otherwise they would wait until the interpreter takes it from the planning thread [s]
_YIELD_SLEEP = 5e-5
#: real time of work between two such sleeps [s]
_YIELD_INTERVAL = 5e-4
#: longest real time for which planning waits for commands: it goes on beside many of them [s]
_GIVE_WAY = 0.005


class PlanningThreads:
    """Plans the motions of a controller, outside its lock.

    Args:
        controller: the state machine.
        lock: lock for changes of the controller; never held here while planning.
        changing: gives the controller under that lock, for a change that other threads must see.
        failed: called with an error that is not a plan's.
    """

    def __init__(
        self,
        controller: Controller,
        lock: threading.Lock,
        changing: Callable[[], contextlib.AbstractContextManager[Controller]],
        failed: Callable[[Exception], None],
    ) -> None:
        controller.plan_in_background()
        self._controller = controller
        self._lock = lock
        self._changing = changing
        self._failed = failed
        self._plans = threading.Lock()  # held by the thread that plans; acquired before `_lock`
        self._current: motion_queue.Planning | None = None
        self._worked_from = 0.0
        self._commands: list[None] = []  # one for each that is under way; appending is atomic
        self._due = threading.Event()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="sim-planner", daemon=True)

    def start(self) -> None:
        """Start the thread that plans the motions which the cycle itself queues."""
        self._thread.start()

    def end(self) -> None:
        """Drop the plan in progress, and plan nothing more."""
        self._closing = True
        self._due.set()

    def join(self) -> None:
        """Wait until the thread has ended."""
        if self._thread.is_alive():
            self._thread.join()

    @contextlib.contextmanager
    def giving_way(self) -> Iterator[None]:
        """Let planning wait, from its next slice on, while a command is carried out.

        A command needs the interpreter's lock several times: each time it would wait for the end of
        a slice.
        """
        self._commands.append(None)
        try:
            yield
        finally:
            self._commands.pop()

    def yield_hook(self) -> None:
        """Yield to other threads; the planning code calls this between two slices of its work.

        Raises:
            PlanDropped: The plan is no longer needed.
        """
        if self._commands:
            until = time.perf_counter() + _GIVE_WAY
            while self._commands and time.perf_counter() < until:
                time.sleep(_YIELD_SLEEP)
            self._worked_from = time.perf_counter()
        if self._closing or self._controller.motion.planning is not self._current:
            raise PlanDropped
        if time.perf_counter() - self._worked_from >= _YIELD_INTERVAL:
            time.sleep(_YIELD_SLEEP)
            self._worked_from = time.perf_counter()

    def plan(self, id_: int | None = None) -> None:
        """Plan the waiting motions in order: up to the given one, or all. Call without the lock."""
        while not self._closing:
            with self._plans:
                with self._lock:
                    if id_ is not None and not self._controller.motion.awaits_plan(id_):
                        return
                    current = self._current = self._controller.motion.next_plan()
                if current is None:
                    return
                self._worked_from = time.perf_counter()
                with contextlib.suppress(PlanDropped):
                    self._plan(current)
            if current.id != id_:
                time.sleep(_YIELD_SLEEP)  # threads that wait to plan their own motion come first

    def plan_in_background(self) -> None:
        """Let the thread plan the waiting motions, unless another does. Call under the lock."""
        if self._controller.unplanned is not None and not self._plans.locked():
            self._due.set()

    def _plan(self, current: motion_queue.Planning) -> None:
        came: Drafted | PlanError
        try:
            with yielding(self.yield_hook):
                came = current.draft.work()
        except PlanError as exc:
            came = exc
        except PlanDropped:
            raise
        except Exception as exc:
            with self._changing() as controller:
                controller.take_plan(current, PlanError("parameter", repr(exc)))
            raise
        with self._changing() as controller:
            controller.take_plan(current, came)

    def _run(self) -> None:
        try:
            while not self._closing:
                self._due.wait()
                self._due.clear()
                self.plan()
        except Exception as exc:
            self._failed(exc)
