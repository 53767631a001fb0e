"""Triggers along a motion (Op, manual 1.3.5): outputs and registers that are set during it.

In each cycle the progress of the motion decides whether a trigger is due; there is no clock here.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.refusal import Forgiving, mismatch

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.rpc import Op
    from aioduco.models.rotation import Array
    from aioduco.sim.cabinet.signals import Signals
    from aioduco.sim.planner.mover import Travel
    from aioduco.sim.planner.path import JointSetPoint


_TIME, _DISTANCE = 1, 2
#: fields of each of the three triggers of an Op; their names end with the trigger's number
_FIELDS = ("time_or_dist", "trig_time", "trig_dist", "trig_io", "trig_value", "trig_event")
#: kinds that public programs send although no manual names them
_UNNAMED = (3, 4)
#: offset of the numbers of bool registers; targets above 127 do not fit into the wire's byte
_REGISTERS = 100
#: a point is reached within the first distance; within the second it is passed at the nearest place
_THERE, _NEAR = 1e-4, 0.02  # [m]


@dataclass(frozen=True, slots=True)
class PathTrigger:
    """One trigger.

    Attributes:
        by_time: whether `amount` is a time [s]; otherwise it is a distance [m].
        amount: from the start, or to the end of the motion; negative after its end.
        fire: sets the output.
    """

    by_time: bool
    amount: float
    fire: Callable[[], None]


@dataclass(slots=True)
class MotionTriggers:
    """The triggers of one motion that have not fired.

    Attributes:
        start: trigger that counts from the start of the motion.
        end: trigger that counts to the end of the motion, or from it if negative.
        halt: trigger of a pause or stop, which counts to standstill, or from it if negative.
        tip: gives the position of the tool for joints [rad].
        points: positions of the flange [m] and the action at each, in order.
        flange: gives the position of the flange for joints [rad].
    """

    tip: Callable[[Array], Array]
    start: PathTrigger | None = None
    end: PathTrigger | None = None
    halt: PathTrigger | None = None
    points: deque[tuple[Array, Callable[[], None]]] = field(default_factory=deque)
    flange: Callable[[Array], Array] | None = None
    _distance: float = math.inf  # from the next point

    def travel(self, travel: Travel) -> None:
        """Fire the triggers that are due during the motion."""
        start, end = self.start, self.end
        if start is not None:
            done = travel.elapsed if start.by_time else travel.distance
            if done >= start.amount - 1e-9:
                self.start = None
                start.fire()
        if end is not None and end.amount >= 0.0:
            by_time = end.by_time
            if travel.ends_within(end.amount) if by_time else travel.left <= end.amount + 1e-9:
                self.end = None
                end.fire()

    def pass_points(self, q: Array) -> None:
        """Fire at a point that is passed: where the flange is nearest to it."""
        if not self.points or self.flange is None:
            return
        distance = float(np.linalg.norm(self.flange(q) - self.points[0][0]))
        if distance <= _THERE or self._distance < min(distance, _NEAR):
            self._distance = math.inf
            self.points.popleft()[1]()
        else:
            self._distance = distance

    def ended(self) -> None:
        """Fire the remaining triggers of a motion that has reached its end, but no later ones."""
        while self.points:
            self.points.popleft()[1]()
        if self.start is not None:
            self.start.fire()
            self.start = None
        if self.end is not None and self.end.amount >= 0.0:
            self.end.fire()
            self.end = None

    def beyond(self, time: float, distance: float) -> None:
        """Fire the trigger that is due at this time [s] or distance [m] after the end."""
        end = self.end
        if end is not None and (time if end.by_time else distance) >= -end.amount - 1e-9:
            self.end = None
            end.fire()

    def halting(self, left: float, since: float) -> None:
        """Fire the trigger that is due at a pause or stop.

        Args:
            left: time until the arm stands [s].
            since: time for which it has stood [s].
        """
        halt = self.halt
        if halt is None:
            return
        due = left <= halt.amount + 1e-9 if halt.amount >= 0.0 else since >= -halt.amount - 1e-9
        if due:
            self.halt = None
            halt.fire()


class Triggers:
    """The triggers of all motions, by the ids of their tasks."""

    def __init__(self) -> None:
        self._ahead: dict[int, MotionTriggers] = {}
        self._behind: list[_Behind] = []
        self._stood: float | None = None  # since when the arm has stood in a pause or after a stop
        self._halted: int | None = None  # the motion that is paused, or was stopped

    def __bool__(self) -> bool:
        return bool(self._ahead) or bool(self._behind)

    def add(self, id_: int, triggers: MotionTriggers) -> None:
        """Add the triggers of a queued motion."""
        self._ahead[id_] = triggers

    def end(self, id_: int, time: float, setpoint: JointSetPoint, *, reached: bool) -> None:
        """Handle the end of a motion, which has reached its end or not."""
        triggers = self._ahead.pop(id_, None)
        if triggers is None:
            return
        since = time
        if reached:
            triggers.ended()
            triggers.halt = None
        else:
            triggers.start = triggers.end = None
            since = time if self._stood is None else self._stood
        if triggers.end is not None or triggers.halt is not None:
            self._behind.append(_Behind(triggers, since, triggers.tip(setpoint.q)))

    def tick(
        self,
        time: float,
        setpoint: JointSetPoint,
        active: int | None,
        travel: Travel | None,
        *,
        halting: bool,
    ) -> None:
        """Fire the triggers that are due.

        Args:
            time: simulated time [s].
            setpoint: the latest set-point.
            active: id of the running motion.
            travel: its progress.
            halting: whether it is paused, or being stopped.
        """
        speed, change = np.abs(setpoint.qd).max(), np.abs(setpoint.qdd).max()
        if not halting or speed > 0.0:
            self._stood = None
        elif self._stood is None:
            self._stood = time
        # A stop drops the motion when the set-points stand; its task ends when the arm does.
        self._halted = self._halted if halting and active is None else active
        triggers = None if self._halted is None else self._ahead.get(self._halted)
        if triggers is not None:
            if travel is not None:
                triggers.travel(travel)
            triggers.pass_points(setpoint.q)
            if halting:
                left = float(speed / change) if change > 0.0 else 0.0
                triggers.halting(left, 0.0 if self._stood is None else time - self._stood)
        for behind in tuple(self._behind):
            behind.tick(time, setpoint)
            if behind.triggers.end is None and behind.triggers.halt is None:
                self._behind.remove(behind)


@dataclass(slots=True, eq=False)
class _Behind:
    """The triggers of a motion that has ended.

    Attributes:
        triggers: the remaining triggers.
        since: time at which the motion ended, or its set-points stood after a stop [s].
        at: position of the tool [m]. Shape (3,).
        way: distance that the tool has moved since the end [m].
    """

    triggers: MotionTriggers
    since: float
    at: Array
    way: float = 0.0

    def tick(self, time: float, setpoint: JointSetPoint) -> None:
        at = self.triggers.tip(setpoint.q)
        self.way += float(np.linalg.norm(at - self.at))
        self.at = at
        self.triggers.beyond(time - self.since, self.way)
        self.triggers.halting(0.0, time - self.since)


def motion_triggers(
    op: Op,
    signals: Signals,
    tip: Callable[[Array], Array],
    forgiving: Forgiving,
    *,
    distance: bool,
) -> MotionTriggers | None:
    """Give the triggers of a motion; None if it has none.

    Args:
        op: the triggers as received.
        signals: signals whose outputs are set.
        tip: gives the position of the tool for joints [rad].
        forgiving: decides whether kinds of triggers that no manual names are ignored.
        distance: whether the motion has a length in metres.

    Raises:
        Rejected: the kind of a trigger is unknown, or its target does not exist.
    """
    made = []
    for number in (1, 2, 3):
        fields = (getattr(op, f"{name}_{number}") for name in _FIELDS)
        kind, time, metres, index, value, event = fields
        fire = _target(kind, index, value, event, signals, forgiving)
        made.append(_trigger(kind, time, metres, fire, distance and number < 3))
    start, end, halt = made
    return MotionTriggers(tip, start, end, halt) if start or end or halt else None


def point_trigger(op: Op, signals: Signals, forgiving: Forgiving) -> Callable[[], None] | None:
    """Give the action for a point that is reached; None for nothing.

    A point has neither a length nor a duration, so all its active triggers fire at once.
    """
    found = motion_triggers(op, signals, lambda q: q, forgiving, distance=True)
    if found is None:
        return None
    fires = [t.fire for t in (found.start, found.end, found.halt) if t is not None]

    def fire() -> None:
        for each in fires:
            each()

    return fire


def _trigger(
    kind: int, time: float, metres: float, fire: Callable[[], None] | None, distance: bool
) -> PathTrigger | None:
    if fire is None:
        return None
    if kind == _TIME:
        return PathTrigger(True, _finite(time) / 1000.0, fire)
    # The manual: a trigger by distance has no effect on a motion in joint space.
    return PathTrigger(False, _finite(metres), fire) if distance else None


def _target(
    kind: int, index: int, value: bool, event: str, signals: Signals, forgiving: Forgiving
) -> Callable[[], None] | None:
    if kind == 0:
        return None
    if kind in _UNNAMED:
        forgiving.forgive(
            "kind of a trigger", f"a trigger is of kind {kind}, but must be 0, 1 or 2"
        )
        return None
    if kind not in (_TIME, _DISTANCE):
        raise mismatch(f"a trigger is of kind {kind}, but must be 0, 1 or 2")
    if event:  # an event has priority over an output (manual 1.3.5)
        if event not in signals.events:
            raise mismatch(f"there is no event {event!r}; there are: {', '.join(signals.events)}")
        return signals.events[event]
    if 1 <= index <= len(signals.standard_out):
        return partial(signals.standard_out.__setitem__, index, value)
    if 1 <= index - _REGISTERS <= len(signals.bool_out):
        return partial(signals.bool_out.__setitem__, index - _REGISTERS, value)
    raise mismatch(f"a trigger's target is {index}, but must be 1 to 16 or 101 to 127")


def _finite(value: float) -> float:
    if not abs(value) < float("inf"):
        raise mismatch(f"a trigger's time or distance is {value}")
    return value
