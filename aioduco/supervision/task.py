"""A task of the controller that a program can await: its state, its end, its errors."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any, Literal, Protocol

import anyio

from aioduco._process.copying import Uncopied
from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import (
    TaskError,
    TaskFailed,
    TaskIllegal,
    TaskInterrupted,
    TaskOverdue,
    TaskParameterMismatch,
    TaskStopped,
    TaskUnknown,
)
from aioduco.models.enums import Outcome, TaskState
from aioduco.supervision.permits import Permits, asked_at_call
from aioduco.supervision.task_state import ContinuousMotion, JointEta, TaskLifecycle, added_entries

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Generator, Sequence

    from aioduco.errors import HeartbeatLost
    from aioduco.models.controller_clock import Clock
    from aioduco.supervision.task_command import Command


_log = BackgroundLogger(__name__)

#: seconds without a failure like it after which one of which nothing has asked is the first again
_ROW = 10.0

#: what happens to a motion when its await is cancelled
OnCancel = Literal["stop", "pause", "detach"]


class TaskControl(Protocol):
    """Interface of the stop coordinator that a task and its follower use.

    It is an interface because the coordinator has the follower, which has the tasks.
    """

    #: whether a motion may be running that is not followed
    unfollowed_motion: bool
    #: whether the connections are closed, so that nothing can be sent any more
    closed: bool
    #: permits to move the arm
    permits: Permits
    #: number of stops that were requested when the last one that was confirmed began
    confirmed: int

    @property
    def stops(self) -> int:
        """Number of requested stops; rises before a stop is sent."""
        ...

    def check_loop(self, what: str) -> None:
        """Check that this is the robot's event loop, before `what` is done on it."""
        ...

    async def stop(self) -> None:
        """As `halt`, to its end even if cancelled; then wait until the motions have ended."""
        ...

    async def pause(self) -> bool:
        """Pause all tasks; return whether anything is paused."""
        ...

    async def resume(self) -> bool:
        """Resume all tasks; return whether anything was paused."""
        ...

    async def paused(self) -> bool:
        """Whether something is paused; True also if the controller does not say."""
        ...

    async def end(self, name: str, *, answered: Callable[[], None] | None = None) -> None:
        """End continuous motions by the function `name` of the wire; wait until the arm stands.

        `answered` is called before that, when the function was answered or has failed.
        """
        ...

    async def halt(self) -> None:
        """Stop the arm, and wait until it stands."""
        ...

    async def standstill(self, stops_before: int | None = None) -> None:
        """Wait until the arm stands, without a stop; `StopCoordinator.standstill` describes it."""
        ...

    async def lapsed(self) -> HeartbeatLost:
        """Wait until the controller has stopped the arm by itself, because no heartbeat came."""
        ...

    async def joints(self) -> Sequence[float]:
        """Read where the arm is: the angles of its joints [rad]."""
        ...

    async def cancelled_while_waiting(self, task: Task) -> None:
        """Do what the `on_cancel` of a task says after its await was cancelled, then return."""
        ...


class Task(Uncopied):
    """A task that the controller accepted. `await task` gives its outcome.

    Awaiting it raises a typed error unless it finished or blended. Cancelling that await stops
    the arm (see `on_cancel`); `wait()` only observes, and can be cancelled without effect.
    The controller stops, pauses and resumes all its tasks together, never one alone: so do
    `cancel`, `pause` and `resume`.

    Attributes:
        id: the controller's number of the task.
        name: the function that started it.
        motion: whether it moves the arm.
        on_cancel: what happens when its await is cancelled.
        accepted_at: when the controller's acceptance was received [s of `time.monotonic`].
        started_at: when it was first seen in a state other than idle; None before.
        ended_at: when its end was noticed; None before.
        since: when it was accepted, by the robot's clock, the controller's time [s]; equal to
            `accepted_at` on a real arm.
        deadline: when the arm is stopped if it has not ended, by the robot's clock; None for never.
    """

    def __init__(
        self,
        control: TaskControl,
        command: Command,
        task_id: int,
        *,
        clock: Clock,
        accepted_at: float,
        stops_before: int,
        on_cancel: OnCancel = "detach",
        deadline: float | None = None,
        errors_before: Sequence[str] = (),
    ) -> None:
        self._control = control
        self.life: TaskLifecycle = TaskLifecycle(
            blends=command.blends, continuous=command.continuous
        )
        self.id = task_id
        self.name: str = command.name
        self.motion: bool = command.motion
        self.on_cancel: OnCancel = on_cancel
        self._clock = clock
        self.accepted_at = accepted_at
        self.since: float = clock.now()
        self._began = self._over = self.since
        self.started_at: float | None = None
        self.ended_at: float | None = None
        self.deadline: float | None = None if deadline is None else self.since + deadline
        #: number of stops that had been requested when it was sent
        self.stops_before = stops_before
        #: how it ends, if it is a continuous motion
        self.continuous: ContinuousMotion | None = command.continuous
        #: since when the arm has been seen to stand although the motion continues, by the clock;
        #: None if it moves
        self.stood_since: float | None = None
        #: its target and speed, if they are known for the joints
        self.eta: JointEta | None = command.eta
        self._errors_before = tuple(errors_before)
        #: whether its start position has been asked for
        self.placed = False
        #: when its end is expected, by the clock; None if unknown
        self.expected_end: float | None = None
        self._release_clock: Callable[[], None] | None = None
        self._start: Sequence[float] | None = None
        #: why it could not be followed any more, or was not stopped in time
        self.fault: BaseException | None = None
        #: why this program stopped the arm, if no caller requested it
        self.stopped_by: BaseException | None = None
        #: whether the arm was stopped because the deadline passed
        self.overdue = False
        self._errors: tuple[str, ...] = ()
        self._ended = anyio.Event()
        self._changed = anyio.Event()
        self._states = [self.life.state]
        #: of the robot's failed motions of which nothing has asked how they ended, by function and
        #: outcome: how many there were in a row, and when the last was discarded
        self.unasked: dict[tuple[str, Outcome], tuple[int, float]] = {}
        #: whether its outcome was asked for
        self._asked = False

    def __del__(self) -> None:
        untold = not getattr(self, "_asked", True) and self.motion
        if untold and (outcome := self.life.outcome) in _FAILURES:
            self._log_unasked(outcome)

    def _log_unasked(self, outcome: Outcome) -> None:
        """Log that it failed; of many in a row the first, the second, the fourth and so on."""
        now, kind = time.monotonic(), (self.name, outcome)
        before, last = self.unasked.get(kind, (0, -math.inf))
        number = before + 1 if now - last <= _ROW else 1
        self.unasked[kind] = number, now
        if number & (number - 1):
            return  # no power of two
        _log.warning(
            "%s; nothing has asked how it ended: wait for it, or read its outcome%s",
            task_error(self.name, self.id, outcome, self._errors),
            f" (number {number} in a row; the next that is logged is {2 * number})"
            if number > 1
            else "",
        )

    def __repr__(self) -> str:
        end = f" {self.life.outcome.value}" if self.life.outcome and self.done else ""
        return f"<Task {self.id} {self.name} {self.life.state.name}{end}>"

    @property
    def _permits(self) -> Permits:
        return self._control.permits

    @property
    def state(self) -> TaskState:
        """The last state that was seen."""
        self._asked = self._asked or self.done
        return self.life.state

    @property
    def outcome(self) -> Outcome | None:
        """How the task ended; None while it is live."""
        self._asked = self._asked or self.done
        return self.life.outcome if self.done else None

    @property
    def done(self) -> bool:
        """Whether the task has ended, or cannot be followed any more."""
        return self._ended.is_set()

    @property
    def errors(self) -> tuple[str, ...]:
        """Entries that the controller's error list has gained when a failed task ended.

        They came since the tasks before it had ended: no motion waits for a read of the list.
        """
        return self._errors

    @property
    def duration(self) -> float:
        """Seconds from its start (its acceptance, until it is seen to start) to its end, or now.

        This is the controller's time, by the robot's clock.
        """
        return (self._clock.now() if self.ended_at is None else self._over) - self._began

    @property
    def remaining(self) -> float | None:
        """Seconds until its end is expected, 0 once that time has passed; None if it is unknown.

        It is known for `movej2` with an acceleration, if the arm stood when it was accepted. It
        assumes the speed slider at 100 %, and no pauses. It is the controller's time, by the
        robot's clock.
        """
        if self.done:
            return 0.0
        end = self.expected_end
        return None if end is None else max(0.0, end - self._clock.now())

    async def progress(self) -> float | None:
        """Read where the arm is, and return which part of the motion is done.

            while not task.done:
                print(await task.progress())
                await anyio.sleep(0.1)

        Returns:
            0 to 1; None if it is unknown: it is known for `movej2` if the arm stood when it was
            accepted, and for every motion that has finished (1).

        Raises:
            ConnectionLost: the controller does not answer.
            StaleState: it answers fewer than six angles, or some that are not finite.
        """
        if self.done:
            return 1.0 if self.outcome is Outcome.FINISHED else None
        if self.eta is None or self._start is None:
            return None
        return self.eta.part(self._start, await self._control.joints())

    def result(self) -> Outcome:
        """Return the outcome of a task that is done.

        Raises:
            TaskError: it is not done, or it neither finished nor blended: one of the subclasses.
        """
        outcome = self.outcome
        if outcome is None:
            raise TaskError(self.name, self.id, "has not ended yet: wait for it")
        if outcome.success and self.fault is None:
            return outcome
        if outcome.success:
            outcome = Outcome.UNKNOWN  # its end was requested, but the arm was not seen to stand
        if self.overdue and outcome is Outcome.STOPPED:
            raise TaskOverdue(
                self.name, self.id, "did not end by its deadline: the arm was stopped"
            )
        cause = self.fault or self.stopped_by
        raise task_error(self.name, self.id, outcome, self._errors, self.stopped_by) from cause

    async def wait(self) -> Outcome:
        """Wait for the end and return the outcome, whatever it is.

        Cancelling this wait has no effect on the arm.

        Raises:
            WrongLoop: this is not the robot's event loop.
        """
        if not self.done:
            self._control.check_loop("wait")
        await self._ended.wait()
        self._asked = True
        assert self.life.outcome is not None
        return self.life.outcome

    def __await__(self) -> Generator[Any, Any, Outcome]:
        return self._follow().__await__()

    async def _follow(self) -> Outcome:
        if not self.done:
            # here and not below, because a refused await must not stop the arm
            self._control.check_loop(f"await {self.name}")
        try:
            await self.wait()
        except BaseException:  # a cancellation, or an interrupt at this point
            await self._control.cancelled_while_waiting(self)
            raise
        return self.result()

    async def __aiter__(self) -> AsyncIterator[TaskState]:
        """Yield each state once, from the first one until the end.

        Leaving the loop has no effect on the arm.
        """
        seen = 0
        if not self.done:
            self._control.check_loop("states")
        while True:
            while seen < len(self._states):
                state = self._states[seen]
                seen += 1
                yield state
            if self.done:
                self._asked = True
                return
            await self._changed.wait()

    async def cancel(self) -> Outcome:
        """Stop the arm, all its tasks included, and wait until it stands.

        Returns:
            The outcome of this task: stopped, unless it had ended before.

        Raises:
            StopUnconfirmed: it is not known that the arm stands.
        """
        if not self.done:
            self._control.check_loop("cancel")
            await self._control.stop()
        return await self.wait()

    async def end(self) -> Outcome:
        """End a continuous motion by its own function, and wait until the arm stands.

        Other tasks continue. A motion that ends by itself is cancelled. A motion that cannot be
        ended this way is stopped.

        Returns:
            The outcome of this task.

        Raises:
            TaskError: it had ended without finishing, or could only be stopped.
            StopUnconfirmed: it is not known that the arm stands.
        """
        if not self.done:
            if self.continuous is None:
                return await self.cancel()
            self._control.check_loop("end")
            await self._control.end(self.continuous.ending)
            await self.wait()
        return self.result()

    async def pause(self) -> None:
        """Pause the arm, all its tasks included."""
        if not self.done:
            self._control.check_loop("pause")
            await self._control.pause()

    @asked_at_call
    async def resume(self) -> None:
        """Resume all paused tasks."""
        if not self.done:
            self._control.check_loop("resume")
            await self._control.resume()

    async def _on_wait_cancelled(self) -> None:
        """Do what a cancelled await of this task does to the arm: see `on_cancel`."""
        await self._control.cancelled_while_waiting(self)

    # The following methods are only for the supervision.

    def _begins_at(self, joints: Sequence[float]) -> None:
        """Set the joints at which the arm stood when the controller accepted the task."""
        assert self.eta is not None
        self._start = tuple(joints)
        seconds = self.eta.seconds(joints)
        self.expected_end = None if seconds is None else self.since + seconds

    @property
    def time_over(self) -> bool:
        """Whether the time of a continuous motion is over."""
        if self.continuous is None or self.continuous.time is None:
            return False
        return self._clock.now() >= self.since + self.continuous.time

    def hold_at_end(self) -> None:
        """Hold the clock at the end of the motion's time, until the motion is ended."""
        assert self.continuous is not None
        assert self.continuous.time is not None
        self._release_clock = self._clock.hold(self.since + self.continuous.time)

    def release_clock(self) -> None:
        """Release the clock."""
        if self._release_clock is not None:
            self._release_clock()
            self._release_clock = None

    def _observed(self, state: TaskState, now: float) -> bool:
        """Take in a state from the controller. Returns whether it differs from the last one."""
        changed = self.life.observe(state) and self._states[-1] != self.life.state
        if self.started_at is None and self.life.started:
            self.started_at, self._began = now, self._clock.now()
        if changed:
            self._states.append(self.life.state)
            self._wake()
        return changed

    def _finish(self, errors: Sequence[str], now: float) -> None:
        """Note that the task has ended for good, and wake its waiters."""
        if not self.done:
            self._errors = added_entries(self._errors_before, errors)
            self.ended_at, self._over = now, self._clock.now()
            self.release_clock()
            self._ended.set()
            self._wake()

    def _wake(self) -> None:
        changed, self._changed = self._changed, anyio.Event()
        changed.set()


_MEANING: dict[Outcome, tuple[type[TaskError], str]] = {
    Outcome.STOPPED: (TaskStopped, "was stopped"),
    Outcome.INTERRUPTED: (
        TaskInterrupted,
        "was interrupted before its end, and did not blend into another motion",
    ),
    Outcome.FAILED: (TaskFailed, "ended with an error"),
    Outcome.ILLEGAL: (
        TaskIllegal,
        (
            "is not allowed in the robot's present state: is it enabled, without an emergency "
            "stop or a running program (see robot.bring_up()), and are tool and work object known "
            "to it?"
        ),
    ),
    Outcome.PARAMETER_MISMATCH: (TaskParameterMismatch, "has a parameter that it does not take"),
    Outcome.UNKNOWN: (
        TaskUnknown,
        (
            "was lost sight of: it may have ended, or may be running. Look at the robot's state "
            "before you send anything"
        ),
    ),
}

#: outcomes by which the controller says that it did not carry out a motion
_FAILURES = {Outcome.FAILED, Outcome.ILLEGAL, Outcome.PARAMETER_MISMATCH}


def task_error(
    name: str,
    task_id: int | None,
    outcome: Outcome,
    errors: Sequence[str] = (),
    stopped_by: BaseException | None = None,
) -> TaskError:
    """Return the typed error for an outcome other than success."""
    kind, message = _MEANING[outcome]
    if stopped_by is not None and outcome in (Outcome.STOPPED, Outcome.INTERRUPTED):
        kind, message = TaskStopped, f"was stopped: {stopped_by}"
    return kind(name, task_id, message, errors)
