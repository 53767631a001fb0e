"""Triggers along a motion (Op, manual 1.3.5): outputs and registers that are set on the way.

Whether a trigger is due is decided from how far the motion has come, cycle by cycle; there is
no clock here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from aioduco.models.enums import TaskState
from aioduco.sim.refusal import Rejected

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.rpc import Op
    from aioduco.sim.planner.mover import Travel
    from aioduco.sim.signals import Signals

__all__ = ["Along", "Trigger", "along", "at_point"]

_TIME, _DISTANCE = 1, 2


@dataclass(frozen=True, slots=True)
class Trigger:
    """One trigger.

    Attributes:
        by_time: whether `amount` is a time [s]; or else a distance [m].
        amount: from the start, or to the end of the motion; negative after its end.
        fire: sets the output.
    """

    by_time: bool
    amount: float
    fire: Callable[[], None]


@dataclass(slots=True)
class Along:
    """The triggers of one motion that have not fired.

    Attributes:
        start: counted from its start.
        end: counted to its end, or from it if negative.
        halt: fired when the motion is paused or stopped; counted to standstill, or from it.
    """

    start: Trigger | None = None
    end: Trigger | None = None
    halt: Trigger | None = None

    @property
    def late(self) -> bool:
        """Whether one is still to fire after the end of the motion."""
        return self.end is not None and self.end.amount < 0.0

    def travel(self, travel: Travel) -> None:
        """Fire what is due on the way."""
        start, end = self.start, self.end
        if start is not None:
            done = travel.elapsed if start.by_time else travel.distance
            if done >= start.amount - 1e-9:
                self.start = None
                start.fire()
        if end is not None and end.amount >= 0.0:
            left = travel.remaining if end.by_time else travel.left
            if left <= end.amount + 1e-9:
                self.end = None
                end.fire()

    def ended(self) -> None:
        """The motion has reached its end: fire what was to come on the way."""
        if self.start is not None:
            self.start.fire()
            self.start = None
        if self.end is not None and self.end.amount >= 0.0:
            self.end.fire()
            self.end = None

    def beyond(self, time: float, distance: float) -> None:
        """Fire what is due so long and so far after the end."""
        end = self.end
        if end is not None and (time if end.by_time else distance) >= -end.amount - 1e-9:
            self.end = None
            end.fire()

    def halting(self, left: float, since: float) -> None:
        """Fire what is due at a pause or stop.

        Args:
            left: time until the arm stands [s].
            since: time that it has stood [s].
        """
        halt = self.halt
        if halt is None:
            return
        due = left <= halt.amount + 1e-9 if halt.amount >= 0.0 else since >= -halt.amount - 1e-9
        if due:
            self.halt = None
            halt.fire()


def along(op: Op, signals: Signals, *, distance: bool) -> Along | None:
    """Give the triggers of a motion; None if it has none.

    Args:
        op: as it came.
        signals: whose outputs are set.
        distance: whether the motion has a length in metres.

    Raises:
        Rejected: a trigger is of no kind, or its target does not exist.
    """
    start = _trigger(
        op.time_or_dist_1, op.trig_time_1, op.trig_dist_1,
        _target(op.time_or_dist_1, op.trig_io_1, op.trig_value_1, op.trig_event_1, signals),
        distance,
    )  # fmt: skip
    end = _trigger(
        op.time_or_dist_2, op.trig_time_2, op.trig_dist_2,
        _target(op.time_or_dist_2, op.trig_io_2, op.trig_value_2, op.trig_event_2, signals),
        distance,
    )  # fmt: skip
    halt = _trigger(
        op.time_or_dist_3, op.trig_time_3, op.trig_dist_3,
        _target(op.time_or_dist_3, op.trig_io_3, op.trig_value_3, op.trig_event_3, signals),
        distance=False,
    )  # fmt: skip
    return Along(start, end, halt) if start or end or halt else None


def at_point(op: Op, signals: Signals) -> Callable[[], None] | None:
    """What is to happen when a point is reached; None for nothing.

    At a point there is neither a way nor a time: all triggers that are on fire at once.
    """
    found = along(op, signals, distance=True)
    if found is None:
        return None
    fires = [t.fire for t in (found.start, found.end, found.halt) if t is not None]

    def fire() -> None:
        for each in fires:
            each()

    return fire


def _trigger(
    kind: int, time: float, metres: float, fire: Callable[[], None] | None, distance: bool
) -> Trigger | None:
    if fire is None:
        return None
    if kind == _TIME:
        return Trigger(True, _finite(time) / 1000.0, fire)
    # The manual: a trigger by distance is without effect on a motion in joint space.
    return Trigger(False, _finite(metres), fire) if distance else None


def _target(
    kind: int, index: int, value: bool, event: str, signals: Signals
) -> Callable[[], None] | None:
    if kind == 0:
        return None
    if kind not in (_TIME, _DISTANCE):
        raise _wrong(f"a trigger is of kind {kind}, but must be 0, 1 or 2")
    if event:
        raise _wrong(f"there is no event {event!r}: none is defined in this controller")
    if 1 <= index <= 16:
        bank, num = signals.standard_out, index
    elif 101 <= index <= 164:
        bank, num = signals.bool_out, index - 100
    else:
        raise _wrong(f"a trigger's target is {index}, but must be 1 to 16 or 101 to 127")

    def fire() -> None:
        bank[num] = value

    return fire


def _finite(value: float) -> float:
    if not abs(value) < float("inf"):
        raise _wrong(f"a trigger's time or distance is {value}")
    return value


def _wrong(message: str) -> Rejected:
    return Rejected(TaskState.PARAMETER_MISMATCH, message)
