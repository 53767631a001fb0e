"""Power and enable: the robot's state (manual 1.2) and the timed changes between its values."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from aioduco.models.enums import RobotState, TaskState

if TYPE_CHECKING:
    from aioduco.sim.controller.tasks import TaskTable

_OFF, _DISABLED, _ENABLED = RobotState.POWER_OFF, RobotState.DISABLE, RobotState.ENABLE


@dataclass(frozen=True, slots=True)
class PowerChange:
    """A change from one state of the robot to another.

    Attributes:
        sources: states in which the change can begin.
        there: states in which nothing is left to do.
        steps: duration of each step [s], and the state at its end.
        safe: whether the change is possible only while no safety stop holds.
        stands: whether the arm must stand before the first step.
    """

    sources: frozenset[RobotState]
    there: frozenset[RobotState]
    steps: tuple[tuple[float, RobotState], ...]
    safe: bool = False
    stands: bool = False


_BOOT = ((0.5, RobotState.START), (0.5, RobotState.INITIALIZE), (0.5, _OFF))

#: The manual names the states, not how long a change takes: these times are assumptions.
CHANGES = {
    "power_on": PowerChange(
        frozenset({_OFF}), frozenset({_DISABLED, _ENABLED}), ((0.5, _DISABLED),), safe=True
    ),
    "enable": PowerChange(
        frozenset({_DISABLED}), frozenset({_ENABLED}), ((0.3, _ENABLED),), safe=True, stands=True
    ),
    "disable": PowerChange(
        frozenset({_ENABLED}), frozenset({_DISABLED}), ((0.1, _DISABLED),), stands=True
    ),
    "power_off": PowerChange(
        frozenset({_DISABLED, _ENABLED}), frozenset({_OFF}), ((0.2, _OFF),), stands=True
    ),
    "shutdown": PowerChange(
        frozenset({_OFF, _DISABLED, _ENABLED}), frozenset(), ((0.5, _OFF),), stands=True
    ),
    "restart": PowerChange(
        frozenset({_OFF, _DISABLED, _ENABLED}), frozenset(), ((0.2, _OFF), *_BOOT), stands=True
    ),
}

PowerEvent = tuple[Literal["begun", "ended"], str]


class PowerControl:
    """State of the robot, without a clock: `time` is an argument.

    Changes run one after the other, in the order of the requests. When its turn comes, each is
    checked for being legal.
    """

    def __init__(self, tasks: TaskTable) -> None:
        self.state: RobotState = _OFF
        #: durations of changes of one step that are known of an arm, by name [s]
        self.times: dict[str, float] = {}
        self._tasks = tasks
        self._waiting: deque[tuple[int, str]] = deque()
        self._current: tuple[int, str] | None = None
        self._steps: deque[tuple[float, RobotState]] = deque()
        self._due: float | None = None

    @property
    def busy(self) -> bool:
        """Whether a change is under way or waits."""
        return self._current is not None or bool(self._waiting)

    @property
    def changing(self) -> str | None:
        """The change under way."""
        return None if self._current is None else self._current[1]

    def request(self, name: str) -> int:
        """Request a change, and return the id of its task."""
        id_ = self._tasks.new(name)
        self._waiting.append((id_, name))
        return id_

    def tick(self, time: float, *, safe: bool, standing: bool) -> list[PowerEvent]:
        """Continue the change under way, or begin the next; return what began and what ended.

        Args:
            time: simulated time [s].
            safe: whether no safety stop holds.
            standing: whether the arm stands.
        """
        events: list[PowerEvent] = []
        while self._current is not None or self._waiting:
            if self._current is None:
                id_, name = self._waiting.popleft()
                if not self._begin(id_, name, safe):
                    continue
                events.append(("begun", name))
                if CHANGES[name].stands:
                    break  # the controller must stop the arm before `standing` counts
            if self._go_on(time, standing):
                events.append(("ended", self._end()))
            break  # the end of a change affects the conditions of the next one
        return events

    def drop_waiting(self, state: TaskState, message: str) -> None:
        """End the waiting changes towards power; those away from power remain."""
        waiting, self._waiting = self._waiting, deque()
        for id_, name in waiting:
            if CHANGES[name].safe:
                self._tasks.set(id_, state, message)
            else:
                self._waiting.append((id_, name))

    def cut(self, message: str) -> None:
        """Cut the drives' power at once; a change that was to end with power fails."""
        if self._current is not None and CHANGES[self._current[1]].steps[-1][1] is not _OFF:
            self._tasks.set(self._current[0], TaskState.ERROR, message)
            self._current = None
        self.drop_waiting(TaskState.ERROR, message)
        if self.state in (_DISABLED, _ENABLED):
            self.state = _OFF

    def _begin(self, id_: int, name: str, safe: bool) -> bool:
        change = CHANGES[name]
        if self.state not in change.sources and self.state not in change.there:
            self._tasks.set(id_, TaskState.ILLEGAL, f"{name} in state {self.state.name}")
        elif change.safe and not safe:
            self._tasks.set(id_, TaskState.ILLEGAL, f"{name} during a safety stop")
        else:
            self._current = id_, name
            # Already there: the change runs without steps, so that it still has its effects.
            steps = change.steps
            if name in self.times and len(steps) == 1:
                steps = ((self.times[name], steps[0][1]),)
            self._steps = deque(steps if self.state in change.sources else ())
            self._due = None
            self._tasks.set(id_, TaskState.RUNNING)
            return True
        return False

    def _go_on(self, time: float, standing: bool) -> bool:
        """Take the steps that are due; return whether none is left."""
        assert self._current is not None
        change = CHANGES[self._current[1]]
        while self._steps:
            duration, state = self._steps[0]
            if self._due is None:
                if not standing and change.stands:
                    return False
                self._due = time + duration
            # Rather a cycle early than a cycle late, whatever the rounding of a sum of cycles.
            if time < self._due - 1e-9:
                return False
            self.state = state
            self._steps.popleft()
            self._due = self._due + self._steps[0][0] if self._steps else None
        return True

    def _end(self) -> str:
        assert self._current is not None
        id_, name = self._current
        self._current = None
        self._tasks.set(id_, TaskState.FINISHED)
        return name
