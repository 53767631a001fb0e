"""Sending commands that become tasks.

Guarantees:
- A motion whose acceptance is not known for certain is stopped. A motion is sent by a background
  task, so that a cancellation of the caller cannot cut off the answer that says whether it was
  accepted: the stop would then overtake the motion.
- A stop that is asked for while a motion is on its way holds for that motion too.
- Motions reach the controller in the order in which they were started, over a lane of their
  own: the start of a motion waits behind no blocking call.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import anyio
import anyio.lowlevel

from aioduco.errors import (
    DucoError,
    HeartbeatLost,
    OutcomeUnknown,
    Refused,
    RobotStateError,
)
from aioduco.supervision.command import Command
from aioduco.supervision.insist import insist
from aioduco.supervision.lifecycle import TaskLifecycle
from aioduco.supervision.pulse import HeartbeatState
from aioduco.supervision.task import Task

if TYPE_CHECKING:
    from typing import Any, NoReturn

    from aioduco._wire.lane import Lane
    from aioduco.models.enums import Outcome
    from aioduco.supervision.background import Background
    from aioduco.supervision.heartbeat import Heart
    from aioduco.supervision.keeper import Keeper
    from aioduco.supervision.settings import Settings
    from aioduco.supervision.task import OnCancel


class _Sending:
    """A command on its way to the controller."""

    def __init__(self) -> None:
        self.done = anyio.Event()
        self.answer = -1
        self.error: DucoError | None = None
        self.at = 0.0


class Launcher:
    """Sends commands, one at a time, and makes tasks of them.

    Args:
        lane: where commands are sent.
        keeper: follows the tasks, and stops what went wrong.
        background: sends, beside the caller.
        heartbeat: without its beating no motion is started; None if there is none.
        settings: times and limits.

    Attributes:
        closed: why nothing is started any more; empty while something is.
        accepted: commands that the controller accepted.
    """

    def __init__(
        self,
        lane: Lane,
        keeper: Keeper,
        background: Background,
        heartbeat: Heart | None,
        settings: Settings,
    ) -> None:
        self._lane = lane
        self._keeper = keeper
        self._background = background
        self._heartbeat = heartbeat
        self._settings = settings
        self._order = anyio.Lock()
        self._last: Task | None = None
        self.closed = ""
        self.accepted: int = 0

    async def quiet(self, timeout: float) -> None:
        """Wait until no command is on its way; after `closed` was set, none follows."""
        with anyio.move_on_after(timeout):
            async with self._order:
                return

    async def admit_stream(self, name: str) -> None:
        """See that a stream of set-points may begin.

        Args:
            name: what it is called.

        Raises:
            RobotStateError: the robot is not open, or something moves the arm.
            HeartbeatLost: the heartbeat does not beat.
        """
        async with self._order:
            self._admit(Command(name, ()))
            keeper = self._keeper
            tasks = [task for task in keeper.poller.tasks if task.motion]
            if tasks or keeper.modes.moving or keeper.unfollowed:
                moved = ", ".join(map(repr, tasks)) or "a mode in which the arm moves"
                raise RobotStateError(
                    f"{name} was not opened: {moved} is under way, and the arm can follow only one"
                )

    async def perform(self, name: str, args: tuple[Any, ...], timeout: float) -> Outcome:
        """Send a command that moves nothing, and wait for its end.

        Args:
            name: the function of the wire.
            args: its arguments, with block false.
            timeout: seconds in which it must end.

        Raises:
            TaskError: it did not succeed.
        """
        task = await self.launch(Command(name, args, motion=False))
        return await self._keeper.completed(task, timeout)

    async def launch(
        self,
        command: Command,
        *,
        deadline: float | None = None,
        on_cancel: OnCancel | None = None,
    ) -> Task:
        """Send a command and return its task; `MotionCommand.start` describes it."""
        self._admit(command)
        # Held until it is certain what became of the command: while one that went astray is
        # being stopped, no other motion is sent, and the robot is not closed.
        async with self._order:
            self._admit(command)
            stops = self._keeper.stops
            before = self._last if command.motion else None
            if before is not None:
                before.life.successor_sent()
            mode = command.held.ending if command.held is not None and command.held.mode else None
            was_on = mode is not None and self._keeper.modes.enter(mode, (False,))
            sending = _Sending()
            self._background.start(self._send(command, sending), f"aioduco {command.name}")
            _, cancelled = await insist(sending.done.wait)
            error = sending.error
            if error is None and sending.answer < 0:
                error = Refused(command.name, sending.answer, "no reason is given")
            if error is not None:
                if mode is not None and not was_on and not isinstance(error, OutcomeUnknown):
                    self._keeper.modes.over(mode)
                await self._failed(command, before, error, cancelled)
            task = self._accept(command, sending, stops, deadline, on_cancel)
            if command.motion and self._keeper.stops != stops:
                # Somebody asked for a stop in the meantime, and it may have been served first.
                _, again = await insist(self._keeper.halt)
                cancelled = cancelled or again
            await self._hand_over(task, cancelled)
            return task

    async def _failed(
        self,
        command: Command,
        before: Task | None,
        error: DucoError,
        cancelled: BaseException | None,
    ) -> NoReturn:
        if command.motion and isinstance(error, OutcomeUnknown):
            _, again = await insist(self._keeper.halt_late)
            cancelled = cancelled or again
        if before is not None:
            before.life.successor_refused()
        raise cancelled or error

    async def conduct(self, command: Command, lane: Lane, timeout: float | None) -> int:
        """Send a motion that is answered only when it has ended, or a mode in which the arm moves.

        Cancelling this stops the arm. So does the loss of the answer.

        Args:
            command: what is sent.
            lane: where: it is taken until the answer comes.
            timeout: seconds for the answer; None for as long as it takes.

        Returns:
            The answer.
        """
        self._admit(command)
        keeper = self._keeper
        keeper.unfollowed += 1
        try:
            answer: int = await lane.call(command.name, command.args, timeout)
        except BaseException as exc:
            known = isinstance(exc, DucoError) and not isinstance(exc, OutcomeUnknown)
            if not known and not self.closed:
                await insist(keeper.halt_late)
            raise
        finally:
            keeper.unfollowed -= 1
        return answer

    def adopt(self, command: Command, task_id: int) -> Task:
        """Follow a task that the controller has answered with, though it was not asked to."""
        sending = _Sending()
        sending.answer, sending.at = task_id, time.monotonic()
        return self._accept(command, sending, self._keeper.stops, None, None)

    async def _hand_over(self, task: Task, cancelled: BaseException | None) -> None:
        """Give the task to the caller, unless the caller was cancelled meanwhile."""
        try:
            if cancelled is not None:
                raise cancelled  # noqa: TRY301  # one way out for both kinds of cancellation
            await anyio.lowlevel.checkpoint_if_cancelled()
        except BaseException:
            await self._keeper.forsaken(task)
            raise

    def _admit(self, command: Command) -> None:
        if self.closed:
            raise RobotStateError(f"{command.name} was not sent: {self.closed}")
        if command.motion and self._keeper.streams:
            raise RobotStateError(
                f"{command.name} was not sent: the arm follows {next(iter(self._keeper.streams))!r}"
                "; close it first"
            )
        if self._heartbeat is None or not command.motion:
            return
        if (state := self._heartbeat.state) is not HeartbeatState.BEATING:
            what = (
                "the event loop hung; call robot.rearm_heartbeat() to go on"
                if state is HeartbeatState.STALLED
                else "the controller does not answer it; it is tried on"
            )
            raise HeartbeatLost(
                f"{command.name} was not sent, since the heartbeat does not beat: {what}"
            )

    async def _send(self, command: Command, sending: _Sending) -> None:
        try:
            sending.answer = await self._lane.call(command.name, command.args)
        except DucoError as exc:
            sending.error = exc
        except BaseException:
            sending.error = OutcomeUnknown(command.name, "the program was ended meanwhile")
            raise
        finally:
            sending.at = time.monotonic()
            sending.done.set()

    def _accept(
        self,
        command: Command,
        sending: _Sending,
        stops: int,
        deadline: float | None,
        on_cancel: OnCancel | None,
    ) -> Task:
        if not command.motion:
            on_cancel = "detach"
        elif command.held is not None and (on_cancel or self._settings.on_cancel) == "pause":
            on_cancel = "stop"  # what was paused would go on, with nobody to end it
        if deadline is None and command.held is not None:
            deadline = command.held.limit
        task = Task(
            self._keeper,
            command.name,
            sending.answer,
            TaskLifecycle(blends=command.blends, held=command.held),
            accepted_at=sending.at,
            stops_before=stops,
            motion=command.motion,
            on_cancel=on_cancel or self._settings.on_cancel,
            deadline=None if deadline is None else sending.at + deadline,
            held=command.held,
            course=command.course,
        )
        self.accepted += 1
        if command.motion:
            if self._last is not None:
                self._last.life.successor_accepted()
            self._last = task
        self._keeper.poller.follow(task)
        return task
