"""Brings the arm to rest: on request, on cancellation, at the interpreter's exit.

Guarantees:
- Cancelling the await of a motion returns only when the arm stands, or raises `StopUnconfirmed`.
- A motion or mode that continues until it is ended is ended when its time is over, and along with a
  stop.
- A command that may still be on its way to the controller is waited for: no caller gets the result
  that the arm stands while a command may arrive that makes it move again.
- The controller may serve a stop before a command that was sent before it. Whoever sent that
  command stops the arm once more, and ends the mode that it has entered.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import anyio

from aioduco._process import trial
from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import (
    ControllerError,
    DucoError,
    HeartbeatLost,
    OutcomeUnknown,
    StopUnconfirmed,
)
from aioduco.models.enums import Outcome, ProgramState, TaskState
from aioduco.models.samples import joints as joints_of
from aioduco.supervision.command_result import give_up, may_move, stopped_on_its_way, taken, void
from aioduco.supervision.concurrency import BackgroundTasks, every, run_to_completion
from aioduco.supervision.gate import Gate, Permit, PermitEnding
from aioduco.supervision.motion_sources import (
    ModeEnding,
    Modes,
    OpenStream,
    halt_streams,
    silence,
    wait_until_quiet,
)
from aioduco.supervision.rest import bring_to_rest
from aioduco.supervision.stop_channel import StopChannel, refusal
from aioduco.supervision.task_command import Command
from aioduco.supervision.task_follower import END_LIMIT, TaskFollower
from aioduco.supervision.unanswered import UnansweredMotion

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection, Mapping, Sequence

    from aioduco._wire.channel import LaneCall
    from aioduco._wire.lane import WireLane
    from aioduco.supervision.loop_watchdog import Liveness
    from aioduco.supervision.permits import Permits
    from aioduco.supervision.settings import RobotSettings
    from aioduco.supervision.task import Task


_log = BackgroundLogger(__name__)

#: seconds for a pause or a resume to be carried out
_PAUSE_LIMIT = 10.0
#: seconds for the controller to return where the arm is
_ASK_LIMIT = 0.5
#: seconds between two looks at what is waited for
_LOOK_EVERY = 0.05
#: seconds within which a peer acknowledges received bytes, on any network that carries motions
_ACKNOWLEDGED = 0.25
#: seconds within which an arm that its controller stops has come to rest
_BRAKED = 1.0


class StopCoordinator:
    """Stops, pauses and resumes the arm.

    Args:
        channel: sends stop, pause, resume and abort.
        poll: lane on which tasks are polled.
        background: runs coroutines that no caller waits for.
        settings: times and limits.
        liveness: notes that the program may move the arm, before anything is sent that may do so.
        beats_lapsed: whether the controller has stopped the arm by itself, for want of beats.
        permits: given by the gate, which is closed while the arm is brought to rest.

    Attributes:
        follower: follows the tasks.
        unfollowed_motion: whether a motion may be running that is not followed. A stop ends that.
        modes: modes that this program has switched on.
        pending: commands on their way that may move the arm, each with the mode that it enters, as
            for `Modes.enter`, or None. A command stays here until its sender has its result:
            meanwhile it is neither on its way nor known to move the arm otherwise.
        streams: the open streams, at most one, since the arm can follow only one; they are ended
            before the arm is brought to rest.
        closed: whether the connections are closed, so that nothing can be sent any more.
        worker_died: whether a stream's worker has died, perhaps with a set-point on its way.
        confirmed: number of stops that were requested when the last one that was confirmed began.
        require_samples: called with the name of what resumes; raises while an envelope is not
            watched.
    """

    def __init__(
        self,
        channel: StopChannel,
        poll: WireLane,
        background: BackgroundTasks,
        settings: RobotSettings,
        liveness: Liveness,
        beats_lapsed: Callable[[], bool],
        permits: Permits,
    ) -> None:
        self.permits = permits
        self.gate: Gate = permits.gate
        self._channel = channel
        self._beats_lapsed = beats_lapsed
        self._poll = poll
        self._settings = settings
        self.liveness = liveness
        self.follower: TaskFollower = TaskFollower(poll, self, background, settings.clock)
        self.unfollowed_motion: bool = False
        self.modes: Modes = Modes(channel, liveness.in_modes)
        self.pending: dict[LaneCall, ModeEnding | None] = {}
        self.streams: list[OpenStream] = []
        self.closed: bool = False
        self.worker_died: bool = False
        self.require_samples: Callable[[str], object] = lambda _: None
        self.confirmed: int = 0

    @property
    def stops(self) -> int:
        """Number of requested stops."""
        return self.gate.stops

    @property
    def moving(self) -> bool:
        """Whether anything that this program started or resumed may be moving the arm."""
        return self.gate.resumed or self.busy

    @property
    def busy(self) -> bool:
        """Whether anything that this program started moves the arm, or may still do so."""
        taskless = self.unfollowed_motion or self.modes.moving or self.pending or self.streams
        return bool(taskless or self.follower.motions)

    def permits_ended(self, ending: PermitEnding) -> None:
        """End what sends by itself, at once; from any thread or signal handler.

        Args:
            ending: why the permits have ended.
        """
        if ending is not PermitEnding.PAUSED:
            self.modes.overdue()
        if ending.stops:
            halt_streams(self.streams)
            return
        for stream in tuple(self.streams):
            stream.withdraw(ending)
        why = HeartbeatLost(ending.value)
        if ending is PermitEnding.HUNG:
            why = HeartbeatLost(
                "the program's event loop did not run for longer than "
                f"{self._settings.loop_stall_limit:g} s (loop_stall_limit)"
                + (". robot.rearm_heartbeat() lets it move the arm again" if self.gate.hung else "")
            )
        for task in self.follower.tasks:
            task.stopped_by = task.stopped_by or why

    def _on_their_way(self) -> dict[LaneCall, ModeEnding | None]:
        """Of `pending`, what was sent: what waits for a connection is refused after a stop."""
        return {call: mode for call, mode in self.pending.items() if call.handed_over}

    async def stands(self) -> bool:
        """Return whether the arm stands; also True if the controller cannot report it."""
        try:
            return not await self._channel.moving()
        except ControllerError:
            return True
        except DucoError:
            return False

    async def halt(self) -> None:
        """Stop the arm, and wait until it stands and nothing on its way can move it again.

        Raises:
            StopUnconfirmed: it is not known that it stands, or that it keeps standing.
        """
        settings = self._settings
        with self.gate.stop():
            # Of these, the controller may serve any after the stop.
            overtaken, stops = self._on_their_way(), self.stops
            await self.send_stop(settings.stop_timeout)
            await self.rest(settings.stop_timeout, settings.standstill_timeout, overtaken)
            self.confirmed = max(self.confirmed, stops)

    async def send_stop(self, timeout: float) -> None:
        """Stop the arm: it is then slowing down, and no stream or mode makes it move again.

        Args:
            timeout: seconds within which the controller must accept a stop.

        Raises:
            StopUnconfirmed: it accepted none in time.
        """
        streaming = halt_streams(self.streams)
        if self.modes.stoppable or streaming:
            try:
                await self._channel.stop(timeout)
            finally:
                if streaming:
                    await self._silence_streams()
                await self.modes.leave()
        await self._channel.stop(timeout)

    async def _silence_streams(self) -> None:
        for stream in tuple(self.streams):
            if await silence(stream):
                self.worker_died = True

    async def rest(
        self,
        stop_timeout: float | None,
        timeout: float,
        overtaken: Mapping[LaneCall, ModeEnding | None] | None = None,
    ) -> None:
        """Wait until the arm stands.

        Args:
            stop_timeout: seconds within which a further stop must be accepted, if the arm still
                moves; None to wait without a further stop.
            timeout: seconds within which the arm must stand.
            overtaken: commands that were on their way when the stop was sent, as `pending`.

        Raises:
            StopUnconfirmed: it is not known that it stands.
        """
        await self._channel.rest(stop_timeout, timeout)
        if stop_timeout is not None:
            on_their_way = {**(overtaken or {}), **self._on_their_way()}
            if on_their_way or self.worker_died:
                await self.stop_until_certain(on_their_way)
            self.unfollowed_motion = False

    def stop_now(self, timeout: float) -> None:
        """Send a stop from any thread or signal handler, and block until it is accepted.

        Args:
            timeout: seconds within which the controller must accept it.

        Raises:
            StopUnconfirmed: it accepted none in time.
        """
        with self.gate.stop():
            streaming = halt_streams(self.streams)
            interrupt = self._channel.stop_now(timeout)
            if streaming:
                wait_until_quiet(self.streams)
                interrupt = self._channel.stop_now(timeout) or interrupt
            if interrupt is not None:
                raise interrupt

    def check_loop(self, what: str) -> None:
        """Raise `WrongLoop` or `WrongProcess` if `what` is not to be done on this event loop."""
        self._poll.owner_loop.require(what)

    async def joints(self) -> Sequence[float]:
        """Read where the arm is [rad]; it raises what `Task.progress` does."""
        return joints_of(await self._poll.call("get_actual_joints_position", (), _ASK_LIMIT))

    async def stop_stream(self, ending: str) -> None:
        """Stop the arm after a stream's worker has died, or could not bring it to rest.

        Args:
            ending: the function of the wire that ends the mode of the stream; may be empty.
        """
        if ending:
            self.modes.enter(ending)
        # if this stop fails, too, the robot is stopped again when it is left
        self.worker_died = self.unfollowed_motion = True
        await self.stop()

    async def leave_modes(self, timeout: float) -> None:
        """Leave every mode that this program has entered, because it closes the robot.

        Args:
            timeout: seconds for each step of leaving a mode that needs a standing arm.
        """
        await self.modes.leave()
        await self.modes.end_force_control(timeout, self.follower.complete)

    def begin_stop(self) -> None:
        """Send a stop before anything else runs on the event loop; `stop` must be awaited next."""
        self.gate.end(PermitEnding.STOPPED)
        self._channel.begin(self._settings.stop_timeout)

    async def stop(self) -> None:
        """As `halt`, to its end even if cancelled; then wait until the motions have ended."""
        _, cancelled = await run_to_completion(self.halt)
        if cancelled is not None:
            raise cancelled
        await self.follower.motions_ended()

    async def answered(
        self,
        lane: WireLane,
        permit: Permit,
        command: Command,
        timeout: float | None,
        *,
        followed: bool,
        mode: ModeEnding | None = None,
        enters: bool = True,
    ) -> tuple[LaneCall, BaseException | None]:
        """Send a command that may move the arm, and wait until its result is certain.

        The arm is stopped if the answer does not come in time, or if it leaves open whether the arm
        will move. If the caller does not follow the command, the arm is also stopped if this is
        cancelled, or if a stop may have overtaken the command. This then returns when no part of
        the command can move the arm any more.

        Args:
            lane: lane on which to send it.
            permit: checked as the last thing before it is sent.
            command: the command.
            timeout: seconds for its answer; None if it is answered at the end of the motion.
            followed: whether the caller follows the task of the command, and stops it if necessary.
            mode: the mode in which the arm then moves, as for `Modes.enter`; None if there is none.
            enters: whether it enters that mode: unless it is refused, a stop ends it from now on.

        Returns:
            The command, which is over, and the last cancellation that came meanwhile: the caller
            must raise it.

        Raises:
            StopUnconfirmed: it is not known that the arm stands, and keeps standing.
        """
        limit = None if timeout is None else timeout + self._settings.unanswered_timeout
        call = lane.prepare(command.name, command.args, limit, self.permits.last_check(permit))
        is_new = mode is not None and enters and not self.modes.enter(*mode)
        entered = mode[0] if mode is not None and is_new else ""
        self.pending[call] = mode
        interrupt: BaseException | None = None
        try:
            try:
                lane.send(call)
            except BaseException as exc:  # what a signal handler raises: some of it may be sent
                interrupt = exc
            cancelled = await self._certain(call, permit, timeout, entered, followed=followed)
        except BaseException as exc:
            if not isinstance(exc, StopUnconfirmed):
                # There was no memory, or a signal's handler raised.
                self.unfollowed_motion = True
                await self._stop_unanswered(call)
            raise
        else:
            if mode is not None and taken(call, followed=followed) and self.overtaken(permit):
                self.modes.enter(*mode)  # the stop may have ended it before it was entered
            return call, cancelled or interrupt
        finally:
            del self.pending[call]

    async def _certain(
        self, call: LaneCall, permit: Permit, timeout: float | None, entered: str, *, followed: bool
    ) -> BaseException | None:
        """Wait until the result of a command is certain; `answered` describes it.

        `entered` is what ends the mode that it enters, if that was not on; else it is empty.
        """
        cancelled: BaseException | None = None
        if followed:
            _, cancelled = await run_to_completion(lambda: call.wait(timeout))
        else:
            try:
                with anyio.move_on_after(timeout):
                    while not (call.handed_over and self.overtaken(permit)):
                        if await call.wait(_LOOK_EVERY):
                            break
            except BaseException as exc:
                cancelled = exc
        if not call.handed_over:
            give_up(call)
        unsure = call.ended_at is None or may_move(call.error)
        overtaken = not followed and call.error is None and self.overtaken(permit)
        if not self.closed and (unsure or overtaken or (cancelled is not None and not followed)):
            again = await self._stop_unanswered(call)
            cancelled = again or cancelled
            if call.error is None and overtaken:
                call.error = stopped_on_its_way(call.name, self.gate.ending(permit))
            elif call.error is None and timeout is not None:
                call.error = OutcomeUnknown(call.name, "it was answered late, and the arm stopped")
        elif entered and call.answered and not taken(call, followed=followed):
            self.modes.over(entered)
        give_up(call)  # the robot was closed meanwhile
        return cancelled

    def overtaken(self, permit: Permit) -> bool:
        """Whether the arm was stopped since a permit was asked for, perhaps before its command."""
        return self.gate.ending(permit) not in (None, PermitEnding.PAUSED)

    async def _stop_unanswered(self, call: LaneCall) -> BaseException | None:
        _log.warning("the arm is stopped, and watched until nothing can come any more of %r", call)
        begin = time.monotonic()

        async def stop() -> None:
            with self.gate.stop():
                await self.stop_until_certain({call: self.pending[call]}, since=begin)

        _, cancelled = await run_to_completion(stop)
        return cancelled

    async def stop_until_certain(
        self, commands: Mapping[LaneCall, ModeEnding | None], since: float | None = None
    ) -> None:
        """Stop the arm, and return when none of the commands can move it any more.

        Args:
            commands: commands that may or may not reach the controller, as `pending`.
            since: when that began [s of `time.monotonic`]; None for now.

        Raises:
            StopUnconfirmed: they may still move it.
        """
        self.unfollowed_motion = True
        settings, now = self._settings, time.monotonic()
        answer_by = (now if since is None else since) + settings.unanswered_timeout
        until = answer_by + settings.stop_timeout + settings.standstill_timeout

        async def stop() -> None:
            self._enter_again(commands)
            await self.send_stop(settings.stop_timeout)

        def reset() -> None:
            for call in commands:
                give_up(call)

        motion = UnansweredMotion(now, answer_by, until)
        with trial.at_own_pace():
            certain = await bring_to_rest(
                *(motion, stop, self._channel.moving),
                report=lambda: self._report_delivery(motion, commands),
                reset=reset,
            )
        if self.closed:
            return  # the code that closed the robot has already done what was possible
        if not certain:
            names = ", ".join(command.name for command in commands) or "a set-point"
            raise StopUnconfirmed(
                f"{names} was sent, and it is not known what became of it: the arm may be "
                "moving, or begin to. Press the emergency stop"
            )
        if self._enter_again(commands):
            await self.modes.leave()
        self.unfollowed_motion = self.worker_died = False

    def _report_delivery(self, motion: UnansweredMotion, commands: Collection[LaneCall]) -> bool:
        """Tell `motion` what became of commands; discard the unsent bytes of one that is stuck.

        Returns:
            Whether the controller can still be polled.
        """
        if self.closed:
            return False
        now = time.monotonic()
        for call in commands:
            if now - call.begun > _ACKNOWLEDGED and call.undelivered > 0:
                give_up(call)
        ended = [call.ended_at for call in commands if call.ended_at is not None]
        if len(ended) < len(commands):
            return True
        if self.worker_died or not all(call.answered for call in commands):
            # Since then, and not since it is noticed: the stop that was sent meanwhile took longer.
            motion.connection_reset(max(ended, default=now))
        else:
            motion.answered(now)
        return True

    def _enter_again(self, commands: Mapping[LaneCall, ModeEnding | None]) -> bool:
        """Note the modes of commands on their way, which may be entered after they were left.

        Returns:
            Whether there are any.
        """
        modes = [mode for call, mode in commands.items() if mode and not void(call)]
        for mode in modes:
            self.modes.enter(*mode)
        return bool(modes)

    async def cancelled_while_waiting(self, task: Task) -> None:
        """Do what the `on_cancel` of a task says after its await was cancelled, then return."""
        if task.done or task.on_cancel == "detach" or self._poll.owner_loop.in_forked_child:
            return
        self.check_loop(f"await {task.name}")
        if task.on_cancel == "pause":
            try:
                await run_to_completion(self.pause)
            except DucoError as exc:
                _log.error("%r could not be paused, so the arm is stopped: %s", task, exc)
            else:
                return
        await self._halt_and_see()

    async def _halt_and_see(self) -> None:
        """Stop the arm, and return only when the end of each motion is known, even if cancelled."""
        await run_to_completion(self.halt)
        await run_to_completion(self.follower.motions_ended)

    async def end(
        self,
        name: str,
        step: Callable[[], Awaitable[None]] | None = None,
        answered: Callable[[], None] | None = None,
    ) -> None:
        """End a continuous motion by its own function, and wait until the arm stands.

        If this program's motion, or its mode, is paused or cannot be ended this way, or if this is
        cancelled, the arm is stopped.

        Args:
            name: the function of the wire.
            step: calls the function; None if it answers with the id of a task.
            answered: called when the function was answered, or has failed, before the arm stands.

        Raises:
            TaskStopped: it is paused: its program's next motion would move the arm.
        """
        if name == "stop":
            step = self.halt
        tasks = self.follower.tasks
        continuous = [each for each in tasks if each.continuous and each.continuous.ending == name]
        of_mode = name in self.modes
        try:
            try:
                await self.follower.require_unpaused(name, continuous, mode=of_mode)
                for task in continuous:
                    task.life.end_sent()
                await (step() if step is not None else self._controlled(name))
            finally:
                if answered is not None:
                    answered()
            await self._come_to_rest(name, () if of_mode else continuous)
            with anyio.move_on_after(END_LIMIT):
                for task in continuous:
                    await task.wait()
            await self.follower.require_unpaused(name, continuous)
        except BaseException:
            if continuous or of_mode:
                await self._halt_and_see()
            raise

    async def _come_to_rest(self, name: str, ended: Sequence[Task]) -> None:
        """Wait until the arm stands after `name`; if that had no effect, stop the arm.

        `ended` are the motions that it was to end. Once each was seen at rest, what moves is a
        later motion, which the program started meanwhile.
        """
        self.modes.over(name)
        try:
            await self.standstill()
        except StopUnconfirmed as exc:
            if ended and all(task.outcome is Outcome.FINISHED and not task.fault for task in ended):
                return
            _log.warning("%s had no effect, so the arm is stopped: %s", name, exc)
            await self.halt()

    async def pause(self) -> bool:
        """Pause all tasks, and wait until the arm stands; beside an open stream, stop it instead.

        Returns:
            Whether anything is paused, as far as that is known.
        """
        with self.gate.stop(PermitEnding.PAUSED):
            # Of these, the controller may serve any after the pause.
            overtaken = self._on_their_way()
            if self.streams:
                # A stream follows a clock, and cannot go on later; nor may what it has sent.
                await self.send_stop(self._settings.stop_timeout)
                self.unfollowed_motion |= self.worker_died
            # What looks as if it were over goes on, too: its task has ended, or it has none.
            ended = any(task.life.continues_after_task for task in self.follower.tasks)
            self.unfollowed_motion |= self.gate.resumed or ended
            await self._controlled("pause")
            for call in overtaken:
                if call.deadline is not None:
                    await call.wait(self._settings.call_timeout)  # else its sender stops the arm
            until = time.monotonic() + self._settings.call_timeout
            async for due in every(_LOOK_EVERY):
                if overtaken:
                    await self._controlled("pause")
                # Only this tells that the controller has a call that is answered at its end.
                if all(call.ended_at or call.deadline for call in overtaken) or await self.paused():
                    break
                if due >= until:
                    await self.halt()
                    break
            await self.standstill()
        return await self.paused()

    async def resume(self) -> bool:
        """Resume all paused tasks; if this fails or is cancelled, the arm is stopped.

        Returns:
            Whether anything was paused, as far as that is known.

        Raises:
            StaleState: there is an envelope, and it is not watched; nothing was sent.
        """
        permit = self.permits.ask("resume")
        await self.permits.after_stops(permit)
        paused = await self.paused()
        self.require_samples("resume")
        self.permits.check(permit)
        self.liveness.will_move("resume")
        # Motions of other programs are resumed, too, and are this program's from now on.
        self.gate.resume()
        lane, timeout = self._channel.others, self._settings.call_timeout
        command = Command("resume", (False,))
        call, cancelled = await self.answered(lane, permit, command, timeout, followed=False)
        if (error := cancelled or call.error or refusal("resume", call.value)) is not None:
            raise error
        try:
            await self.follower.complete("resume", call.value, _PAUSE_LIMIT, permit.stops)
        except BaseException:
            await self._halt_and_see()
            raise
        return paused

    async def paused(self) -> bool:
        """Whether something is paused; True also if the controller does not say."""
        if any(task.state is TaskState.PAUSED for task in self.follower.tasks):
            return True
        try:
            states: list[int] = await self._poll.call("get_robot_state", (), _ASK_LIMIT)
        except DucoError:
            return True
        return len(states) < 2 or states[1] in (ProgramState.PAUSED, ProgramState.PAUSING)

    async def abort(self) -> None:
        """End the running motion and those read ahead, and wait until the arm stands.

        If this fails or is cancelled before, the arm is stopped.
        """
        try:
            with self.gate.stop():
                overtaken = self._on_their_way()
                if halt_streams(self.streams):
                    await self._silence_streams()
                await self._controlled("abort")
                await self.modes.leave()
                await self.standstill()
                if overtaken or self.worker_died:
                    await self.stop_until_certain(overtaken)
        except BaseException as exc:
            if not isinstance(exc, StopUnconfirmed):
                await self._halt_and_see()
            raise

    async def standstill(self, stops_before: int | None = None) -> None:
        """Wait until the arm stands, without a stop.

        Args:
            stops_before: of a stopped motion, the number of stops that were requested before it:
                after a later one that was confirmed, or beside a motion that was asked for after a
                later one, what moves is not this motion. None: whatever moves counts.

        Raises:
            StopUnconfirmed: it is not known that it stands.
        """

        def is_another() -> bool:
            if stops_before is None:
                return False
            later = any(task.stops_before > stops_before for task in self.follower.motions)
            return later or self.confirmed > stops_before

        await self._channel.rest(None, self._settings.standstill_timeout, is_another)

    async def lapsed(self) -> HeartbeatLost:
        """Wait until the controller has stopped the arm, as no heartbeat came; return the error.

        Without a heartbeat, or while beats are answered, this never returns.
        """
        since: float | None = None
        async for due in every(_LOOK_EVERY):
            if not self._beats_lapsed():
                since = None
            elif since is None:
                since = due
            elif due - since >= _BRAKED:
                break
        return HeartbeatLost(
            "no heartbeat could be given to the controller: it has stopped the arm by itself, if "
            "no other program gives it heartbeats. No stop of this program was answered yet; it is "
            "tried on, and motions wait for that"
        )

    async def _controlled(self, name: str) -> None:
        stops = self.stops
        answer = await self._channel.control(name)
        for task in self.follower.tasks:
            task.release_clock()  # `name` was sent, or the arm was stopped: its time continues
        await self.follower.complete(name, answer, _PAUSE_LIMIT, stops)
