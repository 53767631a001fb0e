"""The program that a controller runs (脚本程序, manual 1.3.4), as a state machine without a clock.

What a program does, call by call, is a `Run`'s business. Here is what acts on it from outside:
pause, resume, stop, faults; and how it ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from aioduco.models.enums import ProgramState, TaskState
from aioduco.sim.motion import Phase

if TYPE_CHECKING:
    from aioduco.sim.tasks import TaskTable

__all__ = ["Execution", "ProgramError", "Run"]


class ProgramError(Exception):
    """A program cannot go on."""


class Run(Protocol):
    """One run of a program."""

    def go_on(self, passed: float) -> bool:
        """Go on by a cycle, in which one call is made at most.

        Args:
            passed: time since the cycle before [s].

        Returns:
            Whether the program is over.

        Raises:
            ProgramError: It cannot go on.
        """
        ...

    def close(self) -> None:
        """It will not go on."""


class Execution:
    """At most one program, which makes its calls as a client would, from within the cycle.

    Invariants: no call is made while the program is paused, or once it is to end; its task ends,
    or is told to be paused, when the arm stands.
    """

    def __init__(self, tasks: TaskTable) -> None:
        self.calling: bool = False
        self._tasks = tasks
        self._current: tuple[int, Run] | None = None
        self._paused = False
        self._ending: tuple[TaskState, str] | None = None
        self._time = 0.0
        self._lags_until = 0.0
        self._now = 0.0

    @property
    def active(self) -> bool:
        """Whether there is a program that has not ended."""
        return self._current is not None

    @property
    def running(self) -> bool:
        """Whether the program goes on by itself."""
        return self.active and not (self._paused and self._ending is None)

    @property
    def excludes(self) -> bool:
        """Whether a motion that comes now is not the program's own, and has to wait for its end."""
        return self.active and not self.calling

    def state(self, motion: Phase, *, manual: bool) -> ProgramState:
        """State of the program, and of motions without one (manual 1.2)."""
        match motion:
            case Phase.STOPPING:
                return ProgramState.STOPPING
            case Phase.PAUSING:
                return ProgramState.PAUSING
            case Phase.PAUSED:
                return ProgramState.PAUSED
            case Phase.IDLE if not self.active:
                lags = self._now < self._lags_until
                return ProgramState.STOPPING if lags else ProgramState.STOPPED
            case Phase.IDLE if self._paused:
                return ProgramState.PAUSED
        return ProgramState.TASK_RUNNING if manual else ProgramState.RUNNING

    def watch(self, time: float, motion: Phase, lag: float) -> None:
        """Take note of what runs: the state may say so for a while after its end [s]."""
        self._now = time
        if self.active or motion is not Phase.IDLE:
            self._lags_until = time + lag

    def begin(self, id_: int, run: Run) -> None:
        """Run a program; `id_` is its task. None may be active."""
        assert self._current is None
        self._current, self._paused, self._ending = (id_, run), False, None
        self._tasks.set(id_, TaskState.RUNNING)

    def pause(self) -> None:
        """Make no further call until `resume`."""
        self._paused = self.active

    def resume(self) -> None:
        """Go on with the calls."""
        self._paused = False
        if self._current is not None:
            self._tasks.set(self._current[0], TaskState.RUNNING)

    def end(self, state: TaskState, message: str) -> None:
        """End the program when the arm stands; of several reasons a fault counts, or the first."""
        if self.active and (self._ending is None or state is TaskState.ERROR):
            self._ending = (state, message)

    def settle(self, motion: Phase) -> None:
        """Draw the conclusions of the arm standing, when it does."""
        if self._current is None:
            return
        id_, run = self._current
        if self._ending is not None and motion is Phase.IDLE:
            self._current, self._paused = None, False
            run.close()
            self._tasks.set(id_, *self._ending)
        elif self._paused and motion in (Phase.PAUSED, Phase.IDLE):
            self._tasks.set(id_, TaskState.PAUSED)

    def tick(self, time: float, motion: Phase) -> str:
        """Go on by one cycle.

        Args:
            time: of the simulation [s].
            motion: what the motions as a whole are doing.

        Returns:
            Why the program cannot go on; empty if it can. Whoever asks ends it, and its motions.
        """
        passed, self._time = time - self._time, time
        self.settle(motion)
        if self._current is None or self._paused or self._ending is not None:
            return ""
        if motion not in (Phase.IDLE, Phase.RUNNING):
            return ""
        self.calling = True
        try:
            over = self._current[1].go_on(passed)
        except ProgramError as exc:
            return str(exc)
        finally:
            self.calling = False
        if over:
            self.end(TaskState.FINISHED, "")
            self.settle(motion)
        return ""
