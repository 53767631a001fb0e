"""The program that a controller runs (脚本程序, manual 1.3.4), as state machines without a clock.

`ProgramExecution` starts, pauses, resumes and ends a program. `ProgramRun` makes its calls in turn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.models.enums import ProgramState, TaskState
from aioduco.sim.cabinet.script import BLENDING, SLEEP, Call, ProgramError, Script, prepared
from aioduco.sim.controller.tasks import MotionPhase, TaskTable
from aioduco.sim.refusal import Pending, Refusal

if TYPE_CHECKING:
    from collections.abc import Callable, Generator


# Looked up once, to save time in the cycle.
_IDLE, _RUNNING = MotionPhase.IDLE, MotionPhase.RUNNING
#: state of a running program, by whether the mode is manual
_GOES_ON = {False: ProgramState.RUNNING, True: ProgramState.TASK_RUNNING}
_HALTING = {
    MotionPhase.STOPPING: ProgramState.STOPPING,
    MotionPhase.PAUSING: ProgramState.PAUSING,
    MotionPhase.PAUSED: ProgramState.PAUSED,
}
_WENT_WELL = (TaskState.FINISHED, TaskState.INTERRUPT)


class ProgramExecution:
    """Runs at most one program, which makes its calls like a client, but within the cycle.

    Invariants: the program makes no call while it is paused, or after its end was requested; its
    task ends or becomes paused when the arm stands.
    """

    def __init__(self, tasks: TaskTable) -> None:
        self.calling: bool = False
        self._tasks = tasks
        self._current: tuple[int, ProgramRun] | None = None
        self._paused = False
        self._ending: tuple[TaskState, str] | None = None
        self._lags_until = 0.0
        self._now = 0.0
        self._passed = 0.0

    @property
    def active(self) -> bool:
        """Whether there is a program that has not ended."""
        return self._current is not None

    @property
    def running(self) -> bool:
        """Whether the program proceeds by itself: it is not paused, or is about to end."""
        return self.active and not (self._paused and self._ending is None)

    @property
    def excludes(self) -> bool:
        """Whether a motion that arrives now is refused, because it is not the program's own."""
        return self.active and not self.calling

    def state(self, motion: MotionPhase, *, manual: bool) -> ProgramState:
        """State of the program, or of motions without a program (manual 1.2)."""
        if motion is _IDLE:
            if self._current is None:
                lags = self._now < self._lags_until
                return ProgramState.STOPPING if lags else ProgramState.STOPPED
            if self._paused:
                return ProgramState.PAUSED
        elif motion is not _RUNNING:
            return _HALTING[motion]
        return _GOES_ON[manual]

    def watch(self, time: float, motion: MotionPhase, lag: float) -> None:
        """Begin a cycle; after anything that runs, the state reads stopping for `lag` [s]."""
        self._passed, self._now = time - self._now, time
        if self._current is not None or motion is not _IDLE:
            self._lags_until = time + lag

    def begin(self, id_: int, run: ProgramRun) -> None:
        """Run a program; `id_` is its task. No other program may be active."""
        assert self._current is None
        self._current, self._paused, self._ending = (id_, run), False, None
        self._tasks.set(id_, TaskState.RUNNING)

    def pause(self) -> None:
        """Make no further call until `resume`."""
        self._paused = self.active

    def resume(self) -> None:
        """Resume the calls."""
        self._paused = False
        if self._current is not None:
            self._tasks.set(self._current[0], TaskState.RUNNING)

    def end(self, state: TaskState, message: str) -> None:
        """End the program at rest; of several reasons a fault counts, or else the first one."""
        if self.active and (self._ending is None or state is TaskState.ERROR):
            self._ending = (state, message)

    def at_standstill(self, motion: MotionPhase) -> None:
        """End or pause the program's task once the arm stands."""
        if self._current is None:
            return
        id_, run = self._current
        if self._ending is not None and motion is _IDLE:
            self._current, self._paused = None, False
            run.close()
            self._tasks.set(id_, *self._ending)
        elif self._paused and motion in (MotionPhase.PAUSED, _IDLE):
            self._tasks.set(id_, TaskState.PAUSED)

    def tick(self, motion: MotionPhase) -> str:
        """Run the cycle that `watch` has begun.

        Args:
            motion: phase of the motions as a whole.

        Returns:
            Why the program cannot continue; empty if it can. The caller ends it, and its motions.
        """
        self.at_standstill(motion)
        if self._current is None or self._paused or self._ending is not None:
            return ""
        if motion not in (_IDLE, MotionPhase.RUNNING):
            return ""
        self.calling = True
        try:
            over = self._current[1].go_on(self._passed)
        except ProgramError as exc:
            return str(exc)
        finally:
            self.calling = False
        if over:
            self.end(TaskState.FINISHED, "")
            self.at_standstill(motion)
        return ""


class ProgramRun:
    """One run of a program, as a sequence of its calls.

    A call waits until its task has ended; the program cannot continue after a task that failed.
    A motion with a blend radius is answered earlier, as set_blend_ahead says: the next motion must
    be known for the two to blend. Other calls wait until no motion is under way.

    Args:
        name: name of the program, for messages.
        script: the program.
        make: makes a call of the wire; raises Pending where a client would wait.
        tasks: table of the calls' tasks.
    """

    def __init__(
        self,
        name: str,
        script: Script,
        make: Callable[[str, tuple[Any, ...]], Any],
        tasks: TaskTable,
    ) -> None:
        self._name = name
        self._calls: Generator[Call, Any, object] = (
            script() if callable(script) else (call for call in script)
        )
        self._make = make
        self._tasks = tasks
        self._answer: Any = None
        self._next: tuple[str, tuple[Any, ...]] | None = None
        self._ahead: list[tuple[str, int]] = []  # motions that were answered before their ends
        self._waiting: tuple[str, int] | None = None
        self._sleep = 0.0
        self._over = False

    def go_on(self, passed: float) -> bool:
        """Run one cycle, in which the program makes at most one call.

        Args:
            passed: time since the previous cycle [s].

        Returns:
            Whether the program is over.

        Raises:
            ProgramError: The program cannot continue.
        """
        self._sleep -= passed
        # A tolerance of half a cycle for the rounding of a sum of cycles.
        if self._sleep > 0.5 * passed:
            return False
        self._sleep = 0.0
        self._ahead = [motion for motion in self._ahead if not self._ended(*motion)]
        if self._waiting is not None:
            answer = self._tasks.answer(self._waiting[1])
            if not answer.ended:
                return False
            if not self._ended(*self._waiting):
                self._ahead.append(self._waiting)
            self._answer, self._waiting = int(answer), None
        if self._next is None and not self._over:
            self._fetch()
        if self._next is None:
            return not self._ahead
        name, values = self._next
        if self._ahead and name not in BLENDING:
            return False
        self._next = None
        self._answer = self._call(name, values)
        return False

    def close(self) -> None:
        """End the generator, if it is one."""
        self._calls.close()

    def _fetch(self) -> None:
        try:
            self._next = prepared(self._calls.send(self._answer))
        except StopIteration:
            self._over = True
        except ProgramError as exc:
            raise self._error(str(exc)) from None
        except Exception as exc:
            raise self._error(repr(exc)) from exc
        self._answer = None

    def _call(self, name: str, values: tuple[Any, ...]) -> Any:
        if name == SLEEP:
            self._sleep = values[0]
            return None
        try:
            return self._make(name, values)
        except Pending as exc:
            self._waiting = name, exc.id
            return None
        except Refusal as exc:
            raise self._error(str(exc)) from None
        except Exception as exc:
            raise self._error(f"{name}: {exc!r}") from exc

    def _ended(self, name: str, id_: int) -> bool:
        state = self._tasks.state(id_)
        if not state.ended:
            return False
        if state not in _WENT_WELL:
            task = self._tasks.get(id_)
            why = "" if task is None else task.message
            raise self._error(f"{name} ended with {state.name}: {why}")
        return True

    def _error(self, message: str) -> ProgramError:
        return ProgramError(f"program {self._name!r}: {message}")
