"""The state of one task: its end, the end of a continuous motion, and when its end is expected.

No clock, no connection, no event loop. `TaskLifecycle` gets the states that were seen (`observe`)
and the actions of the program (`successor_…`, `stop_sent`), and decides how the task ended.

Rules:
- An end is final. Later observations change nothing.
- A motion that blended into the next one also ends with state 5 (interrupted). It counts as
  blended only if the motion asked for blending, another motion was accepted after it, and no
  stop was sent in the meantime. In doubt it is an interruption, which is an error. If those after
  it are interrupted, too, somebody has aborted them all.
- While the next motion is on its way to the controller, state 5 is not judged: the acceptance of
  that motion decides.
- The end of the task of a continuous motion (`ContinuousMotion`) is not the end of the motion.
  The motion has finished when its end was requested, or when the arm stands; it has blended if
  another motion took over. If the controller reports that it finished, the time that it took never
  overrules that.
- A state that the manual does not list has no known outcome. Neither has a task that ran and is
  idle again, or is still idle after a stop: the controller was restarted, and may give its number
  to another task.
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


#: seconds after its time for which a motion may still slow down before it is stopped
_BRAKING = 2.0
#: seconds for which the arm must have stood before a motion counts as over, if the controller has
#: ended its task early: the arm may not have begun to move
STOOD = 0.25


@dataclass(frozen=True, slots=True)
class ContinuousMotion:
    """How a continuous motion ends.

    The controller may end the task of such a motion as soon as the motion has begun ("the function
    returns and the next is carried out", manual 1.3.5, speedj), or when it is over: the manual
    does not say. So the motion has not ended when its task ends, but when the arm stands.

    Attributes:
        ending: the function of the wire that ends it.
        time: seconds after which it ends by itself; None if it does not.
        timed_by_program: whether this program must end it then, because the wire has no such time.
        until_commanded: whether it continues even if the arm stands, as hand guiding does.
    """

    ending: str
    time: float | None = None
    timed_by_program: bool = False
    until_commanded: bool = False

    @property
    def mode(self) -> tuple[str, tuple[bool, ...]] | None:
        """For a mode that a stop may leave on: the function that ends it, and its arguments."""
        return (self.ending, (False,)) if self.until_commanded and self.ending != "stop" else None

    @property
    def limit(self) -> float | None:
        """Seconds after which the arm is stopped; None for no limit."""
        return None if self.time is None else self.time + _BRAKING


@dataclass(frozen=True, slots=True)
class JointEta:
    """A motion of all joints together, from where the arm stands.

    Attributes:
        target: target joint angles. Shape (6,) [rad].
        v: speed of the joint with the longest way [rad/s].
        a: its acceleration [rad/s²]; None if the controller chooses it.
    """

    target: Sequence[float]
    v: float
    a: float | None

    def seconds(self, start: Sequence[float]) -> float | None:
        """Return its duration [s], with a trapezoidal speed; None without an acceleration.

        Args:
            start: joints at which it begins. Shape (6,) [rad].
        """
        if self.a is None:
            return None
        way = max(abs(end - begin) for begin, end in zip(start, self.target, strict=True))
        if way >= self.v * self.v / self.a:
            return way / self.v + self.v / self.a
        return 2.0 * math.sqrt(way / self.a)

    def part(self, start: Sequence[float], now: Sequence[float]) -> float:
        """Return which part of the motion is done, 0 to 1, along the straight line in joint space.

        Args:
            start: joints at which it began. Shape (6,) [rad].
            now: joints now. Shape (6,) [rad].
        """
        way = [end - begin for begin, end in zip(start, self.target, strict=True)]
        gone = [here - begin for begin, here in zip(start, now, strict=True)]
        square = sum(step * step for step in way)
        if square == 0.0:
            return 1.0  # it began at its target
        along = sum(step * done for step, done in zip(way, gone, strict=True))
        return min(1.0, max(0.0, along / square))


#: Observations of "idle" in a row, after the task has run or was stopped, until it counts as lost.
#: A single one may come from the controller's change from one state to the next.
IDLE_AGAIN_LIMIT = 20

_OUTCOMES = {
    TaskState.STOPPED: Outcome.STOPPED,
    TaskState.FINISHED: Outcome.FINISHED,
    TaskState.ERROR: Outcome.FAILED,
    TaskState.ILLEGAL: Outcome.ILLEGAL,
    TaskState.PARAMETER_MISMATCH: Outcome.PARAMETER_MISMATCH,
}


def added_entries(before: Sequence[str], after: Sequence[str]) -> tuple[str, ...]:
    """Return the entries added to the controller's error list, which may drop its oldest entries.

    Args:
        before: the list at first.
        after: the list later.
    """
    for kept in range(min(len(before), len(after)), 0, -1):
        if tuple(before[-kept:]) == tuple(after[:kept]):
            return tuple(after[kept:])
    left = Counter(before)  # the order does not match: each earlier entry is left out once
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
    """The state of one task of the controller.

    Attributes:
        state: the last state that was seen.
        outcome: how the task ended; None while it is live, or while its end cannot be judged.
        started: whether it was seen in any state other than idle.
        successor: what is known of the motion after this one.
        stop_seen: whether a stop was sent while the task was live.
        end_seen: whether the function that ends it was sent while the task was live.
        continues_after_task: whether the controller has ended its task, but the motion continues.
    """

    __slots__ = (
        "_blends",
        "_continuous",
        "_idle_again",
        "_may_be_idle",
        "continues_after_task",
        "end_seen",
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
        self._may_be_idle = True
        self.state: TaskState = TaskState.IDLE
        self.outcome: Outcome | None = None
        self.started: bool = False
        self.successor: Successor = Successor.NONE
        self.stop_seen: bool = False
        self.end_seen: bool = False
        self.continues_after_task: bool = False

    def __repr__(self) -> str:
        end = self.outcome.value if self.outcome else "live"
        return f"<TaskLifecycle {self.state.name} {end}, successor {self.successor.name.lower()}>"

    @property
    def ended(self) -> bool:
        """Whether the task has ended, or cannot be followed any more."""
        return self.outcome is not None

    @property
    def undecided(self) -> bool:
        """Whether the task has ended, but the next motion's acceptance decides how."""
        return self.outcome is None and self.state is TaskState.INTERRUPT

    def observe(self, state: TaskState) -> bool:
        """Take in a state that the controller reported. Returns whether anything changed."""
        if self.ended or self.undecided or self.continues_after_task:
            return False
        if state is TaskState.IDLE and not self._may_be_idle:
            self._idle_again += 1
            if self._idle_again < IDLE_AGAIN_LIMIT:
                return False
            self.outcome = Outcome.UNKNOWN
            return True
        self._idle_again = 0
        changed = state != self.state
        self.state = state
        if state is not TaskState.IDLE:
            self.started, self._may_be_idle = True, False
        if state is TaskState.INTERRUPT:
            self._judge()
        elif state is TaskState.FINISHED and self._continuous is not None:
            self.continues_after_task = True
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

    def all_interrupted(self) -> None:
        """The motions after this one are interrupted, too: this one has not blended into them."""
        self._blends = False

    def stop_sent(self) -> None:
        """A stop is about to be sent to the controller."""
        if self._continuous is not None and self._continuous.ending == "stop" and self.end_seen:
            return  # that stop is the function that ends it
        if not self.ended:
            self.stop_seen = True
            self._judge()

    def stop_confirmed(self) -> None:
        """The arm stands after a stop that was requested after this motion."""
        self._may_be_idle = False

    @property
    def idle_after_stop(self) -> bool:
        """Whether a stop was confirmed while this motion had not begun: it moves nothing."""
        return not (self._may_be_idle or self.started)

    def end_sent(self) -> None:
        """The function that ends this motion is about to be sent to the controller."""
        if not self.ended:
            self.end_seen = True
            self._judge()

    def mark_standing(self) -> None:
        """Note that the arm stands, and has stood for a while or the motion's time is over."""
        if (
            self.continues_after_task
            and not self.ended
            and not (self._continuous and self._continuous.until_commanded)
        ):
            self.outcome = Outcome.FINISHED

    def mark_lost(self) -> None:
        """Note that the task cannot be followed any more."""
        if not self.ended:
            self.outcome = Outcome.UNKNOWN

    def _judge(self) -> None:
        if self.continues_after_task:
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
