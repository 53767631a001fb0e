"""Who brings the arm to rest: on request, on cancellation, and when a motion is unwatched.

Guarantees:
- Cancelling the await of a motion returns only when the arm stands, or raises `StopUnconfirmed`.
- A motion that nobody can follow any more, or that is overdue, is stopped.
- What goes on until it is told to end is told so when its time is over, and along with a stop.
"""

from __future__ import annotations

import logging
import time
from typing import TYPE_CHECKING

import anyio

from aioduco.errors import ConnectionLost, DucoError, StopUnconfirmed, TaskUnknown
from aioduco.supervision.control import STANDSTILL_EVERY, Control
from aioduco.supervision.insist import insist
from aioduco.supervision.lifecycle import TaskLifecycle
from aioduco.supervision.modes import Modes
from aioduco.supervision.poller import Poller
from aioduco.supervision.streams import Streams
from aioduco.supervision.task import Task

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from aioduco._wire.lane import Lane
    from aioduco.models.enums import Outcome
    from aioduco.supervision.background import Background
    from aioduco.supervision.settings import Settings

_log = logging.getLogger(__name__)

#: seconds for which the arm is watched after a stop of a motion whose answer was lost: the
#: command may reach the controller later than the stop
_LATE = 0.3
#: seconds for a stopped task to be seen to have ended
_SETTLE = 1.0
#: seconds for a pause or a resume to be carried out
_PAUSE_LIMIT = 10.0
#: seconds for the controller to say where the arm is
_ASK_LIMIT = 0.5
#: seconds for the lane of a stream to fall silent: an answer that it waits for, and more
_SILENCE = 2.0
#: the same in a thread that cannot go on meanwhile
_SILENCE_NOW = 0.1


class Keeper:
    """Stops, pauses and resumes the arm, and follows the tasks.

    Args:
        control: sends stop, pause, resume and abort.
        poll: lane of the poller.
        background: runs what no caller waits for.
        settings: times and limits.

    Attributes:
        poller: follows the tasks.
        loose: whether a motion may be running that is not followed. A stop ends that.
        modes: modes that the controller is in because of this program.
        unfollowed: motions on their way that are answered only at their ends.
        streams: the open streams; whatever brings the arm to rest ends them first.
    """

    def __init__(
        self, control: Control, poll: Lane, background: Background, settings: Settings
    ) -> None:
        self._control = control
        self._poll = poll
        self._background = background
        self._settings = settings
        self.poller: Poller = Poller(poll, self)
        self.loose: bool = False
        self.modes: Modes = Modes(control)
        self.unfollowed = 0
        self.streams: Streams = Streams()

    @property
    def stops(self) -> int:
        """How many stops have been asked for."""
        return self._control.epoch

    @property
    def moving(self) -> bool:
        """Whether anything that this program started may be moving the arm."""
        if self.loose or self.modes.moving or self.unfollowed or self.streams:
            return True
        return any(task.motion for task in self.poller.tasks)

    async def halt(self) -> None:
        """Stop the arm and see it stand.

        Raises:
            StopUnconfirmed: it is not known that it stands.
        """
        settings = self._settings
        await self.send_stop(settings.stop_timeout)
        await self.rest(settings.stop_timeout, settings.standstill_timeout)

    async def send_stop(self, timeout: float) -> None:
        """Stop the arm: it is then slowing down, and no stream or mode sets it moving again.

        Args:
            timeout: seconds in which a stop must be accepted.

        Raises:
            StopUnconfirmed: none was.
        """
        streaming = self.streams.halt()
        if self.modes.moving or streaming:
            try:
                await self._control.stop(timeout)
            finally:
                if streaming:
                    await self.streams.settled(_SILENCE)
                await self.modes.leave()
        await self._control.stop(timeout)

    async def rest(self, stop_timeout: float | None, timeout: float) -> None:
        """See the arm stand.

        Args:
            stop_timeout: seconds in which a further stop must be accepted, if it moves on; None to
                wait without one.
            timeout: seconds in which the arm must stand.

        Raises:
            StopUnconfirmed: it is not known that it stands.
        """
        if stop_timeout is None:
            await self._control.standstill(timeout)
        else:
            await self._control.rest(stop_timeout, timeout)
        self.loose = False

    def stop_now(self, timeout: float) -> None:
        """Send a stop from any thread or signal handler, and block until it is accepted.

        Args:
            timeout: seconds in which that must happen.

        Raises:
            StopUnconfirmed: it did not.
        """
        streaming = self.streams.halt()
        self._control.stop_now(timeout)
        if streaming:
            self.streams.quiet(_SILENCE_NOW)
            self._control.stop_now(timeout)

    async def joints(self) -> Sequence[float]:
        """Where the arm is: the angles of its joints [rad].

        Raises:
            ConnectionLost: the controller does not answer.
        """
        angles: list[float] = await self._poll.call("get_actual_joints_position", (), _ASK_LIMIT)
        return angles

    async def stop_stream(self, ending: str) -> None:
        """Stop what a lane streamed that is gone without a word.

        Args:
            ending: the function of the wire that ends the mode in which it was; may be empty.
        """
        if ending:
            self.modes.enter(ending)
        await self.stop()

    async def leave_modes(self, timeout: float) -> None:
        """Leave every mode that this program has entered: nothing of it is to come after.

        Args:
            timeout: seconds for each of what is to be left while the arm stands.
        """
        await self.modes.leave()
        await self.modes.leave_standing(timeout, self._follow)

    async def stop(self) -> None:
        """As `halt`, to its end even if cancelled, until the motions are seen to have ended."""
        _, cancelled = await insist(self.halt_late if self.unfollowed else self.halt)
        if cancelled is not None:
            raise cancelled
        await self._settled()

    async def halt_late(self) -> None:
        """Stop a motion of which it is not known when it reaches the controller, if ever."""
        self.loose = True
        await self.halt()
        until = time.monotonic() + _LATE
        while time.monotonic() < until:
            try:
                moving: bool = await self._poll.call("robotmoving", (), _LATE)
            except ConnectionLost:
                # Nothing is known: one more stop does no harm, and reports if it cannot be sent.
                moving = True
            if moving:
                await self.halt()
            await anyio.sleep(STANDSTILL_EVERY)

    async def forsaken(self, task: Task) -> None:
        """The await of a task was cancelled: do what its `on_cancel` says, then return."""
        if task.done or task.on_cancel == "detach":
            return
        if task.on_cancel == "pause":
            try:
                await insist(self.pause)
            except DucoError as exc:
                _log.error("%r could not be paused, so the arm is stopped: %s", task, exc)
            else:
                return
        await insist(self.halt)
        # The stop ended all of them, so none is left behind half known.
        await insist(self._settled)

    async def end(self, name: str, step: Callable[[], Awaitable[None]] | None = None) -> None:
        """Have what goes on ended by its own function, and see the arm stand.

        If this program's motion, or its mode, cannot be ended so, or if this is cancelled, the
        arm is stopped.

        Args:
            name: the function of the wire.
            step: calls it; None if it answers with the id of a task.
        """
        if name == "stop":
            step = self.halt
        held = [task for task in self.poller.tasks if task.held and task.held.ending == name]
        for task in held:
            task.life.end_sent()
        concerned = bool(held) or name in self.modes
        try:
            await (step() if step is not None else self._controlled(name))
            await self._come_to_rest(name)
        except BaseException:
            if concerned:
                await insist(self.halt)
                await insist(self._settled)
            raise
        with anyio.move_on_after(_SETTLE):
            for task in held:
                await task.wait()

    async def _come_to_rest(self, name: str) -> None:
        """See the arm stand after it was told to; what has no effect becomes a stop."""
        self.modes.over(name)
        try:
            await self._control.standstill(self._settings.standstill_timeout)
        except StopUnconfirmed as exc:
            _log.warning("%s had no effect, so the arm is stopped: %s", name, exc)
            await self.halt()

    async def pause(self) -> None:
        """Pause all tasks, and see the arm stand."""
        if self.streams.halt():
            # A stream goes by a clock, so it cannot go on later where it was.
            await self.streams.settled(_SILENCE)
        # A motion whose task has ended stands as if it were over, and moves on when resumed.
        self.loose = self.loose or any(task.life.goes_on for task in self.poller.tasks)
        await self._controlled("pause")
        await self._control.standstill(self._settings.standstill_timeout)

    async def resume(self) -> None:
        """Resume all paused tasks."""
        await self._controlled("resume")

    async def abort(self) -> None:
        """End the running motion and those read ahead, and see the arm stand."""
        if self.streams.halt():
            await self.streams.settled(_SILENCE)
        await self._controlled("abort")
        await self._control.standstill(self._settings.standstill_timeout)

    async def _controlled(self, name: str) -> None:
        stops = self.stops
        answer = await self._control.send(name)
        await self._follow(name, answer, _PAUSE_LIMIT, stops)

    async def _follow(
        self, name: str, task_id: int, timeout: float, stops: int | None = None
    ) -> Outcome:
        """Follow a task that moves nothing to its end, as `completed`."""
        task = Task(
            self,
            name,
            task_id,
            TaskLifecycle(),
            accepted_at=time.monotonic(),
            stops_before=self.stops if stops is None else stops,
            motion=False,
            on_cancel="detach",
        )
        self.poller.follow(task)
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

    async def _settled(self) -> None:
        with anyio.move_on_after(_SETTLE):
            for task in self.poller.tasks:
                if task.motion:
                    await task.wait()

    # -- what the poller finds -----------------------------------------------------------------

    def lost(self, task: Task, settle: Callable[[], None]) -> None:
        """A motion ended with an unknown outcome: nobody watches over it, and it may go on.

        It is stopped, and `settle` is called when the arm stands, or is not known to.
        """
        self.loose = True
        self._background.start(self._stop_unwatched(task, settle), "aioduco stop of a lost task")

    def forgotten(self, task: Task) -> None:  # noqa: ARG002  # whichever it is
        """A motion is not followed any more, since the poller ends: it may go on."""
        self.loose = True

    def overdue(self, task: Task) -> None:
        """A task has not ended by its deadline."""
        if task.motion:
            self._background.start(self._stop_overdue(task), "aioduco stop of an overdue task")

    def due(self, task: Task) -> None:
        """The time of a motion that this program has to end is over."""
        self._background.start(self._end_due(task), "aioduco end of a motion")

    def stopped(self, task: Task, settle: Callable[[], None]) -> None:
        """A motion was stopped, by whomever, or ended: `settle` is called when the arm stands."""
        self._background.start(self._settle_standing(task, settle), "aioduco standstill")

    async def _settle_standing(self, task: Task, settle: Callable[[], None]) -> None:
        try:
            await self._control.standstill(self._settings.standstill_timeout)
        except StopUnconfirmed as exc:
            task.fault = exc
            _log.critical("%r was stopped, but %s", task, exc)
        finally:
            settle()

    async def _stop_unwatched(self, task: Task, settle: Callable[[], None]) -> None:
        try:
            await self.halt()
        except StopUnconfirmed as exc:
            task.fault = exc
            _log.critical("%r was lost sight of: %s", task, exc)
        finally:
            settle()

    async def _end_due(self, task: Task) -> None:
        assert task.held is not None
        try:
            await self.end(task.held.ending)
        except DucoError as exc:
            # The arm was stopped instead, or that failed too.
            if isinstance(exc, StopUnconfirmed):
                task.fault = exc
            _log.log(
                logging.CRITICAL if task.fault else logging.WARNING,
                "%r was not ended by %s: %s",
                *(task, task.held.ending, exc),
            )

    async def _stop_overdue(self, task: Task) -> None:
        try:
            await self.halt()
        except StopUnconfirmed as exc:
            task.fault = exc
            task.life.lose()
            _log.critical("%r is overdue: %s", task, exc)
