"""The mover: one set-point per controller cycle, along a queue of motions.

It has no clock and no thread. Each `tick` is one cycle; everything between is a plain call. A long
plan need not delay the cycles: `draft` gives its inputs, which never change, `Draft.work` plans the
motion on any thread, and `take` puts it into the queue.

A `TimeLaw` gives the highest speed of the arm at each place of the running motion's path. Most of
the time the arm follows the law ("tracking"), at the global speed: time then runs slower by that
factor. To pause, to stop and to change the global speed, the arm leaves the law and accelerates or
decelerates along the path ("ramping"). It stays below the law until it stands or meets the law
again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np

from aioduco.sim.planner.blending import Corners, Entry, alone, joined, keeps
from aioduco.sim.planner.path import JointSetPoint, PlanError
from aioduco.sim.planner.segments import Segment, carry
from aioduco.sim.planner.slices import yield_now
from aioduco.sim.planner.timing import TimeLaw, fastest

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array

MotionEventKind: TypeAlias = Literal["started", "finished", "blended", "stopped"]


_SOON = 1e-9  # tolerance for the rounding of a time [s]
_MOST = 300_000  # largest number of pieces of all paths in the queue, to bound their memory


class MotionEvent(NamedTuple):
    """An event of a motion in a cycle.

    Attributes:
        key: the motion's key.
        kind: "started"; "finished": it stands at its end; "blended": the next motion took over
            before its end; "stopped": it stands before its end, or was dropped from the queue.
    """

    key: int
    kind: MotionEventKind


class Travel(NamedTuple):
    """Progress of the active motion, from the blend into it to the blend out of it.

    Attributes:
        elapsed: time for which it has moved [s].
        distance: distance that it has moved, in the unit of its path: metres of the tool centre
            point, or radians of the joint that turns furthest.
        left: distance that is left.
        law: its time law.
        speed: global speed, 0.01 to 1.
    """

    elapsed: float
    distance: float
    left: float
    law: TimeLaw
    speed: float

    def ends_within(self, time: float) -> bool:
        """Whether it ends within a time [s]; computes the law only as far as this needs."""
        return self.law.over(self.law.time(self.distance) + (time + _SOON) * self.speed)


class Drafted(NamedTuple):
    """A motion that has been planned.

    Attributes:
        draft: the inputs of the plan.
        segment: the motion.
        alone: its entry, if it begins at rest.
        joined: the queue with it, if the motion before it blends into it.
    """

    draft: Draft
    segment: Segment
    alone: Entry
    joined: tuple[Entry, ...] | None


class Draft(NamedTuple):
    """Inputs of a motion's plan: values that do not change while it is planned.

    Attributes:
        key: name of the motion in events.
        plan: makes the motion for the joints [rad] at which it begins. Shape (6,).
        start: joints at which it begins [rad]. Shape (6,).
        queue: the motions before it, the running one first.
        axes: positions at which those leave external axes, by number.
        rest: data of motions that have ended, to be freed in slices: for long motions this takes
            long.
        corners: how corners are cut.
    """

    key: int
    plan: Callable[[Array], Segment]
    start: Array
    queue: tuple[Entry, ...]
    axes: dict[int, float]
    rest: list[object]
    corners: Corners = Corners()

    def work(self) -> Drafted:
        """Plan the motion, its blend with the one before it included.

        Raises:
            PlanError: from `plan`, or the motion cannot follow those before it.
        """
        while self.rest:
            self.rest.pop()
            yield_now()
        segment = self.plan(self.start.copy())
        yield_now()
        if np.abs(segment.q_start - self.start).max() > 1e-9:
            raise PlanError("parameter", "the motion does not begin where the one before it ends")
        if segment.axes is not None:
            segment = carry(segment, self.axes)
        pieces = sum(len(path.bounds) for entry in self.queue if (path := entry.path) is not None)
        if segment.path is not None and pieces + len(segment.path.bounds) > _MOST:
            raise PlanError("limits", "the motions that wait are too long to be known at once")
        new = alone(self.key, segment)
        return Drafted(self, segment, new, joined(self.queue, new, self.corners))


class MoverTick(NamedTuple):
    """The outcome of a cycle: the set-point, and the events in order."""

    setpoint: JointSetPoint
    events: tuple[MotionEvent, ...] = ()


class Mover:
    """Moves an arm's set-point along a queue of motions.

    Args:
        arm: the arm.
        q: joints at the start [rad]. Shape (6,).
        cycle: time between two ticks [s].
        settling: gives the time for which a motion stands at its end before it is finished [s].
        corners: how corners are cut where motions blend.
    """

    def __init__(
        self,
        arm: Arm,
        q: Array,
        cycle: float = 0.001,
        *,
        settling: Callable[[], float] = lambda: 0.0,
        corners: Corners = Corners(),  # noqa: B008 - a value
    ) -> None:
        self._arm = arm
        self._corners = corners
        self.cycle: float = cycle
        self._settling = settling
        self._stood = 0.0  # time for which the active motion has stood at its end
        self._speed = 1.0
        #: whether a pause is in force; the arm stands once `moving` is false, too
        self.paused: bool = False
        self._events: list[MotionEvent] = []
        self._queue: tuple[Entry, ...] = ()
        #: the latest set-point
        self.setpoint: JointSetPoint = JointSetPoint.at_rest(q)
        self._stopping = False
        self._began = False  # whether the active motion has started
        self._law: TimeLaw | None = None  # of the active motion, once it has started
        self._tracking = False
        self._time = 0.0  # on the law, while tracking
        self._s = 0.0  # distance along the active motion's path
        self._v = 0.0  # ds/dt
        self._elapsed = 0.0  # time that the active motion has moved
        self._law_piece = self._path_piece = self._axes_piece = 0
        #: set-points of external axes by number [rad or m], for those that were moved
        self.axes: dict[int, float] = {}
        self._rest: list[object] = []  # data of motions that have ended, until the next draft

    @property
    def active(self) -> int | None:
        """The key of the motion that is running or next to run; None when there is none."""
        return self._queue[0].key if self._queue else None

    @property
    def keys(self) -> tuple[int, ...]:
        """The keys of all motions that have not ended, the active one first."""
        return tuple(entry.key for entry in self._queue)

    @property
    def moving(self) -> bool:
        """Whether the set-point moves, or is about to move."""
        return self._v > 0.0 or (not self.paused and bool(self._queue))

    @property
    def progress(self) -> float:
        """Progress of the active motion along its path, 0 to 1."""
        if not self._queue:
            return 1.0
        length = self._queue[0].length
        return min(self._s / length, 1.0) if length > 0.0 else 1.0

    @property
    def time_left(self) -> float:
        """Time until the active motion is at its end [s]; 0.0 before its start and in a ramp."""
        law = self._law
        if law is None or not self._tracking or self.paused or self._stopping:
            return 0.0
        return (law.duration - self._time) / self._speed

    @property
    def travel(self) -> Travel | None:
        """Progress of the active motion; None before it has started."""
        if self._law is None:
            return None
        return Travel(self._elapsed, self._s, self._law.end - self._s, self._law, self._speed)

    def append(self, key: int, plan: Callable[[Array], Segment]) -> None:
        """Put a motion at the end of the queue.

        Args:
            key: name of the motion in events.
            plan: makes the motion for the joints [rad], shape (6,), at which it begins: the end
                of the motion before it, or where the arm stands. Called at once.

        Raises:
            PlanError: from `plan`; the queue is unchanged.
        """
        self.take(self.draft(key, plan).work())

    def draft(self, key: int, plan: Callable[[Array], Segment]) -> Draft:
        """Give the inputs for planning a motion at the end of the queue; arguments as of `append`.

        Raises:
            PlanError: the arm is stopping.
        """
        if self._stopping:
            raise PlanError("parameter", "the arm is stopping")
        rest, self._rest = self._rest, []
        axes = {**self.axes, **self._left_by_queue()}
        return Draft(key, plan, self._end, self._queue, axes, rest, self._corners)

    def take(self, drafted: Drafted) -> bool:
        """Put a drafted motion at the end of the queue.

        Cycles may have run since the draft. Motions that have ended meanwhile are no longer before
        it. If the arm has come too far for the blend into it, the motion before it stops at its
        end.

        Returns:
            Whether it was put there. It was not if it was drafted behind a motion that is not the
            last one, or for another start: it must be drafted again.
        """
        queue, before = self._queue, drafted.draft.queue
        last = queue[-1] is before[-1] if queue and before else not queue
        if self._stopping or not last or not np.array_equal(self._end, drafted.draft.start):
            return False
        if not queue or drafted.joined is None:
            self._queue = (*queue, drafted.alone)
            return True
        blending = drafted.joined[len(before) - len(queue) :]
        speed = self._law.speed(self._s) if self._law is not None else 0.0
        if blending[0] is queue[0]:
            self._queue = blending
        elif keeps(blending[0], self._s, speed):
            self._queue = blending
            if self._law is not None:
                self._follow(speed, self._s)
        else:
            self._queue = (*queue, drafted.alone)
        return True

    @property
    def _end(self) -> Array:
        """The joints at which the queue ends [rad], where the next motion begins. Shape (6,)."""
        return self._queue[-1].segment.q_end if self._queue else self.setpoint.q

    def pause(self) -> None:
        """Decelerate along the path, at the motion's own acceleration, and stand."""
        self.paused = True
        self._tracking = False

    def resume(self) -> None:
        """Resume along the path after a pause."""
        self.paused = False

    def stop(self) -> None:
        """Decelerate along the path as fast as the drives can, stand, and drop the queue."""
        if self._queue and self._v > 0.0:
            self._stopping = True
            self._tracking = False
        else:
            self._drop()

    def set_speed(self, fraction: float) -> None:
        """Set the global speed, 0.01 to 1: at a speed of 0.5 motions take twice as long."""
        if not 0.01 <= fraction <= 1.0:
            raise ValueError(f"global speed {fraction} is not 0.01 to 1")
        if fraction != self._speed:
            self._speed = fraction
            self._tracking = False

    def tick(self) -> MoverTick:
        """Run one cycle."""
        if self._queue and not (self.paused and self._v == 0.0):
            self._advance()
        if not self._events:
            return MoverTick(self.setpoint)
        events, self._events = tuple(self._events), []
        return MoverTick(self.setpoint, events)

    def _drop(self) -> None:
        self._events += [MotionEvent(entry.key, "stopped") for entry in self._queue]
        self._rest += [*self._queue, self._law]
        self._queue = ()
        self._law = None
        self._began = self._stopping = self.paused = False
        self._s = self._v = 0.0
        self.setpoint = JointSetPoint.at_rest(self.setpoint.q)

    def _advance(self) -> None:
        if not self._began:
            self._begin()
        if self._law is None:
            self._finish()
        elif self._tracking or self._at_rest_by_law():
            self._track(self._time + self.cycle * self._speed)
        else:
            self._ramp(self._law)

    def _begin(self) -> None:
        entry = self._queue[0]
        self._began = True
        self._elapsed = self._stood = 0.0
        self._events.append(MotionEvent(entry.key, "started"))
        if entry.path is not None:
            self._follow(0.0, 0.0)
            self._tracking = True

    def _follow(self, speed: float, s: float) -> None:
        entry = self._queue[0]
        assert entry.limits is not None
        self._law = fastest(entry.limits, entry.back, s, speed)
        self._s, self._time = s, 0.0
        self._law_piece = self._path_piece = self._axes_piece = 0

    def _at_rest_by_law(self) -> bool:
        # Where the law itself stands, there is no speed to ramp up to; a wait continues.
        assert self._law is not None
        if self._v == 0.0 and self._law.speed(self._s) == 0.0:
            if self._law.at(self._time)[1] != self._s:
                self._time = self._law.time(self._s)
            self._tracking = True
        return self._tracking

    def _track(self, time: float) -> None:
        """Follow the law up to a given time of the law."""
        law = self._law
        assert law is not None
        if law.over(time):
            end = law.end_speed
            if self._settles(law):
                return
            if self._finish():
                self._enter_blend(end, end * self._speed)
                self._track(time - law.duration)
            return
        self._time = time
        self._law_piece, s, v, a = law.at(time, self._law_piece)
        self._set(s, v * self._speed, a * self._speed**2)

    def _ramp(self, law: TimeLaw) -> None:
        """Accelerate or decelerate towards the law, or to rest."""
        piece = law.piece(self._s, self._law_piece)
        braking = self.paused or self._stopping
        down = braking or self._v > self._speed * law.speed(self._s, piece)
        limits = self._queue[0].limits
        assert limits is not None
        gentle, hard = limits.at(self._s, self._v)
        limit = hard if self._stopping else gentle
        if down and self._v <= limit * self.cycle:
            v, s = 0.0, self._s + 0.5 * self._v**2 / limit
        else:
            v = self._v + (-limit if down else limit) * self.cycle
            s = self._s + 0.5 * (self._v + v) * self.cycle
        wait = law.first_wait(self._s, s)
        if wait is not None:
            # It stands there before it goes on, also if it is beyond it by rounding.
            (s, self._time), v, piece = wait, 0.0, 0
        elif s >= law.end:
            end, beyond = law.end_speed, s - law.end
            if self._settles(law):
                return
            if self._finish():
                ratio = self._enter_blend(end, v)
                self._set(beyond * ratio, self._v, 0.0)
            return
        self._law_piece = piece
        lawful = law.speed(s, piece)
        highest = lawful * (1.0 if braking else self._speed)
        if not braking and (v <= highest if down else v >= highest):
            v, self._tracking = highest, True
            self._time = law.time(s) if wait is None else self._time
        # If the law decelerates faster than the motion's own limit, the arm follows the law.
        v = min(v, lawful)
        self._set(s, v, (v - self._v) / self.cycle if v > 0.0 else 0.0)
        if v == 0.0 and self._stopping:
            self._drop()

    def _enter_blend(self, law_speed: float, v: float) -> float:
        """Take over the speeds of the previous motion, and give the ratio of the units."""
        corner = self._queue[0].blend
        assert corner is not None
        self._events.append(MotionEvent(self._queue[0].key, "started"))
        self._began = True
        self._elapsed = self._stood = 0.0
        self._follow(law_speed * corner.ratio, 0.0)
        self._v = v * corner.ratio
        return corner.ratio

    def _settles(self, law: TimeLaw) -> bool:
        """Stand for a cycle at the end of the active motion if it still settles; return whether."""
        if law.end_speed > 0.0 or self._stopping or self._stood >= self._settling() - 1e-9:
            return False
        self._stood += self.cycle
        self._time, self._tracking = law.duration, True
        self._set(law.end, 0.0, 0.0)
        return True

    def _finish(self) -> bool:
        """End the active motion, and tell whether the next one takes over by a blend."""
        entry, *rest = self._queue
        self._queue = tuple(rest)
        self._events.append(MotionEvent(entry.key, "blended" if entry.blends else "finished"))
        self._rest += [entry, self._law]
        self._law = None
        if entry.blends:
            return True
        self._began = False
        self._s = self._v = 0.0
        self.setpoint = JointSetPoint.at_rest(entry.segment.q_end)
        self.axes.update(_ends(entry))
        if self._stopping:
            self._drop()
        return False

    def _left_by_queue(self) -> dict[int, float]:
        """Give the positions at which the motions in the queue leave external axes."""
        return {number: end for entry in self._queue for number, end in _ends(entry).items()}

    def _set(self, s: float, v: float, a: float) -> None:
        entry = self._queue[0]
        path, axes = entry.path, entry.axes
        assert path is not None
        self._s, self._v = s, v
        self._path_piece = path.piece(s, self._path_piece)
        self._elapsed += self.cycle
        state = path.state(self._path_piece, s, v, a)
        self.setpoint = JointSetPoint(state[0], state[1], state[2])
        if axes is not None and entry.segment.axes is not None:
            self._axes_piece = axes.piece(s, self._axes_piece)
            at: list[float] = axes.state(self._axes_piece, s, v, a)[0].tolist()
            self.axes.update(zip(entry.segment.axes.numbers, at, strict=True))


def _ends(entry: Entry) -> dict[int, float]:
    """Give the positions at which a motion leaves external axes."""
    move = entry.segment.axes
    return {} if move is None else dict(zip(move.numbers, move.end.tolist(), strict=True))
