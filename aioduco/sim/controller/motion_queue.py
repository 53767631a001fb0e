"""The queue of motions: it drives the planner's mover and sets the states of the tasks.

Motions that came while the arm was being stopped wait beside it until the arm stands.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from aioduco.models.enums import TaskState
from aioduco.sim.controller.tasks import MotionPhase, TaskTable
from aioduco.sim.controller.triggers import MotionTriggers, Triggers
from aioduco.sim.planner.path import JointSetPoint, PlanError

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.models.rotation import Array
    from aioduco.sim.planner.follower import FollowError, TargetFollower
    from aioduco.sim.planner.mover import Draft, Drafted, Mover
    from aioduco.sim.planner.segments import Segment

    Plan = Callable[[Array], Segment]


_IDLE = MotionPhase.IDLE  # looked up once, to save time in the cycle
#: largest number of motions in the queue; the manual gives none
CAPACITY = 1000


@dataclass(frozen=True, slots=True)
class Following:
    """A motion whose targets arrive while it runs.

    Two are equal if the later one can take over from the earlier one while that runs.

    Attributes:
        kind: kind of the motion: the function's name.
        make: makes the follower for the joints [rad] at which the arm stands. Shape (6,).
        aim: gives a follower of this kind its target; raises PlanError if there is none.
        alone: whether no other motion is accepted while it runs.
        idle: whether it begins only if nothing else runs.
        settings: values that must be equal for a motion to take over.
    """

    kind: str
    make: Callable[[Array], TargetFollower] = field(compare=False)
    aim: Callable[[Any], None] = field(compare=False)
    alone: bool = field(default=False, compare=False)
    idle: bool = field(default=False, compare=False)
    settings: tuple[object, ...] = ()

    @classmethod
    def behind(cls, kind: str, make: Callable[[Array], TargetFollower]) -> Following:
        """A motion that waits for the motions before it; those behind it wait for it."""
        return cls(kind, make, _no_target, settings=(object(),))

    @classmethod
    def once(cls, kind: str, make: Callable[[Array], TargetFollower]) -> Following:
        """A motion that excludes all others: no other motion runs, waits or takes over."""
        return cls(kind, make, _no_target, alone=True, idle=True, settings=(object(),))


def _no_target(_follower: TargetFollower) -> None:
    """Set no target: the follower was made with all its targets."""


class Planning(NamedTuple):
    """A motion that is being planned outside the cycle.

    Attributes:
        id: id of its task.
        draft: inputs of the plan; its method `work` makes the plan.
    """

    id: int
    draft: Draft


class MotionQueue:
    """Motion tasks in order, without a clock.

    The mover runs the motions with a path, and looks ahead from one to the next. A motion that
    follows targets as they arrive runs alone: it waits until the motions before it have ended, and
    the motions behind it wait here, because they begin where it ends.

    A motion with a path is planned when it is queued, or `in_background`. In the latter case it
    waits here, too, in order: the thread that calls `next_plan` plans it and hands the result to
    `take_plan`. At most one motion is being planned. When its task ends, the plan is dropped, and
    `take_plan` ignores a later result.

    Invariants: every appended task ends exactly once; no task becomes stopped or paused before the
    arm stands.

    Args:
        tasks: the table that holds the tasks' states.
        mover: makes a mover that stands at the given joints [rad].
        q: joints at the start [rad]. Shape (6,).

    Attributes:
        phase: present phase of the queue, and the only record of it.
        failures, faults: messages for the error list, and of safety stops, until they are taken.
    """

    def __init__(self, tasks: TaskTable, mover: Callable[[Array], Mover], q: Array) -> None:
        self._tasks = tasks
        self._make = mover
        self.mover: Mover = mover(q)
        self._speed = 1.0
        self._queue: dict[int, None] = {}
        self.phase: MotionPhase = _IDLE
        self._ending = (TaskState.STOPPED, "")
        self._waiting_for_rest: list[int] = []
        self._finishing = False  # whether `finish` ends the last motion
        self._at_rest = True
        self._triggers = Triggers()
        #: ids of motions with a blend radius whose calls are not answered yet
        self.blending: dict[int, None] = {}
        self._time = 0.0
        self._follower: TargetFollower | None = None
        self._following: tuple[int, Following] | None = None
        self._behind: deque[tuple[int, Plan | Following]] = deque()
        self.in_background: bool = False  # whether another thread plans motions, not `append`
        #: ids and plans of the motions that are not planned yet; they are before `_behind`
        self.unplanned: deque[tuple[int, Plan]] = deque()
        #: the motion that is being planned, the first of `unplanned`; None if it was dropped, too
        self.planning: Planning | None = None
        self.failures: list[str] = []
        self.faults: list[str] = []

    @property
    def moving(self) -> bool:
        """Whether the set-points move."""
        return self.mover.moving if self._follower is None else self._follower.moving

    @property
    def following(self) -> Following | None:
        """The running motion if it follows targets; None if it has a path."""
        return None if self._following is None else self._following[1]

    @property
    def last(self) -> Following | None:
        """The last motion in the queue if it follows targets; None if it has a path."""
        if not self._behind:
            return self.following
        last = self._behind[-1][1]
        return last if isinstance(last, Following) else None

    @property
    def ending(self) -> bool:
        """Whether everything is being ended on request, and the arm does not stand yet.

        It is over in the cycle in which the tasks that wait for rest end.
        """
        if self.phase is MotionPhase.STOPPING:
            return self._ending[0] is not TaskState.ERROR
        return self._finishing

    def __len__(self) -> int:
        return len(self._queue)

    @property
    def setpoint(self) -> JointSetPoint:
        """The latest set-point."""
        return self.mover.setpoint if self._follower is None else self._follower.setpoint

    def reset(self, q: Array) -> None:
        """Restart at q [rad], where brakes have held the arm. The queue must be empty."""
        assert not self._queue
        self._at_rest = True
        self._leave(q)
        self.phase = _IDLE

    def _leave(self, q: Array) -> None:
        """Drop the follower, and restart the mover at q [rad], where the arm stands."""
        self._follower = self._following = None
        self.mover = self._make(q)
        self.mover.set_speed(self._speed)

    def set_speed(self, fraction: float) -> None:
        """Set the global speed, 0.01 to 1."""
        self._speed = fraction
        self.mover.set_speed(fraction)
        if self._follower is not None:
            self._follower.set_speed(fraction)

    def append(self, id_: int, plan: Plan, triggers: MotionTriggers | None = None) -> None:
        """Queue a motion with its triggers."""
        self._enter(id_)
        if triggers is not None:
            self._triggers.add(id_, triggers)
        if self._follower is not None or self._behind:
            self._behind.append((id_, plan))
        else:
            self._append(id_, plan)

    def _enter(self, id_: int) -> None:
        self._queue[id_] = None
        if self.phase is _IDLE:
            self.phase = MotionPhase.RUNNING

    def _append(self, id_: int, plan: Plan) -> None:
        if self.in_background:
            self.unplanned.append((id_, plan))
            return

        def checked(start: Array) -> Segment:
            # Checked here, not at the mover's event: it may plan the next motion before the event.
            if id_ not in self._queue:
                raise PlanError("parameter", "the motion before it failed")
            try:
                segment = plan(start)
            except PlanError as exc:
                self._fail(id_, exc)
                raise
            if segment.radius > 0.0:
                self.blending[id_] = None
            return segment

        try:
            self.mover.append(id_, checked)
        except PlanError:
            self._at_standstill()

    @property
    def time_left(self) -> float:
        """Time until the running motion is at its end [s]; 0.0 if unknown."""
        return 0.0 if self._follower is not None else self.mover.time_left

    def awaits_plan(self, id_: int) -> bool:
        """Whether a motion still waits for its plan."""
        return any(waiting[0] == id_ for waiting in self.unplanned)

    def next_plan(self) -> Planning | None:
        """Begin to plan the next motion, and give it; None if there is none."""
        if not self.unplanned:
            return None
        id_, plan = self.unplanned[0]
        self.planning = Planning(id_, self.mover.draft(id_, plan))
        return self.planning

    def take_plan(self, planning: Planning, came: Drafted | PlanError) -> None:
        """Take the result of planning a motion, unless the plan was dropped meanwhile."""
        if self.planning is not planning:
            return
        self.planning = None
        if isinstance(came, PlanError):
            self._fail(planning.id, came)
            self._at_standstill()
        elif self.mover.take(came):  # else its inputs have changed: it is planned again
            self.unplanned.popleft()
            if came.segment.radius > 0.0:
                self.blending[planning.id] = None

    def read_ahead(self, part: int, count: int) -> None:
        """Answer blocking calls as early as programs read ahead, so that motions can blend.

        A client that waits for a motion sends the next one only after the answer. So the call for a
        motion with a blend radius is answered before its end, whether another motion follows or
        not.

        Args:
            part: progress of a motion at which its call is answered [%].
            count: if `part` is 0: number of motions, the running one included, whose calls are
                answered.
        """
        if self.phase is not MotionPhase.RUNNING:
            return
        if part > 0:
            running = self.mover.active if self._follower is None else None
            if running not in self.blending or self.mover.progress < part / 100.0:
                return
            passed = [running]
        else:
            passed = [id_ for id_ in list(self._queue)[:count] if id_ in self.blending]
        for id_ in passed:
            del self.blending[id_]
            self._tasks.pass_on(id_)

    def follow(self, id_: int, following: Following) -> None:
        """Queue a motion whose targets arrive while it runs; it takes over from an equal one."""
        self._enter(id_)
        last = self._behind[-1] if self._behind else self._following
        if last is None or last[1] != following:
            self._behind.append((id_, following))
            self._go_on()
            return
        try:
            if not self._behind:
                assert self._follower is not None
                following.aim(self._follower)
                self._following = id_, following
                self._tasks.set(
                    id_,
                    TaskState.PAUSED if self.phase is MotionPhase.PAUSED else TaskState.RUNNING,
                )
            else:
                self._behind[-1] = id_, following
        except PlanError as exc:
            self._fail(id_, exc)
            return
        self._end(last[0], TaskState.INTERRUPT, "another target took over")

    def finish(self, kinds: tuple[str, ...], control: int) -> None:
        """End the motions of some kinds that follow targets, in an orderly way.

        Args:
            kinds: kinds of the motions to end.
            control: id of a task that ends when the arm stands.
        """
        for id_, waiting in tuple(self._behind):
            if isinstance(waiting, Following) and waiting.kind in kinds:
                self._behind.remove((id_, waiting))
                self._end(id_, TaskState.STOPPED, "ended before it began")
        if self._follower is None or self.following is None or self.following.kind not in kinds:
            self._tasks.set(control, TaskState.FINISHED)
            return
        self._await_rest(control)
        self._finishing = not self._behind
        self._follower.finish()

    def stop(self, state: TaskState, message: str, control: int | None = None) -> None:
        """Decelerate along the path and drop the queue.

        Args:
            state: final state of the motions, once the arm stands.
            message: the reason, for people.
            control: id of a task that ends at the same time.
        """
        self._await_rest(control)
        # A fault during a stop replaces its reason; a stop during a fault changes nothing.
        if self.phase is not MotionPhase.STOPPING or state is TaskState.ERROR:
            self._ending = (state, message)
        self.phase = MotionPhase.STOPPING
        self._behind.clear()
        self._drop_plans()
        self.mover.stop()
        if self._follower is not None:
            self._follower.stop()
        self._at_standstill()

    def curtail(self, message: str) -> None:
        """End the running motion early, and skip the motions behind it.

        A motion without an end of its own counts as finished, a motion with a path as interrupted.
        """
        for id_ in tuple(self._queue)[1:]:
            self._end(id_, TaskState.INTERRUPT, f"skipped: {message}")
        endless = self._follower is not None
        self.stop(TaskState.FINISHED if endless else TaskState.INTERRUPT, message)

    def yield_to(self, q: Array) -> None:
        """Stand at q [rad], where the arm is, instead of decelerating along the path.

        Only for motions that are being stopped: their tasks end when the arm stands.
        """
        assert self.phase is MotionPhase.STOPPING or not self._queue
        self._leave(q)

    def cut(self, message: str, q: Array) -> None:
        """End every motion with an error at once: the brakes have closed at q [rad]."""
        self._ending = (TaskState.ERROR, message)
        self._end_all()
        self.reset(q)

    def pause(self, control: int | None = None) -> None:
        """Decelerate along the path and keep the queue; the control task ends at rest."""
        self._await_rest(control)
        if self.phase is MotionPhase.RUNNING:
            self.phase = MotionPhase.PAUSING
            self.mover.pause()
            if self._follower is not None:
                self._follower.pause()
        self._at_standstill()

    def resume(self) -> None:
        """Resume after a pause."""
        if self.phase not in (MotionPhase.PAUSING, MotionPhase.PAUSED):
            return
        self.phase = MotionPhase.RUNNING
        self.mover.resume()
        if self._follower is not None:
            self._follower.resume()
        for id_ in self._queue:
            if self._tasks.state(id_) is TaskState.PAUSED:
                self._tasks.set(id_, TaskState.RUNNING)
        self._finish_waiting(TaskState.INTERRUPT)

    def tick(self, time: float, q: Array, qd: Array, *, at_rest: bool) -> JointSetPoint:
        """The set-point of the next cycle.

        Args:
            time: simulated time [s].
            q: actual joints [rad]. Shape (6,).
            qd: actual joint speeds [rad/s]. Shape (6,).
            at_rest: whether the arm itself stands, which is later than its set-points.
        """
        self._at_rest, self._time = at_rest, time
        if self._follower is not None:
            return self._tick_follower(self._follower, q, qd)
        mover = self.mover
        tick = mover.tick()
        for key, event in tick.events:
            self._note(key, event)
        if self._triggers:
            halting = self.phase not in (_IDLE, MotionPhase.RUNNING)
            self._triggers.tick(time, tick.setpoint, mover.active, mover.travel, halting=halting)
        if self._behind:
            self._go_on()
        elif mover.moving:
            return tick.setpoint  # most cycles: no task ends or pauses
        if self.phase is not _IDLE or self._waiting_for_rest:
            self._at_standstill()
        return tick.setpoint

    def _tick_follower(self, follower: TargetFollower, q: Array, qd: Array) -> JointSetPoint:
        failed = follower.failure
        setpoint = follower.tick(q, qd)
        failure = follower.failure
        if failure is not None and failure is not failed and self.phase is not MotionPhase.STOPPING:
            self._fail_follower(failure)
            if self._follower is not follower:  # the arm stood, so the motion has ended at once
                return setpoint
        if follower.ended and self.phase is not MotionPhase.STOPPING:
            assert self._following is not None
            id_, _ = self._following
            self._leave(setpoint.q)
            self._end(id_, TaskState.FINISHED)
            self._go_on()
        self._at_standstill()
        return setpoint

    def _fail_follower(self, failure: FollowError) -> None:
        """Handle a follower that cannot continue: all motions end with it when the arm stands."""
        (self.faults if failure.kind == "fault" else self.failures).append(str(failure))
        self.stop(TaskState.ERROR, str(failure))

    def _go_on(self) -> None:
        """Begin the motions behind the one that has ended, as far as possible."""
        while self._behind and self._follower is None and self.phase is MotionPhase.RUNNING:
            id_, waiting = self._behind[0]
            if not isinstance(waiting, Following):
                self._behind.popleft()
                self._append(id_, waiting)
            elif len(self._queue) == len(self._behind):  # the mover has nothing left to do
                self._behind.popleft()
                self._begin(id_, waiting)
            else:
                return

    def _begin(self, id_: int, following: Following) -> None:
        try:
            follower = following.make(self.mover.setpoint.q)
            following.aim(follower)
        except PlanError as exc:
            self._fail(id_, exc)
            return
        follower.set_speed(self._speed)
        self._follower, self._following = follower, (id_, following)
        self._tasks.set(id_, TaskState.RUNNING)

    def _note(self, id_: int, event: str) -> None:
        if id_ not in self._queue:
            return  # its task ended before the mover's event
        if event == "started":
            self._tasks.set(id_, TaskState.RUNNING)
        elif event == "finished":
            self._end(id_, TaskState.FINISHED, reached=True)
        elif event == "blended":
            self._end(id_, TaskState.INTERRUPT, "blended into the next motion", reached=True)
        # "stopped" changes nothing here: `_at_standstill` ends the task when the arm stands.

    def _at_standstill(self) -> None:
        """End or pause tasks once the arm stands."""
        if self.moving:
            return
        if not self._queue and self.phase is not MotionPhase.STOPPING:
            self.phase = _IDLE
            if self.mover.paused:  # all paused motions have ended
                self.mover.resume()
        if not self._at_rest:
            return
        if self.phase is MotionPhase.STOPPING:
            self._end_all()
        elif self.phase is _IDLE:
            self._finish_waiting()
        elif self.phase is MotionPhase.PAUSING:
            self.phase = MotionPhase.PAUSED
            for id_ in self._queue:
                if self._tasks.state(id_) is TaskState.RUNNING:
                    self._tasks.set(id_, TaskState.PAUSED)
            self._finish_waiting()
        elif self.phase is MotionPhase.PAUSED:
            self._finish_waiting()

    def _fail(self, id_: int, error: PlanError) -> None:
        """End a motion that cannot be planned, and those behind it, which begin at its end."""
        mismatch = error.code == "parameter"
        state = TaskState.PARAMETER_MISMATCH if mismatch else TaskState.ERROR
        message = str(error)
        queue = list(self._queue)
        self._end(id_, state, message)
        self.failures.append(message)
        for behind in queue[queue.index(id_) + 1 :]:
            self._end(behind, TaskState.INTERRUPT, f"the motion before it failed: {message}")
        self._behind = deque(waiting for waiting in self._behind if waiting[0] in self._queue)

    def _end_all(self) -> None:
        for id_ in list(self._queue):
            self._end(id_, *self._ending)
        if self._follower is not None:
            self._leave(self._follower.setpoint.q)
        self._behind.clear()
        self._drop_plans()
        self.phase = _IDLE
        self._finish_waiting()

    def _drop_plans(self) -> None:
        self.unplanned.clear()
        self.planning = None

    def _end(self, id_: int, state: TaskState, message: str = "", *, reached: bool = False) -> None:
        del self._queue[id_]
        self.blending.pop(id_, None)
        if self.unplanned and self.awaits_plan(id_):
            self.unplanned = deque(each for each in self.unplanned if each[0] != id_)
            if self.planning is not None and self.planning.id == id_:
                self.planning = None
        if self._triggers:
            self._triggers.end(id_, self._time, self.setpoint, reached=reached)
        self._tasks.set(id_, state, message)

    def _await_rest(self, control: int | None) -> None:
        """Let a control task, if there is one, wait until the arm stands."""
        if control is not None:
            self._tasks.set(control, TaskState.RUNNING)
            self._waiting_for_rest.append(control)

    def _finish_waiting(self, state: TaskState = TaskState.FINISHED) -> None:
        self._finishing = False
        waiting, self._waiting_for_rest = self._waiting_for_rest, []
        for id_ in waiting:
            self._tasks.set(id_, state)


class DeferredMotion(NamedTuple):
    """A motion that waits.

    Attributes:
        id: id of its task.
        name: the function that made it.
        following: how it follows its targets; None if it has a path.
        begin: queues it.
    """

    id: int
    name: str
    following: Following | None
    begin: Callable[[int], None]


class DeferredMotions:
    """The motions that wait for the end of a stop, in order.

    Args:
        tasks: the table that holds the tasks' states.

    Attributes:
        motions: all of them.
        paused: whether they pause before they begin.
    """

    def __init__(self, tasks: TaskTable) -> None:
        self._tasks = tasks
        self.motions: list[DeferredMotion] = []
        self.paused: bool = False

    def __len__(self) -> int:
        return len(self.motions)

    @property
    def last(self) -> Following | None:
        """The last one if it follows targets; None if it has a path, or if there is none."""
        return self.motions[-1].following if self.motions else None

    def add(self, motion: DeferredMotion) -> None:
        """Let a motion wait."""
        self.motions.append(motion)

    def take(self) -> list[DeferredMotion]:
        """Give all of them, which then wait no more."""
        taken, self.motions = self.motions, []
        return taken

    def end(
        self,
        state: TaskState,
        message: str,
        which: Callable[[DeferredMotion], bool] = lambda _motion: True,
    ) -> None:
        """End them before they have begun: all, or some."""
        for motion in self.take():
            if which(motion):
                self._tasks.set(motion.id, state, message)
            else:
                self.motions.append(motion)
        self.paused = self.paused and bool(self.motions)
