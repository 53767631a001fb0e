"""Follows the tasks of a robot to their ends: polls their states, and stops motions that go wrong.

The controller does not report when a task ends, so it is polled. A poll costs a round trip, so a
task is polled often when something is likely to happen and seldom when not:

- just after acceptance, when it starts, is refused, or was short;
- near its expected end and shortly after, if an end can be expected;
- in between, after half of the time that it has run, or has still to run, whichever is
  shorter, but often enough that an unexpected end is noticed soon.

While the feed runs, a task far from its end is asked for in the batch of a sample; it is polled if
none comes.

Due times are absolute: a late poll does not delay the later ones. Missed polls are skipped.

Guarantees:
- Each live task is polled in its turn, at the rate of `interval`.
- A task that could not be polled for `LOST_AFTER` seconds ends with an unknown outcome. Nothing is
  assumed about it.
- If another program stops a motion, those that this program has sent after it are stopped, too,
  and all permits end.
- The next motion of a path is not sent while another program's task may brake the arm: see
  `others_ended`.
- A motion that cannot be followed any more, or is overdue, is stopped. Its await ends when the arm
  stands, when no stop was accepted in time, or when the controller must have stopped the arm by
  itself, because no heartbeat reaches it.
- Whatever happens to the follower, every task ends: no await of a task hangs.
"""

from __future__ import annotations

import contextlib
import logging
import time
from functools import partial
from typing import TYPE_CHECKING, Any

import anyio

from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import ControllerError, DucoError, StopUnconfirmed, TaskStopped, TaskUnknown
from aioduco.models.enums import Outcome, TaskState
from aioduco.models.trace import tell
from aioduco.supervision.concurrency import GRID, Alarm, BackgroundTasks, on_grid, run_to_completion
from aioduco.supervision.gate import PermitEnding
from aioduco.supervision.task import Task, TaskControl
from aioduco.supervision.task_command import Command
from aioduco.supervision.task_state import STOOD, Successor, added_entries

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from aioduco._wire.codec import ReadResult
    from aioduco._wire.lane import Question, WireLane
    from aioduco.models.controller_clock import Clock

_log = BackgroundLogger(__name__)

#: seconds to wait until a stopped task is seen to have ended
END_LIMIT = 1.0
#: seconds between polls while something is likely to happen
FAST = 0.002
#: seconds until the first poll of a task whose end is far, which may fail at once
EARLY = 0.01
#: seconds between polls of a task whose end cannot be expected; half of it is the median delay
STEADY = 0.005
#: of one that runs for long, as a part of its time
PROMPT = 0.002
#: maximum seconds between polls, far from an expected end
SLOW = 0.05
#: seconds by which a sample may be late that brings the state of a task
_LATER = 0.01
#: time after its expected end for which a task is polled at the fast rate [s]
OVERDUE = 0.1
#: part of the time until its expected end that passes without a poll; of the time since its
#: acceptance, as much as that passes again
SHARE = 0.5


def interval(age: float, remaining: float | None = None) -> float:
    """Return the seconds until the next poll of a task.

    Args:
        age: seconds since the controller accepted the task.
        remaining: seconds until its expected end, negative after it; None if unknown.
    """
    if remaining is None or remaining < -OVERDUE:
        return min(max(age, FAST), max(STEADY, min(age * PROMPT, SLOW)))
    return min(max(min(max(age, EARLY), remaining * SHARE), FAST), SLOW)


def next_poll(due: float, now: float, every: float) -> float:
    """Return when a task that was polled is due again: `every` after its last due time.

    If that time has passed, it is due `every` after now. A long interval may be shorter by up to
    `GRID`, if that time has not passed: polls of other robots are then due at the same moments, and
    share one iteration of the loop.

    Args:
        due: when it was due.
        now: the time.
        every: its interval [s].
    """
    due += every
    if due <= now:
        due = now + every
    if every >= 4 * GRID and (shared := on_grid(due)) > now:
        return shared
    return due


#: seconds for one answer about a task
ASK_LIMIT = 0.5
#: seconds without an answer about a task after which its outcome is unknown
LOST_AFTER = 2.0

#: tasks of others after a motion that are looked at, at most
_OTHERS = 8

_UNDER_WAY = (TaskState.RUNNING, TaskState.PAUSED)
#: outcomes to which the controller's error list belongs
_WITH_ERRORS = {Outcome.FAILED, Outcome.ILLEGAL, Outcome.PARAMETER_MISMATCH}


class TaskFollower:
    """Follows tasks to their ends.

    Args:
        lane: lane of the polls.
        arm: stops the arm.
        background: runs coroutines that no caller waits for.
        clock: the controller's time.

    Attributes:
        polls: number of polls.
        observers: called with each task that was accepted, changed its state or ended, on the event
            loop; the package's own, which must not raise or wait.
    """

    def __init__(
        self, lane: WireLane, arm: TaskControl, background: BackgroundTasks, clock: Clock
    ) -> None:
        self._lane = lane
        self._clock = clock
        self._arm = arm
        self._background = background
        #: when each task is polled next; the earliest is next. Under overload all due times have
        #: passed, and the earliest is that of the task that was not polled for longest
        self._due: dict[Task, float] = {}
        #: tasks that are being ended; set when the call that ends one was answered, or has failed
        self._endings: dict[Task, anyio.Event] = {}
        self._alarm = Alarm()
        #: when the controller last said something of each live task
        self._seen: dict[Task, float] = {}
        self._closed = False
        #: the controller's error list while no task ran; None while it is unknown
        self._error_list: tuple[str, ...] | None = None
        #: whether it is to be read again, since the last task has ended
        self._list_due = False
        #: number of commands that were told it
        self._told = 0
        #: whether the task that changed its state last is paused
        self._paused = False
        #: of failed motions of which nothing has asked how they ended: see `Task.unasked`
        self._unasked: dict[tuple[str, Outcome], tuple[int, float]] = {}
        self.polls: int = 0
        self.observers: list[Callable[[Task], object]] = []

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The live tasks, in the order of their acceptance."""
        return tuple(self._seen)

    @property
    def motions(self) -> tuple[Task, ...]:
        """Of these, the motions."""
        return tuple(task for task in self.tasks if task.motion)

    def follow(self, task: Task) -> None:
        """Follow a task from now on."""
        task.unasked = self._unasked
        if self._closed:
            now = time.monotonic()
            task.life.mark_lost()
            if task.motion:
                # it was sent, and is not followed: it is stopped before it ends
                self._stop_lost(task, lambda: task._finish((), now))
            else:
                task._finish((), now)
            return
        for other in self._namesakes(task):
            # the controller was restarted, and has forgotten it
            other.life.mark_lost()
            if other in self._due:
                self._due[other] = task.accepted_at
        self._seen[task] = task.accepted_at
        self._due[task] = task.accepted_at
        self._alarm.ring()
        tell(self.observers, task)

    def _namesakes(self, task: Task) -> list[Task]:
        """The other live tasks with its number; what is no more than a state is no number."""
        return [each for each in self._seen if each.id == task.id > max(TaskState) and each != task]

    async def error_list(self) -> tuple[str, ...]:
        """Return the controller's error list before a command, whose errors are not in it yet.

        It was read when the last task had ended, so that no command waits for it, save the first.
        """
        if self._error_list is None and not self._seen:
            await self._read_error_list()
        self._told += 1
        return self._error_list or ()

    async def new_errors(self, before: Sequence[str]) -> tuple[str, ...]:
        """Return what a command that has failed, and is no task, added to the error list."""
        found = await self._read("get_last_error")
        if found is None:
            return ()
        self.have_told(found)
        return added_entries(before, found)

    def have_told(self, errors: Sequence[str]) -> None:
        """Note the controller's error list: what it has is not what a later command adds."""
        self._error_list = tuple(errors)

    async def _read_error_list(self) -> None:
        self._list_due = False
        told = self._told
        # The list only explains errors: without it, the controller still moves its arm. And if a
        # command was sent meanwhile, it may hold the errors of that.
        found = await self._read("get_last_error")
        if found is not None and told == self._told:
            self._error_list = tuple(found)

    async def _read(self, name: str) -> Any:
        """Call a function that reads, and return its answer; None if there is none."""
        try:
            return await self._lane.call(name, (), ASK_LIMIT)
        except DucoError:
            return None

    async def complete(
        self, name: str, task_id: int, timeout: float, stops: int | None = None
    ) -> Outcome:
        """Follow a task that moves nothing to its end; `completed` describes it.

        A controller may answer with the state in which it ended, in place of an id.
        """
        task = Task(
            self._arm,
            Command(name, (), motion=False),
            task_id,
            clock=self._clock,
            accepted_at=time.monotonic(),
            stops_before=self._arm.stops if stops is None else stops,
        )
        if task_id <= max(TaskState):
            state = TaskState(task_id)
            task.life.observe(state if state.ended else TaskState.FINISHED)
            task._finish((), task.accepted_at)
        else:
            self.follow(task)
        return await self.completed(task, timeout)

    async def completed(self, task: Task, timeout: float) -> Outcome:
        """Wait for the end of a task that moves nothing.

        Raises:
            TaskUnknown: it has not ended within `timeout` seconds.
            TaskError: it did not succeed.
        """
        with anyio.move_on_after(timeout):
            await task.wait()
        if not task.done:
            raise TaskUnknown(
                task.name, task.id, f"has not ended after {timeout:g} s; it may be running on"
            )
        return task.result()

    async def others_ended(self, last: Task) -> None:
        """Wait until the tasks that others have made since a motion have ended, or the motion has.

        Another program's abort ends motions with the state of blending, once the arm stands. Its
        task, whose number is behind that of the motion (manual 1.3.3), runs until then. So nothing
        is taken for an abort here: what would follow the motion only waits for such a task.

        Args:
            last: the motion that the next one is to follow.

        Raises:
            TaskError: the motion has ended, and did not succeed.
        """
        own = {task.id for task in self.tasks}
        found = False
        try:
            for number in range(last.id + 1, last.id + 1 + _OTHERS):
                if number in own:
                    continue
                while (state := await self._state(number)) in _UNDER_WAY and not last.done:
                    found = True
                    await anyio.sleep(STEADY)
                if not state.ended:
                    break  # there is no such task
                found = True
            if found and (await self._state(last.id)).ended:
                await last.wait()
        except DucoError:
            return  # a lost connection is handled elsewhere
        if last.done:
            last.result()

    async def require_unpaused(
        self, ending: str, motions: Sequence[Task], *, mode: bool = False
    ) -> None:
        """Check that none of the motions that a function ends is paused.

        Args:
            ending: the function of the wire.
            motions: the motions.
            mode: whether it ends a mode, which has no task.

        Raises:
            TaskStopped: one is, and must be stopped: once it is over, the program goes on.
        """
        live = [task for task in motions if not task.done]
        asked = mode or any(task.life.continues_after_task for task in live)
        paused = asked and await self._arm.paused()
        for task in live:
            if task.state is TaskState.PAUSED:
                paused = paused or await self._state(task.id) is TaskState.PAUSED
        if paused:
            raise TaskStopped(
                ending, None, "found the motion paused, as far as is known, and stopped the arm"
            )

    async def motions_ended(self) -> None:
        """Poll the motions at once, and wait until they have ended, for a second at most."""
        now = time.monotonic()
        for task in self.motions:
            if task in self._due:  # else it is being ended
                self._due[task] = now
        self._alarm.ring()
        with anyio.move_on_after(END_LIMIT):
            for task in self.motions:
                await task.wait()

    async def run(self) -> None:
        """Follow tasks until this is cancelled."""
        try:
            while True:
                task = min(self._due, key=self._due.__getitem__, default=None)
                if task is None:
                    await (self._read_error_list() if self._list_due else self._alarm.wait())
                elif self._due[task] > time.monotonic():
                    await self._alarm.wait(self._due[task])
                else:
                    await self._ask(task)
        finally:
            try:
                if not (self._arm.closed or self._lane.owner_loop.in_forked_child):
                    await self._stop_unfollowed()
            finally:
                self._close()

    async def _ask(self, task: Task) -> None:
        due = self._due[task]
        if task.eta is not None and not task.placed:
            await self._expect(task)
        answered = True
        self._note_stop(task)
        if task.life.continues_after_task:
            answered = await self._ask_whether_it_stands(task)
        elif not task.life.undecided:
            try:
                state = await self._state(task.id)
                if state is TaskState.INTERRUPT and await self._aborted(task):
                    task.life.all_interrupted()
            except ControllerError:
                # The controller answered that it does not have the state: the connection is not
                # lost, but the task cannot be followed any more.
                self._answered(task, None)
            except DucoError:
                answered = False
            else:
                self._answered(task, state)
        now = time.monotonic()
        if not answered and now - self._seen[task] > LOST_AFTER:
            task.life.mark_lost()
        if task.life.ended:
            await self._end(task)
            return
        self._note_time(task, self._clock.now())
        if self._due[task] == due:  # else it is to be polled again at once
            every = self._interval(task, now) if answered else SLOW
            self._due[task] = next_poll(due, now, every)

    def _interval(self, task: Task, now: float) -> float:
        end = task.expected_end
        return interval(now - task.accepted_at, None if end is None else end - self._clock.now())

    # States that come with the samples of the feed: a poll of their own costs a round trip, and a
    # controller whose samples do not come is polled as if there were none.

    def due_before(self, seconds: float) -> tuple[Question, Callable[[ReadResult], object]] | None:
        """The question for a task that is due before the next sample, and far from its end.

        Args:
            seconds: until the next sample.

        Returns:
            The question, and what takes the answer; None if there is no such task.
        """
        now = time.monotonic()
        task = min(self._due, key=self._due.__getitem__, default=None)
        if task is None or self._due[task] >= now + seconds or task.state not in _UNDER_WAY:
            return None
        far = not task.life.continues_after_task and self._interval(task, now) >= SLOW
        if not far:
            return None
        return ("get_noneblock_taskstate", (task.id,)), partial(self._take_along, task)

    def _take_along(self, task: Task, answer: ReadResult) -> None:
        """Take in what came with a sample; a task that has changed is polled at once."""
        now = time.monotonic()
        if self._due.get(task, now) <= now:
            return  # it has ended, or is being polled
        if answer.error is None and answer.value == task.state:
            self._answered(task, task.state)
            self._note_time(task, self._clock.now())
            self._due[task] = now + self._interval(task, now) + _LATER
            self._alarm.postpone(min(self._due.values()))
        else:
            self._due[task] = now
            self._alarm.ring()

    def _note_time(self, task: Task, arm_time: float) -> None:
        """Stop an overdue task, and end a motion whose time is over."""
        if task.deadline is not None and arm_time > task.deadline and not task.overdue:
            task.overdue = True
            if task.motion:
                self._background.start(self._stop_overdue(task), "aioduco stop of an overdue task")
        elif (
            task.continuous
            and task.continuous.timed_by_program
            and task.time_over
            and not (task.life.end_seen or task in self._endings)
        ):
            self._endings[task] = anyio.Event()
            self._background.start(self._end_due(task), "aioduco end of a motion")

    async def _state(self, number: int) -> TaskState:
        """Poll the state of a task."""
        self.polls += 1
        value: int = await self._lane.call("get_noneblock_taskstate", (number,), ASK_LIMIT)
        return TaskState(value)

    async def _aborted(self, task: Task) -> bool:
        """Whether a motion in state 5 did not blend: the last one after it is in state 5, too.

        So an abort by another program is noticed, before a path sends the next motion. Once another
        motion was sent, that may have replaced the last one, as set-points do.
        """
        *_, last = self.motions or (task,)
        if last is task or await self._state(last.id) is not TaskState.INTERRUPT:
            return False
        return last.life.successor is Successor.NONE

    def _note_stop(self, task: Task) -> None:
        if self._arm.stops != task.stops_before:
            task.release_clock()
            task.life.stop_sent()
        if task.motion and self._arm.confirmed > task.stops_before and task.id > max(TaskState):
            task.life.stop_confirmed()

    async def _ask_whether_it_stands(self, task: Task) -> bool:
        """Poll whether the arm stands, after the controller ended the task of a continuous motion.

        Returns whether the controller answered.
        """
        self.polls += 1
        moving: bool | None = await self._read("robotmoving")
        if moving is None:
            return False
        self._seen[task] = time.monotonic()
        now = self._clock.now()
        self._note_stop(task)
        if moving:
            task.stood_since = None
        elif task.stood_since is None:
            task.stood_since = now
        elif (task.time_over or now - task.stood_since >= STOOD) and not await self._arm.paused():
            task.life.mark_standing()  # one that somebody has paused goes on when it is resumed
        return True

    async def _expect(self, task: Task) -> None:
        """Compute, once and right after acceptance, when a task will end."""
        task.placed = True
        if any(other.motion for other in self._seen if other is not task):
            return  # it begins where another motion ends, at an unknown time
        with contextlib.suppress(DucoError):  # its end is not known beforehand then
            task._begins_at(await self._arm.joints())

    def _answered(self, task: Task, state: TaskState | None) -> None:
        now = time.monotonic()
        self._seen[task] = now
        # Before the state is judged: a stop that was requested before this state came about must
        # be noted, or an interruption by it could be taken for blending.
        self._note_stop(task)
        if state is None:
            task.life.mark_lost()
        elif task._observed(state, now):
            self._note_pause(task)
            tell(self.observers, task)

    def _note_pause(self, task: Task) -> None:
        """Log, once for each pause, that a motion waits because of somebody else."""
        gate = self._arm.permits.gate
        before, self._paused = self._paused, task.life.state is TaskState.PAUSED
        if task._states[-2:] == [TaskState.PAUSED, TaskState.RUNNING] and not gate.stopping:
            gate.paused = False  # somebody else has resumed what this program had paused
        if self._paused and not before and not gate.paused:
            _log.warning(
                "%r waits, though robot.pause() was not called: a person, another program or a "
                "switch of the mode has paused it. robot.resume() goes on, as does `aioduco "
                "resume`; robot.stop() ends it, as does `aioduco stop`",
                task,
            )

    async def _end(self, task: Task) -> None:
        self._due.pop(task, None)
        now = time.monotonic()
        errors: list[str] = []
        if task.life.outcome in _WITH_ERRORS:
            # The outcome is known, and does not wait for the list that only explains it.
            found: list[str] | None = await self._read("get_last_error")
            if found is not None:
                errors, self._error_list = found, tuple(found)
        told = task.life.end_seen and task.life.outcome is Outcome.FINISHED
        if task.motion and (told or task.life.outcome is Outcome.STOPPED):
            if not (told or task.life.stop_seen or task.stopped_by):
                # Somebody else has stopped the arm: what was asked for before does not move it.
                self._arm.permits.gate.end(PermitEnding.STOPPED)
            # What this program has sent meanwhile would move it, too.
            again = not told and await self._goes_on(task)
            step = self._arm.halt if again else partial(self._standstill, task)
            self._background.start(
                self._see(task, step, "%r was stopped, but %s"),
                "aioduco standstill",
                lambda: self._mark_ended(task, (), now),
            )
            return
        forgotten = self._namesakes(task) or task.life.idle_after_stop
        if task.motion and task.life.outcome is Outcome.UNKNOWN and not forgotten:
            self._stop_lost(task, lambda: self._mark_ended(task, errors, now))
            return
        self._mark_ended(task, errors, now)

    async def _standstill(self, task: Task) -> None:
        """Wait until the arm stands, and before that for the call that ends the motion."""
        if (ending := self._endings.get(task)) is not None:
            await ending.wait()
        await self._arm.standstill(task.stops_before)

    async def _goes_on(self, task: Task) -> bool:
        """Whether a motion was sent after one that this program did not stop, and was not ended."""
        if task.life.stop_seen:
            return False
        *_, last = self.motions or (task,)
        if last is task or last.life.successor is Successor.SENT:
            return last.life.successor is Successor.SENT
        try:
            return not (await self._state(last.id)).ended
        except DucoError:
            return True  # it may

    def _mark_ended(self, task: Task, errors: Sequence[str], now: float) -> None:
        self._seen.pop(task, None)
        self._endings.pop(task, None)
        was_done = task.done
        task._finish(errors, now)
        if not self._seen and not self._closed:
            self._list_due = True
            self._alarm.ring()
        if not was_done:
            tell(self.observers, task)

    async def _stop_unfollowed(self) -> None:
        """Stop the motions before they end as unknown: other code has cancelled what follows them.

        Mostly the event loop ends: it waits for this, as it cancels everything.
        """
        for task in self.motions[:1]:
            step = partial(run_to_completion, self._arm.halt)
            fault = await self._see(task, step, "%r is not followed any more: %s")
            for other in self.motions:
                other.fault = other.fault or fault

    def _close(self) -> None:
        self._closed = True
        now = time.monotonic()
        for task in self.tasks:
            if task.motion:
                self._arm.unfollowed_motion = True
            self._due.pop(task, None)
            task.life.mark_lost()
            self._mark_ended(task, (), now)

    def _stop_lost(self, task: Task, mark_ended: Callable[[], None]) -> None:
        """Stop a motion with an unknown outcome, because it may still move the arm.

        `mark_ended` is called when the arm stands, or when no stop could be confirmed.
        """
        self._arm.unfollowed_motion = True
        see_stopped = self._see(task, self._arm.halt, "%r was lost sight of: %s")
        self._background.start(see_stopped, "aioduco stop of a lost task", mark_ended)
        self._background.start(self._see_lapsed(task, mark_ended), "aioduco lost heartbeat")

    async def _see(
        self, task: Task, step: Callable[[], Awaitable[object]], failed: str
    ) -> StopUnconfirmed | None:
        """Carry out a step that brings the arm to rest. If that is not known in the end, say so.

        Args:
            task: the task that cannot end before.
            step: the step.
            failed: message for the log, with places for the task and the error.
        """
        try:
            await step()
        except StopUnconfirmed as exc:
            if not task.done:
                task.fault = exc
            _log.critical(failed, task, exc)
            return exc
        return None

    async def _see_lapsed(self, task: Task, mark_ended: Callable[[], None]) -> None:
        """End a lost task as soon as the controller has stopped the arm by itself.

        The attempts to stop continue, and the next motion waits for them.
        """
        async with anyio.create_task_group() as group:

            async def lapse() -> None:
                fault = await self._arm.lapsed()
                if not task.done:
                    task.fault = fault
                    mark_ended()

            group.start_soon(lapse)
            await task.wait()
            group.cancel_scope.cancel()

    async def _end_due(self, task: Task) -> None:
        assert task.continuous is not None
        answered = self._endings[task]
        try:
            await self._arm.end(task.continuous.ending, answered=answered.set)
        except DucoError as exc:
            # The arm was stopped instead, or that failed too.
            if isinstance(exc, StopUnconfirmed):
                task.fault = exc
            _log.log(
                logging.CRITICAL if task.fault else logging.WARNING,
                "%r was not ended by %s: %s",
                *(task, task.continuous.ending, exc),
            )
        finally:
            answered.set()  # if it was not asked

    async def _stop_overdue(self, task: Task) -> None:
        if await self._see(task, self._arm.halt, "%r is overdue: %s"):
            task.life.mark_lost()
