"""Sending commands that become tasks.

Guarantees:
- A motion is asked for when it is awaited or started, and sent only while that permit is valid: the
  gate decides (`supervision.gate`).
- A motion is stopped if it is not certain whether the controller accepted it. Its call goes on if
  the caller is cancelled, so the answer that says whether it was accepted is not lost: the stop
  would otherwise overtake the motion.
- A stop that is requested while a motion is on its way also applies to that motion.
- Motions reach the controller in the order in which they were started, over a lane of their
  own: the start of a motion never waits behind a blocking call.
"""

from __future__ import annotations

import contextlib
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import anyio
import anyio.lowlevel

from aioduco._process.platform import boot_time
from aioduco.errors import OutcomeUnknown, RobotStateError
from aioduco.models.enums import Outcome, TaskState
from aioduco.supervision.command_result import taken
from aioduco.supervision.concurrency import Alarm, run_to_completion
from aioduco.supervision.gate import PermitEnding
from aioduco.supervision.stop_channel import refusal
from aioduco.supervision.task import OnCancel, Task
from aioduco.supervision.task_command import Command

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from aioduco._wire.channel import LaneCall
    from aioduco._wire.lane import WireLane
    from aioduco.supervision.gate import Permit
    from aioduco.supervision.motion_sources import ModeEnding
    from aioduco.supervision.permits import Permits
    from aioduco.supervision.settings import RobotSettings
    from aioduco.supervision.stop_coordinator import StopCoordinator


class Dispatcher:
    """Sends commands, one at a time, and makes tasks of them.

    Args:
        lane: lane on which commands are sent.
        coordinator: follows the tasks, and stops motions that went wrong.
        settings: times and limits.

    Attributes:
        accepted: number of commands that the controller accepted.
        permits: permits to move the arm.
        check: checks each motion before it is sent; it may raise, or slow the motion down.
        require_opened: called with the name of each command; raises if the robot was never opened.
        check_software: called with the name of each motion before it is sent; raises if the
            controller has other software than it had when the robot was opened.
    """

    def __init__(
        self,
        lane: WireLane,
        coordinator: StopCoordinator,
        settings: RobotSettings,
    ) -> None:
        self._lane = lane
        self._coordinator = coordinator
        self.permits: Permits = coordinator.permits
        self._gate = coordinator.permits.gate
        self._settings = settings
        self._clock = settings.clock
        self._order = anyio.Lock()
        self._look = Alarm()
        self._last: Task | None = None
        self.accepted: int = 0
        self.check: Callable[[Command], Awaitable[Command]] | None = None
        self.require_opened: Callable[[str], object] = lambda _: None
        self.check_software: Callable[[str], Awaitable[object]] | None = None

    @property
    def in_order(self) -> anyio.Lock:
        """Held while a motion is being sent, until its result is certain."""
        return self._order

    async def quiet(self, timeout: float) -> None:
        """Wait until no command is on its way; after the gate was closed, none follows."""
        with anyio.move_on_after(timeout):
            async with self._order:
                return

    def look(self) -> None:
        """Let `note_rest` go on if there is anything for it to do; at each keep-alive."""
        coordinator = self._coordinator
        if coordinator.modes.due or (coordinator.liveness.moves and not coordinator.busy):
            self._look.ring()

    async def note_rest(self) -> None:
        """Note whenever the arm stands and nothing that the program started still runs.

        Before that, modes are ended that should be off: `robot.stop_now()` cannot wait for that. A
        stop that waits ends them itself, once it was accepted.
        """
        coordinator = self._coordinator
        while True:
            await self._look.wait()
            if not coordinator.streams and not self._gate.stopping:  # workers end their own
                await coordinator.modes.leave_due()
            # No await between the last check for commands on their way, and `at_rest`.
            if not coordinator.liveness.moves or coordinator.busy:
                continue
            stands = await coordinator.stands()
            # what somebody has paused is not over: it goes on when anybody resumes
            paused = stands and self._gate.resumed and await coordinator.paused()
            self._gate.seen(boot_time(), standing=stands and not paused)
            if stands and not coordinator.moving and not self._order.statistics().locked:
                coordinator.liveness.at_rest()

    async def admit_stream(self, name: str) -> Permit:
        """Check that a stream of set-points may begin.

        Args:
            name: name of the stream, for messages.

        Returns:
            The permit of its set-points.

        Raises:
            RobotStateError: the robot is not open, or something moves the arm.
            HeartbeatLost: the heartbeat is not running.
        """
        command = Command(name, ())
        permit = self._asked(command)
        async with self._order:
            coordinator = self._coordinator
            await self.permits.after_stops(permit)
            await coordinator.modes.leave_overdue(name)
            resumed = self._gate.resumed and not await coordinator.stands()
            self._admit(command, permit)
            motions = coordinator.follower.motions
            if motions or coordinator.modes.moving or coordinator.pending or resumed:
                moved = ", ".join(map(repr, motions)) or "a motion without a task, or a mode,"
                raise RobotStateError(
                    f"{name} was not opened: {moved} is under way, and the arm can follow only one"
                )
            return permit

    async def perform(self, name: str, args: tuple[Any, ...], timeout: float) -> Outcome:
        """Send a command that moves nothing, and wait for its end.

        Args:
            name: the function of the wire.
            args: its arguments, with block false.
            timeout: seconds within which it must end.

        Raises:
            TaskError: it did not succeed.
        """
        task = await self.launch(Command(name, args, motion=False))
        return await self._coordinator.follower.completed(task, timeout)

    async def launch(
        self,
        command: Command,
        *,
        deadline: float | None = None,
        on_cancel: OnCancel | None = None,
        behind: Task | None = None,
    ) -> Task:
        """Send a command and return its task; `MotionCommand.start` describes it.

        Args:
            command: the command.
            deadline: seconds after which the arm is stopped.
            on_cancel: what happens if the await of the task is cancelled.
            behind: the motion of a path after which it is sent; None for any other.

        Raises:
            TaskError: that motion has ended, and did not succeed; nothing was sent.
        """
        permit = self._asked(command)
        # Locked until the result of the command is certain: while a command that was lost is being
        # stopped, no other motion is sent, and the robot is not closed.
        async with self._order:
            if command.motion:
                command = await self._prepared(command, permit)
            errors = await self._coordinator.follower.error_list()
            if behind is not None:
                await self._coordinator.follower.others_ended(behind)
            await anyio.lowlevel.checkpoint_if_cancelled()  # from here to the send is no other
            self._admit(command, permit)
            return await self._launch(command, permit, errors, deadline, on_cancel)

    async def _prepared(self, command: Command, permit: Permit) -> Command:
        """Wait for stops, then convert a motion into the wire's frame, and check it."""
        await self.permits.after_stops(permit)
        await self._coordinator.modes.leave_overdue(command.name)
        if self.check_software is not None:
            await self.check_software(command.name)
        if command.aim is not None:
            command = replace(command, args=await command.aim(command))
        return command if self.check is None else await self.check(command)

    async def _launch(
        self,
        command: Command,
        permit: Permit,
        errors: Sequence[str],
        deadline: float | None,
        on_cancel: OnCancel | None,
    ) -> Task:
        before = self._last if command.motion else None
        if before is not None:
            before.life.successor_sent()
        with contextlib.ExitStack() as held:
            motion = command.continuous
            if motion is not None and motion.timed_by_program and motion.time is not None:
                # the clock waits until the start of a motion that this program must end is known
                held.callback(self._clock.hold(self._clock.now()))
            call: LaneCall | None = None
            try:
                if command.motion:
                    call, cancelled = await self._coordinator.answered(
                        *(self._lane, permit, command, self._settings.call_timeout),
                        followed=True,
                        mode=None if motion is None else motion.mode,
                    )
                else:
                    call = self._lane.prepare(command.name, command.args)
                    self._lane.send(call)
                    _, cancelled = await run_to_completion(call.wait)
                if (error := call.error or refusal(command.name, call.value)) is not None:
                    raise cancelled or error  # noqa: TRY301  # one way out for all failures
                accepted_at = time.monotonic() if call.ended_at is None else call.ended_at
                task = self._accept(
                    command, call.value, accepted_at, permit.stops, errors, deadline, on_cancel
                )
            except BaseException:
                if before is not None:
                    before.life.successor_refused()
                if command.motion and call is not None and taken(call, followed=True):
                    # There was no memory for its task, or a signal's handler raised: the controller
                    # carries it out, and nothing follows it.
                    self._coordinator.unfollowed_motion = True
                    await run_to_completion(self._coordinator.halt)
                raise
        if command.motion and self._coordinator.overtaken(permit):
            # The controller may have served the stop first.
            _, again = await run_to_completion(self._coordinator.halt)
            cancelled = cancelled or again
        await self._hand_over(task, cancelled)
        return task

    async def conduct(
        self,
        command: Command,
        lane: WireLane,
        timeout: float | None,
        mode: ModeEnding | None = None,
        *,
        as_task: bool = False,
    ) -> int:
        """Send a motion that is answered only when it has ended, or a mode in which the arm moves.

        The arm is stopped if this is cancelled, or if the answer is lost, or does not say how the
        command has ended.

        Args:
            command: the command.
            lane: lane on which it is sent; it is in use until the answer comes.
            timeout: seconds for the answer; None for no limit.
            mode: the mode that it enters, as for `Modes.enter`; None if it enters none.
            as_task: whether the answer may also be the id of a task, which the caller then follows.

        Returns:
            The answer: an end state, the id of a task, or a refusal, which is negative.

        Raises:
            OutcomeUnknown: the answer is lost, or is no end; the arm was stopped.
        """
        permit = self._asked(command)
        async with self._order:
            command = await self._prepared(command, permit)
            await anyio.lowlevel.checkpoint_if_cancelled()  # from here to the send is no other
            self._admit(command, permit)
        answer = await self._answer(command, lane, permit, timeout, mode)
        if answer == TaskState.STOPPED:
            # by another program: after a stop by this one there would be an error
            self._gate.end(PermitEnding.STOPPED)
        if answer < 0 or TaskState(answer).ended or (as_task and answer > max(TaskState)):
            return answer
        if mode is not None:
            self._coordinator.modes.enter(*mode)
        self._coordinator.unfollowed_motion = True
        await self._coordinator.stop()
        reason = f"its answer, {answer}, is no end, and the arm was stopped"
        raise OutcomeUnknown(command.name, reason)

    async def _answer(
        self,
        command: Command,
        lane: WireLane,
        permit: Permit,
        timeout: float | None,
        mode: ModeEnding | None,
        *,
        enters: bool = True,
    ) -> int:
        """Send what moves the arm without a task, and return its answer; see `conduct`."""
        call, cancelled = await self._coordinator.answered(
            lane, permit, command, timeout, followed=False, mode=mode, enters=enters
        )
        if (error := cancelled or call.error) is not None:
            raise error
        answer: int = call.value
        return answer

    async def block(self, command: Command, lane: WireLane) -> TaskState:
        """Send a motion by the manual's blocking call, and return the state of its task at its end.

        Args:
            command: the motion, with block true.
            lane: lane on which it is sent; it is in use until the answer comes.
        """
        before, state = self._last, TaskState.IDLE
        if before is not None:
            before.life.successor_sent()
        try:
            state = TaskState(await self.conduct(command, lane, None))
        finally:
            # What blended into this one is known now, and not when this one was accepted.
            if before is not None and state in (TaskState.FINISHED, TaskState.INTERRUPT):
                before.life.successor_accepted()
            elif before is not None:
                before.life.successor_refused()
        if command.continuous is not None or (command.blends and state is TaskState.INTERRUPT):
            self._gate.resume()  # the arm may still move, without a task that is followed
        return state

    async def feed(self, command: Command, lane: WireLane, mode: ModeEnding) -> int:
        """Send points that the arm may follow at once, and return the answer.

        The arm is stopped if this is cancelled, or if the answer is lost: they may come late.

        Args:
            command: the command.
            lane: lane on which it is sent.
            mode: what ends the mode in which the arm follows them, or removes them.
        """
        permit = self._asked(command)
        await self.permits.after_stops(permit)
        await self._coordinator.modes.leave_overdue(command.name)
        self._admit(command, permit)
        self._gate.resume()
        timeout = self._settings.call_timeout
        return await self._answer(command, lane, permit, timeout, mode, enters=False)

    def adopt(self, command: Command, task_id: int, errors: Sequence[str] = ()) -> Task:
        """Follow a task of a call that, according to the manual, starts no task.

        Args:
            command: the command that was sent.
            task_id: the controller's id of the task.
            errors: the controller's error list before it was sent.
        """
        return self._accept(command, task_id, time.monotonic(), self._gate.stops, errors)

    async def _hand_over(self, task: Task, cancelled: BaseException | None) -> None:
        """Give the task to the caller, unless the caller was cancelled meanwhile."""
        try:
            if cancelled is not None:
                raise cancelled  # noqa: TRY301  # one way out for both kinds of cancellation
            await anyio.lowlevel.checkpoint_if_cancelled()
        except BaseException:
            await self._coordinator.cancelled_while_waiting(task)
            raise

    def _asked(self, command: Command) -> Permit:
        """Ask for a permit to send a command.

        Raises:
            RobotStateError: the robot is not open, or a stream is open.
            HeartbeatLost: the heartbeat does not beat, or the program hung.
            TaskStopped: the undertaking to which it belongs has ended.
        """
        self._lane.owner_loop.require(command.name)
        self.require_opened(command.name)
        if not command.motion:
            return self._gate.ask(command.name, boot_time(), moves=False)
        self._refuse_beside_stream(command.name)
        return self.permits.ask(command.name)

    def _admit(self, command: Command, permit: Permit) -> None:
        """Check a command once more, after what was awaited, and note that a motion is sent."""
        if not command.motion:
            self._gate.ask(command.name, boot_time(), moves=False)
            return
        self._refuse_beside_stream(command.name)
        self.permits.check(permit)
        self._coordinator.liveness.will_move(command.name)

    def _refuse_beside_stream(self, name: str) -> None:
        for stream in self._coordinator.streams:
            if stream.quiet:  # it has ended, perhaps by a stop, and its program does not know yet
                raise RobotStateError(
                    f"{name} was not sent: the block of {stream!r} is open; leave it first"
                )
            raise RobotStateError(
                f"{name} was not sent: the arm follows {stream!r}; close it first"
            )

    def _accept(
        self,
        command: Command,
        task_id: int,
        accepted_at: float,
        stops: int,
        errors: Sequence[str] = (),
        deadline: float | None = None,
        on_cancel: OnCancel | None = None,
    ) -> Task:
        if not command.motion:
            on_cancel = "detach"
        elif command.continuous is not None and (on_cancel or self._settings.on_cancel) == "pause":
            on_cancel = "stop"  # a paused motion would continue later, and nothing would end it
        if deadline is None and command.continuous is not None:
            deadline = command.continuous.limit
        task = Task(
            self._coordinator,
            command,
            task_id,
            clock=self._clock,
            accepted_at=accepted_at,
            stops_before=stops,
            on_cancel=on_cancel or self._settings.on_cancel,
            deadline=deadline,
            errors_before=errors,
        )
        if command.continuous and command.continuous.timed_by_program and command.continuous.time:
            task.hold_at_end()
        self.accepted += 1
        if command.motion:
            if self._last is not None:
                self._last.life.successor_accepted()
            self._last = task
        self._coordinator.follower.follow(task)
        return task
