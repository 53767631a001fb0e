"""Whether another caller has stopped the arm, by the numbers of the set-points' tasks."""

from __future__ import annotations

from typing import Final

from aioduco.models.enums import TaskState
from aioduco.streaming.shared.words import Reason
from aioduco.streaming.worker.watch import ended

_BRAKE_LIMIT: Final = 5.0  # s within which an arm that was told to stop stands
_MOST: Final = 8  # tasks that are polled in one tick
#: as many equal rises, one after the other, are the controller's own: two in two ticks may be
#: another caller's task and its stop
_SURE: Final = 20


class TaskNumbers:
    """The tasks of a stream's set-points that another caller may have stopped.

    The set-point after such a stop moves the arm again. The controller numbers all tasks, a stop
    included (manual 1.3.3): where the number rises by more than one, another caller has made a task
    in between. The one before it is in question until its end is known. A controller whose numbers
    always rise by more is known by that.

    No I/O, and no clock: times are given.
    """

    def __init__(self) -> None:
        self._last = 0
        #: the least rise, and how often it came one after the other
        self._least = 0
        self._times = 0
        #: the tasks in question, and until when each is polled [s]
        self._in_question: dict[int, float] = {}

    @property
    def in_question(self) -> tuple[int, ...]:
        """The tasks to ask the controller about, the first one first."""
        return (*self._in_question,)

    def sent(self, task: int, now: float) -> None:
        """Note that a set-point was sent.

        Args:
            task: the number of its task; not one that says that the set-point was refused.
            now: the time [s].
        """
        before, self._last = self._last, task
        if not before:
            return
        rise = task - before
        usual = rise in (0, 1) or (rise == self._least and self._times >= _SURE)
        if rise > 0 and (self._times < _SURE or rise < self._least):
            self._times = self._times + 1 if rise == self._least else 1
            self._least = rise
        if not usual and len(self._in_question) < _MOST:
            self._in_question[before] = now + _BRAKE_LIMIT

    def polled(self, task: int, state: int, now: float) -> str:
        """Note the state of a task in question.

        Args:
            task: its number.
            state: its state.
            now: the time [s].

        Returns:
            What says that another caller stopped it; empty if nothing does, or not yet.
        """
        brakes = state in (TaskState.RUNNING, TaskState.PAUSED)  # stopped once the arm stands
        if brakes and now < self._in_question[task]:
            return ""
        del self._in_question[task]
        reason, text = ended(task, state)
        if reason is not Reason.STOPPED:
            return ""
        self._in_question.clear()
        return text
