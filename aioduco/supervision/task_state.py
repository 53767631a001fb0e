"""What is known of one task: its end, the end of a motion that goes on, and when that is expected.

No clock, no connection, no event loop. `TaskLifecycle` is fed with what was seen (`observe`) and
with what the program did (`successor_…`, `stop_sent`), and says how the task ended.

Rules:
- An end is final. What is seen afterwards changes nothing.
- State 5 (interrupted) is also how a motion ends that blended into the next one. It counts as
  blended only if the motion asked for blending, another motion was accepted after it, and no
  stop was sent in the meantime. In doubt it is an interruption, which is an error.
- While the next motion is on its way to the controller, state 5 is not judged: whether that
  motion was accepted decides.
- The end of the task of a motion that goes on (`ContinuousMotion`) is not the end of the motion.
  It has finished when it was told to end, or when the arm stands, and blended if another motion
  took over. That the controller called it finished is never overruled by the time that it took.
- A state that the manual does not list, or a task that ran and is idle again (the controller
  was restarted), has no known outcome.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from enum import Enum, auto
from typing import TYPE_CHECKING

from aioduco.models.enums import Outcome, TaskState

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = [
    "BRAKING",
    "STOOD",
    "ContinuousMotion",
    "JointEta",
    "Successor",
    "TaskLifecycle",
    "added_entries",
]

#: seconds after its time for which a motion may still slow down before it is stopped
BRAKING = 2.0
#: seconds for which the arm must have stood before a motion whose task the controller has ended
#: before its time counts as over: it may not have begun to move
STOOD = 0.25


@dataclass(frozen=True, slots=True)
class ContinuousMotion:
    """How a motion that goes on comes to its end.

    The controller may end the task of such a motion as soon as it has begun ("the function
    returns and the next is carried out", manual 1.3.5, speedj), or when it is over: the manual
    does not say. So the end of the task is not taken for the end of the motion: that is when the
    arm stands.

    Attributes:
        ending: the function of the wire that ends it.
        time: seconds after which it ends by itself; None if it does not.
        timed_here: whether this program sees to that, since the wire has no such time.
        until_told: whether it goes on even if the arm stands, as hand guiding does.
    """

    ending: str
    time: float | None = None
    timed_here: bool = False
    until_told: bool = False

    @property
    def mode(self) -> bool:
        """Whether it is a mode that a stop may leave on, and that its own function ends."""
        return self.until_told and self.ending != "stop"

    @property
    def limit(self) -> float | None:
        """Seconds after which the arm is stopped; None for no limit."""
        return None if self.time is None else self.time + BRAKING


@dataclass(frozen=True, slots=True)
class JointEta:
    """A motion of all joints together, from where the arm stands.

    Attributes:
        target: where to. Shape (6,) [rad].
        v: speed of the joint with the longest way [rad/s].
        a: its acceleration [rad/s²]; None if the controller chooses it.
    """

    target: Sequence[float]
    v: float
    a: float | None

    def seconds(self, start: Sequence[float]) -> float | None:
        """Seconds that it takes, with a trapezoidal speed; None without an acceleration.

        Args:
            start: joints at which it begins. Shape (6,) [rad].
        """
        if self.a is None:
            return None
        way = max(abs(end - begin) for begin, end in zip(start, self.target, strict=False))
        if way >= self.v * self.v / self.a:
            return way / self.v + self.v / self.a
        return 2.0 * math.sqrt(way / self.a)

    def part(self, start: Sequence[float], now: Sequence[float]) -> float:
        """Which part of the way has been gone, 0 to 1: along the straight line between the joints.

        Args:
            start: joints at which it began. Shape (6,) [rad].
            now: joints now. Shape (6,) [rad].
        """
        way = [end - begin for begin, end in zip(start, self.target, strict=False)]
        gone = [here - begin for begin, here in zip(start, now, strict=False)]
        square = sum(step * step for step in way)
        if square == 0.0:
            return 1.0  # it was there from the beginning
        along = sum(step * done for step, done in zip(way, gone, strict=True))
        return min(1.0, max(0.0, along / square))


#: Observations of "idle" in a row, after the task has run, until it counts as lost. One alone
#: may be the controller changing over from one state to the next.
IDLE_AGAIN_LIMIT = 20

_OUTCOMES = {
    TaskState.STOPPED: Outcome.STOPPED,
    TaskState.FINISHED: Outcome.FINISHED,
    TaskState.ERROR: Outcome.FAILED,
    TaskState.ILLEGAL: Outcome.ILLEGAL,
    TaskState.PARAMETER_MISMATCH: Outcome.PARAMETER_MISMATCH,
}


def added_entries(before: Sequence[str], after: Sequence[str]) -> tuple[str, ...]:
    """What was added to the controller's error list, of which the oldest entries may be gone.

    Args:
        before: the list at first.
        after: the list later.
    """
    for kept in range(min(len(before), len(after)), 0, -1):
        if tuple(before[-kept:]) == tuple(after[:kept]):
            return tuple(after[kept:])
    left = Counter(before)  # in an order of its own, then: each entry that was there counts once
    added = []
    for entry in after:
        if left[entry]:
            left[entry] -= 1
        else:
            added.append(entry)
    return tuple(added)


class Successor(Enum):
    """What is known of the motion after this one."""

    NONE = auto()
    SENT = auto()
    ACCEPTED = auto()


class TaskLifecycle:
    """What is known of one task of the controller.

    Attributes:
        state: the state that was seen last.
        outcome: how the task ended; None while it lives, or while its end cannot be judged.
        started: whether it was seen in any state other than idle.
        successor: what is known of the motion after this one.
        stop_seen: whether a stop was sent while the task lived.
        end_seen: whether the function that ends it was sent while the task lived.
        goes_on: whether the controller has ended its task, but the motion goes on.
    """

    __slots__ = (
        "_blends",
        "_continuous",
        "_idle_again",
        "end_seen",
        "goes_on",
        "outcome",
        "started",
        "state",
        "stop_seen",
        "successor",
    )

    def __init__(self, *, blends: bool = False, continuous: ContinuousMotion | None = None) -> None:
        self._blends = blends
        self._continuous = continuous
        self._idle_again = 0
        self.state: TaskState = TaskState.IDLE
        self.outcome: Outcome | None = None
        self.started: bool = False
        self.successor: Successor = Successor.NONE
        self.stop_seen: bool = False
        self.end_seen: bool = False
        self.goes_on: bool = False

    def __repr__(self) -> str:
        end = self.outcome.value if self.outcome else "live"
        return f"<TaskLifecycle {self.state.name} {end}, successor {self.successor.name.lower()}>"

    @property
    def ended(self) -> bool:
        """Whether the task has ended, or was lost sight of."""
        return self.outcome is not None

    @property
    def undecided(self) -> bool:
        """Whether the task has ended, but the next motion's acceptance decides how."""
        return self.outcome is None and self.state is TaskState.INTERRUPT

    def observe(self, state: TaskState) -> bool:
        """Take in a state that the controller reported. Returns whether anything changed."""
        if self.ended or self.undecided or self.goes_on:
            return False
        if state is TaskState.IDLE and self.started:
            self._idle_again += 1
            if self._idle_again < IDLE_AGAIN_LIMIT:
                return False
            self.outcome = Outcome.UNKNOWN
            return True
        self._idle_again = 0
        changed = state != self.state
        self.state = state
        self.started = self.started or state is not TaskState.IDLE
        if state is TaskState.INTERRUPT:
            self._judge()
        elif state is TaskState.FINISHED and self._continuous is not None:
            self.goes_on = True
            self._judge()
        elif state is TaskState.STOPPED and self.end_seen and not self.stop_seen:
            self.outcome = Outcome.FINISHED
        elif state.ended:
            self.outcome = _OUTCOMES[state]
        elif not state.known:
            self.outcome = Outcome.UNKNOWN
        return changed

    def successor_sent(self) -> None:
        """Another motion is about to be sent to the controller."""
        if not self.ended and self.successor is Successor.NONE:
            self.successor = Successor.SENT

    def successor_accepted(self) -> None:
        """The controller accepted the motion after this one."""
        if not self.ended:
            self.successor = Successor.ACCEPTED
            self._judge()

    def successor_refused(self) -> None:
        """The motion after this one was not accepted."""
        if not self.ended and self.successor is Successor.SENT:
            self.successor = Successor.NONE
            self._judge()

    def stop_sent(self) -> None:
        """A stop is about to be sent to the controller."""
        if self._continuous is not None and self._continuous.ending == "stop" and self.end_seen:
            return  # that stop is what ends it
        if not self.ended:
            self.stop_seen = True
            self._judge()

    def end_sent(self) -> None:
        """The function that ends this motion is about to be sent to the controller."""
        if not self.ended:
            self.end_seen = True
            self._judge()

    def stood(self) -> None:
        """The arm stands, and has stood for a while, or the motion's time is over."""
        if (
            self.goes_on
            and not self.ended
            and not (self._continuous and self._continuous.until_told)
        ):
            self.outcome = Outcome.FINISHED

    def lose(self) -> None:
        """The task was lost sight of."""
        if not self.ended:
            self.outcome = Outcome.UNKNOWN

    def _judge(self) -> None:
        if self.goes_on:
            if self.stop_seen:
                self.outcome = Outcome.STOPPED
            elif self.end_seen:
                self.outcome = Outcome.FINISHED
            elif self._blends and self.successor is Successor.ACCEPTED:
                self.outcome = Outcome.BLENDED
            return
        if self.state is not TaskState.INTERRUPT:
            return
        if self.end_seen and not self.stop_seen:
            self.outcome = Outcome.FINISHED
        elif not self._blends or self.stop_seen or self.successor is Successor.NONE:
            self.outcome = Outcome.INTERRUPTED
        elif self.successor is Successor.ACCEPTED:
            self.outcome = Outcome.BLENDED
