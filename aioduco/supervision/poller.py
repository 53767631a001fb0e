"""One poller for all tasks of a robot: asks for their states, and ends them.

Guarantees:
- Each live task is asked about in its turn, at the rate that `schedule` says.
- A task that could not be asked about for `LOST_AFTER` seconds ends with an unknown outcome.
  Nothing is assumed of it.
- Whatever happens to the poller, every task ends: no await of one is left behind.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

import anyio

from aioduco.errors import ControllerError, DucoError
from aioduco.models.enums import Outcome, TaskState
from aioduco.supervision.held import STOOD
from aioduco.supervision.schedule import SLOW, Roster, interval

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco._wire.lane import Lane
    from aioduco.supervision.task import Task

#: seconds for one answer about a task
ASK_LIMIT = 0.5
#: seconds without an answer about a task after which its outcome is unknown
LOST_AFTER = 2.0

#: outcomes to which the controller's error list belongs
_WITH_ERRORS = {Outcome.FAILED, Outcome.ILLEGAL, Outcome.PARAMETER_MISMATCH}


class Watcher(Protocol):
    """Whoever wants to know what the poller finds."""

    @property
    def stops(self) -> int:
        """How many stops have been asked for; rises before a stop is sent."""
        ...

    def lost(self, task: Task, settle: Callable[[], None]) -> None:
        """A motion was lost sight of: `settle` is to be called when it has been stopped."""
        ...

    def overdue(self, task: Task) -> None:
        """A task has not ended by its deadline."""
        ...

    def forgotten(self, task: Task) -> None:
        """A motion is not followed any more, since the poller ends."""
        ...

    def due(self, task: Task) -> None:
        """The time of a motion that this program has to end is over."""
        ...

    def stopped(self, task: Task, settle: Callable[[], None]) -> None:
        """A motion was stopped, or ended: `settle` is to be called when the arm stands."""
        ...


class Poller:
    """Follows tasks to their ends.

    Args:
        lane: where to ask.
        watcher: is told of tasks lost and overdue.

    Attributes:
        polls: questions that were asked.
    """

    def __init__(self, lane: Lane, watcher: Watcher) -> None:
        self._lane = lane
        self._watcher = watcher
        self._roster: Roster[Task] = Roster()
        self._wake = anyio.Event()
        self._seen: dict[Task, float] = {}
        self._closed = False
        self.polls: int = 0

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The tasks that live, in the order of their acceptance."""
        return tuple(self._seen)

    def follow(self, task: Task) -> None:
        """Follow a task from now on."""
        if self._closed:
            task.life.lose()
            task.settle((), time.monotonic())
            return
        self._seen[task] = task.accepted_at
        self._roster.add(task, task.accepted_at)
        wake, self._wake = self._wake, anyio.Event()
        wake.set()

    async def run(self) -> None:
        """Follow tasks until this is cancelled."""
        try:
            while True:
                first = self._roster.first()
                if first is None:
                    await self._wake.wait()
                    continue
                task, due = first
                delay = due - time.monotonic()
                if delay > 0:
                    with anyio.move_on_after(delay):
                        await self._wake.wait()
                    continue
                await self._ask(task)
        finally:
            self._close()

    async def _ask(self, task: Task) -> None:
        if task.course is not None and not task.placed:
            await self._expect(task)
        answered = True
        self._note_stop(task)
        if task.life.goes_on:
            answered = await self._ask_whether_it_stands(task)
        elif not task.life.undecided:
            self.polls += 1
            try:
                value: int = await self._lane.call("get_noneblock_taskstate", (task.id,), ASK_LIMIT)
            except ControllerError:
                # It was asked, and answered that it cannot tell: that is no lost connection, but
                # nothing will be heard of the task either.
                self._answered(task, None)
            except DucoError:
                answered = False
            else:
                self._answered(task, TaskState(value))
        now = time.monotonic()
        if not answered and now - self._seen[task] > LOST_AFTER:
            task.life.lose()
        if task.life.ended:
            await self._end(task)
            return
        if task.deadline is not None and now > task.deadline and not task.overdue:
            task.overdue = True
            self._watcher.overdue(task)
        elif task.held and task.held.timed_here and self._in_time(task) and not task.life.end_seen:
            task.life.end_sent()
            self._watcher.due(task)
        remaining = None if task.expected_end is None else task.expected_end - now
        every = interval(now - task.accepted_at, remaining) if answered else SLOW
        self._roster.asked(task, now, every)

    def _note_stop(self, task: Task) -> None:
        if self._watcher.stops != task.stops_before:
            task.life.stop_sent()

    async def _ask_whether_it_stands(self, task: Task) -> bool:
        """The controller ended the task of a motion that goes on. Returns whether it answered."""
        self.polls += 1
        try:
            moving: bool = await self._lane.call("robotmoving", (), ASK_LIMIT)
        except DucoError:
            return False
        self._seen[task] = now = time.monotonic()
        self._note_stop(task)
        if moving:
            task.stood_since = None
        elif task.stood_since is None:
            task.stood_since = now
        else:
            in_time = self._in_time(task)
            if in_time or now - task.stood_since >= STOOD:
                task.life.stood(in_time=in_time)
        return True

    def _in_time(self, task: Task) -> bool:
        """Whether the time of a motion that goes on is over."""
        if task.held is None or task.held.time is None:
            return False
        return time.monotonic() - task.accepted_at >= task.held.time

    async def _expect(self, task: Task) -> None:
        """Once, right after acceptance: when will it end, from where the arm is now?"""
        task.placed = True
        if any(other.motion for other in self._seen if other is not task):
            return  # it begins where another motion ends, at a time that nobody knows
        try:
            joints: list[float] = await self._lane.call("get_actual_joints_position", (), ASK_LIMIT)
        except DucoError:
            return
        if len(joints) >= 6:
            task.begins_at(joints)

    def _answered(self, task: Task, state: TaskState | None) -> None:
        now = time.monotonic()
        self._seen[task] = now
        # Before the state is judged: a stop that was asked for before this state came about must
        # have been noted, or an interruption by it could pass for blending.
        self._note_stop(task)
        if state is None:
            task.life.lose()
        else:
            task.observed(state, now)

    async def _end(self, task: Task) -> None:
        self._roster.remove(task)
        now = time.monotonic()
        errors: list[str] = []
        if task.life.outcome in _WITH_ERRORS:
            try:
                errors = await self._lane.call("get_last_error", (), ASK_LIMIT)
            except DucoError:
                # The outcome is known, and must not wait for what only explains it.
                errors = []
        told = task.life.end_seen and task.life.outcome is Outcome.FINISHED
        if task.motion and (told or task.life.outcome is Outcome.STOPPED):
            self._watcher.stopped(task, lambda: self._settle(task, (), now))
            return
        if task.motion and task.life.outcome is Outcome.UNKNOWN:
            self._watcher.lost(task, lambda: self._settle(task, errors, now))
            return
        self._settle(task, errors, now)

    def _settle(self, task: Task, errors: Sequence[str], now: float) -> None:
        self._seen.pop(task, None)
        task.settle(errors, now)

    def _close(self) -> None:
        self._closed = True
        now = time.monotonic()
        for task in self.tasks:
            if task.motion:
                self._watcher.forgotten(task)
            self._roster.remove(task)
            task.life.lose()
            self._settle(task, (), now)
