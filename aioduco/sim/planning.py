"""Planning beside the cycles: the threads that plan motions, and how they make way for others.

Motions are planned one at a time and in their order, by the thread whose command brought them, or
by a thread of its own if they come of the cycle itself. Planning is done without the controller's
lock: it changes nothing, and reads nothing but the values that it begins with and how active
external axes are set up, which nobody may change while motions wait. The lock is taken to fetch the
values and to hand in what came of them. Between slices of its work planning gives the other threads
their turn, and a stop drops it there.
"""

from __future__ import annotations

import contextlib
import threading
import time
from typing import TYPE_CHECKING

from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.slices import PlanDropped

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.sim.controller import motion_queue
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.planner.mover import Drafted

__all__ = ["PlanningThreads"]

#: real time for which planning sleeps, so that others get the interpreter's lock at once, for which
#: they would otherwise wait until it is taken from the thread that plans [s]
_WAY = 5e-5
#: real time of work after which it does [s]
_WORK = 5e-4


class PlanningThreads:
    """Plans the motions of a controller, outside its lock.

    Args:
        controller: the state machine.
        lock: under which the controller is changed; never held here while planning.
        changing: the controller under that lock, for a change that others have to be told about.
        failed: told of an error that is none of a plan.
    """

    def __init__(
        self,
        controller: Controller,
        lock: threading.Lock,
        changing: Callable[[], contextlib.AbstractContextManager[Controller]],
        failed: Callable[[Exception], None],
    ) -> None:
        controller.plan_aside()
        self._controller = controller
        self._lock = lock
        self._changing = changing
        self._failed = failed
        self._plans = threading.Lock()  # held by the thread that plans; taken before the other
        self._current: motion_queue.Planning | None = None
        self._worked_from = 0.0
        self._due = threading.Event()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name="sim-planner", daemon=True)

    def start(self) -> None:
        """Start the thread that plans what comes of the cycle itself."""
        self._thread.start()

    def end(self) -> None:
        """Drop what is being planned, and plan nothing any more."""
        self._closing = True
        self._due.set()

    def join(self) -> None:
        """Return when the thread has ended."""
        if self._thread.is_alive():
            self._thread.join()

    def turn(self) -> None:
        """Let other threads go on; for what plans, between two slices of its work.

        Raises:
            PlanDropped: Nobody waits for the plan any more.
        """
        if self._closing or self._controller.planning is not self._current:
            raise PlanDropped
        if time.perf_counter() - self._worked_from >= _WORK:
            time.sleep(_WAY)
            self._worked_from = time.perf_counter()

    def plan(self, id_: int | None = None) -> None:
        """Plan what waits for it, in order: up to a motion, or all. Without the lock."""
        while not self._closing:
            with self._plans:
                with self._lock:
                    if id_ is not None and not self._controller.awaits_plan(id_):
                        return
                    current = self._current = self._controller.next_plan()
                if current is None:
                    return
                self._worked_from = time.perf_counter()
                with contextlib.suppress(PlanDropped):
                    self._plan(current)
            if current.id != id_:
                time.sleep(_WAY)  # those who wait to plan their own motion come first

    def plan_aside(self) -> None:
        """Have the thread plan what waits for it, unless another does. Under the lock."""
        if self._controller.unplanned is not None and not self._plans.locked():
            self._due.set()

    def _plan(self, current: motion_queue.Planning) -> None:
        came: Drafted | PlanError
        try:
            came = current.draft.work(self.turn)
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
