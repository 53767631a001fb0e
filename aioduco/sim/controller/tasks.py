"""The controller's tasks by id: their states, and which have ended."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import TYPE_CHECKING

from aioduco.models.enums import TaskState

if TYPE_CHECKING:
    from collections.abc import Callable

#: ids count up from here (1063 was seen on a real controller)
FIRST_ID = 1000
_LAST_ID = 2**31 - 1


class MotionPhase(Enum):
    """Phase of the queue as a whole."""

    IDLE = auto()
    RUNNING = auto()
    PAUSING = auto()
    PAUSED = auto()
    STOPPING = auto()


@dataclass(frozen=True, slots=True)
class ControllerTask:
    """One task.

    Attributes:
        id: id that a non-blocking call returns.
        name: the function that made the task.
        state: present state; a state with `ended` is final.
        message: the reason for that state, for people.
        passed: whether a blocking call was answered before the task's end, so that the client can
            send the next motion, into which this one blends.
    """

    id: int
    name: str
    state: TaskState
    message: str = ""
    passed: bool = False


class TaskTable:
    """All tasks of a controller, without a clock and without waiting callers.

    A task that has ended never changes again. Of the ended tasks only the latest `keep` are stored:
    a client that streams makes a thousand tasks a second.
    """

    def __init__(self, keep: int = 10_000) -> None:
        self._keep = keep
        self._next = FIRST_ID
        self._running: dict[int, ControllerTask] = {}
        self._ended: dict[int, ControllerTask] = {}
        #: called with the id of each task that is made; None for nothing
        self.made: Callable[[int], object] | None = None
        #: ids that the next `take_answered` returns
        self.newly_answered: dict[int, None] = {}

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {len(self._running)} running, {len(self._ended)} ended>"

    def new(self, name: str) -> int:
        """Make a task, which is idle at first, and return its id."""
        id_ = self._next
        self._next = FIRST_ID if id_ == _LAST_ID else id_ + 1
        self._running[id_] = ControllerTask(id_, name, TaskState.IDLE)
        if self.made is not None:
            self.made(id_)
        return id_

    def ended(self, name: str, state: TaskState, message: str = "") -> int:
        """Make a task that has ended at once, and return its id."""
        id_ = self.new(name)
        self.set(id_, state, message)
        return id_

    def set(self, id_: int, state: TaskState, message: str = "") -> None:
        """Set the state of a task that has not ended.

        Raises:
            KeyError: There is no such task, or it has ended.
        """
        task = replace(self._running[id_], state=state, message=message)
        if not state.ended:
            self._running[id_] = task
            return
        del self._running[id_]
        self._ended[id_] = task
        self.newly_answered[id_] = None
        while len(self._ended) > self._keep:
            del self._ended[next(iter(self._ended))]

    def get(self, id_: int) -> ControllerTask | None:
        """A task, or None if the id was never used or is no longer stored."""
        return self._running.get(id_) or self._ended.get(id_)

    def state(self, id_: int) -> TaskState:
        """State of a task; idle, like a task not executed, if the id is unknown."""
        task = self.get(id_)
        return TaskState.IDLE if task is None else task.state

    def unfinished(self) -> tuple[ControllerTask, ...]:
        """Every task that has not ended, oldest first."""
        return tuple(self._running.values())

    def pass_on(self, id_: int) -> None:
        """Answer a blocking call for a task that has not ended, as interrupted."""
        task = self._running[id_]
        if not task.passed:
            self._running[id_] = replace(task, passed=True)
            self.newly_answered[id_] = None

    def answer(self, id_: int) -> TaskState:
        """State that answers a blocking call; a state without `ended` while the call must wait."""
        task = self.get(id_)
        if task is None:
            return TaskState.IDLE
        return TaskState.INTERRUPT if task.passed else task.state

    def take_answered(self) -> list[int]:
        """Ids of the tasks that ended or were passed on since the last call; each once."""
        answered, self.newly_answered = list(self.newly_answered), {}
        return answered
