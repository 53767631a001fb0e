"""The queue of motions: what the planner's mover does, told as states of tasks."""

from __future__ import annotations

from enum import Enum, auto
from typing import TYPE_CHECKING

from aioduco.models.enums import TaskState
from aioduco.sim.planner.errors import PlanError

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from aioduco.sim.planner.mover import Mover, SetPoint
    from aioduco.sim.planner.segments import Segment
    from aioduco.sim.tasks import TaskTable

    Vector = NDArray[np.float64]
    #: makes the segment of one motion, given the joints [rad] that it starts from
    Plan = Callable[[Vector], Segment]

#: motions that may wait behind each other; the manual gives no number
CAPACITY = 1000


class Phase(Enum):
    """What the queue as a whole is doing."""

    IDLE = auto()
    RUNNING = auto()
    PAUSING = auto()
    PAUSED = auto()
    STOPPING = auto()


class Motion:
    """Motion tasks one behind the other, without a clock.

    Invariants: every task that was appended ends exactly once; none is told to be stopped or
    paused before the arm stands.

    Args:
        tasks: the table that holds the tasks' states.
        mover: makes a mover that stands at the given joints [rad].
        q: joints at the start [rad]. Shape (6,).
    """

    def __init__(self, tasks: TaskTable, mover: Callable[[Vector], Mover], q: Vector) -> None:
        self._tasks = tasks
        self._make = mover
        self._mover = mover(q)
        self._speed = 1.0
        self._queue: dict[int, None] = {}
        self._phase = Phase.IDLE
        self._ending = (TaskState.STOPPED, "")
        self._waiting_for_rest: list[int] = []
        self._at_rest = True
        self.failures: list[str] = []

    @property
    def phase(self) -> Phase:
        """What the queue is doing."""
        return self._phase

    @property
    def moving(self) -> bool:
        """Whether the set-points move."""
        return self._mover.moving

    @property
    def full(self) -> bool:
        """Whether no further motion fits."""
        return len(self._queue) >= CAPACITY

    @property
    def setpoint(self) -> SetPoint:
        """The latest set-point."""
        return self._mover.setpoint

    def reset(self, q: Vector) -> None:
        """Stand at q [rad], where brakes have held the arm. Nothing may be queued."""
        assert not self._queue
        self._at_rest = True
        self._mover = self._make(q)
        self._mover.set_speed(self._speed)
        self._phase = Phase.IDLE

    def set_speed(self, fraction: float) -> None:
        """Global speed, 0.01 to 1."""
        self._speed = fraction
        self._mover.set_speed(fraction)

    def append(self, id_: int, plan: Plan) -> None:
        """Queue a motion."""
        self._queue[id_] = None
        if self._phase is Phase.IDLE:
            self._phase = Phase.RUNNING

        def checked(start: Vector) -> Segment:
            # Here and not by the mover's event: it may plan the next motion before it tells.
            if id_ not in self._queue:
                raise PlanError("parameter", "the motion before it failed")
            try:
                return plan(start)
            except PlanError as exc:
                self._fail(id_, exc)
                raise

        try:
            self._mover.append(id_, checked)
        except PlanError:
            self._settle()

    def stop(self, state: TaskState, message: str, control: int | None = None) -> None:
        """Decelerate along the path and drop the queue.

        Args:
            state: what the motions end as, once the arm stands.
            message: why, for people.
            control: a task that ends then, too.
        """
        if control is not None:
            self._tasks.set(control, TaskState.RUNNING)
            self._waiting_for_rest.append(control)
        # A fault during a stop is what counts; a stop during a fault changes nothing.
        if self._phase is not Phase.STOPPING or state is TaskState.ERROR:
            self._ending = (state, message)
        self._phase = Phase.STOPPING
        self._mover.stop()
        self._settle()

    def cut(self, message: str, q: Vector) -> None:
        """The brakes fall at q [rad]: every motion ends with an error, wherever the arm is."""
        self._ending = (TaskState.ERROR, message)
        self._end_all()
        self.reset(q)

    def pause(self, control: int | None = None) -> None:
        """Decelerate along the path and keep the queue; ends the control task at rest."""
        if control is not None:
            self._tasks.set(control, TaskState.RUNNING)
            self._waiting_for_rest.append(control)
        if self._phase is Phase.RUNNING:
            self._phase = Phase.PAUSING
            self._mover.pause()
        self._settle()

    def resume(self) -> None:
        """Go on where a pause stopped."""
        if self._phase not in (Phase.PAUSING, Phase.PAUSED):
            return
        self._phase = Phase.RUNNING
        self._mover.resume()
        for id_ in self._queue:
            if self._tasks.state(id_) is TaskState.PAUSED:
                self._tasks.set(id_, TaskState.RUNNING)
        self._finish_waiting(TaskState.INTERRUPT)

    def tick(self, *, at_rest: bool) -> SetPoint:
        """The set-point of the next cycle.

        Args:
            at_rest: whether the arm itself stands: it comes to rest after its set-points.
        """
        self._at_rest = at_rest
        tick = self._mover.tick()
        for key, event, _ in tick.events:
            self._note(key, event)
        if self._phase is not Phase.IDLE or self._waiting_for_rest:
            self._settle()
        return tick.setpoint

    def _note(self, id_: int, event: str) -> None:
        if id_ not in self._queue:
            return  # ended before the mover came to tell
        if event == "started":
            self._tasks.set(id_, TaskState.RUNNING)
        elif event == "finished":
            self._end(id_, TaskState.FINISHED)
        elif event == "blended":
            self._end(id_, TaskState.INTERRUPT, "blended into the next motion")
        # "stopped" is told when the arm stands, see `_settle`; "failed" was told by the plan.

    def _settle(self) -> None:
        """Draw the conclusions of the arm standing, when it does."""
        if self._mover.moving:
            return
        if not self._queue and self._phase is not Phase.STOPPING:
            self._phase = Phase.IDLE
        if not self._at_rest:
            return
        if self._phase is Phase.STOPPING:
            self._end_all()
        elif self._phase is Phase.IDLE:
            self._finish_waiting()
        elif self._phase is Phase.PAUSING:
            self._phase = Phase.PAUSED
            for id_ in self._queue:
                if self._tasks.state(id_) is TaskState.RUNNING:
                    self._tasks.set(id_, TaskState.PAUSED)
            self._finish_waiting()
        elif self._phase is Phase.PAUSED:
            self._finish_waiting()

    def _fail(self, id_: int, error: PlanError) -> None:
        """A motion cannot be planned: those behind it counted on its end, so they go, too."""
        mismatch = error.code == "parameter"
        state = TaskState.PARAMETER_MISMATCH if mismatch else TaskState.ERROR
        message = str(error)
        queue = list(self._queue)
        self._end(id_, state, message)
        self.failures.append(message)
        for behind in queue[queue.index(id_) + 1 :]:
            self._end(behind, TaskState.INTERRUPT, f"the motion before it failed: {message}")

    def _end_all(self) -> None:
        for id_ in list(self._queue):
            self._end(id_, *self._ending)
        self._phase = Phase.IDLE
        self._finish_waiting()

    def _end(self, id_: int, state: TaskState, message: str = "") -> None:
        del self._queue[id_]
        self._tasks.set(id_, state, message)

    def _finish_waiting(self, state: TaskState = TaskState.FINISHED) -> None:
        waiting, self._waiting_for_rest = self._waiting_for_rest, []
        for id_ in waiting:
            self._tasks.set(id_, state)
