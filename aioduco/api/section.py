"""The base of the manual's sections, with which a function takes a few lines.

A function that reads something checks its arguments by `ranges` and awaits the wire:

    return await self._rpc.get_tool_digital_in(ranges.TOOL_IO("num", num))

Everything else passes its call on as a value, whose arguments the type checker checks, and which
knows its name. A setting is sent, and its answer is checked:

    await self._finish(calls.set_tool_digital_out(num_, value_, True))

A motion holds the call until it is started; `False` stands for `block`:

    return self._motion(calls.movej2(q, v_, a_, r_, False, op_, def_acc_), r_)
"""

from __future__ import annotations

from operator import not_
from typing import TYPE_CHECKING, Final, TypeVar

from aioduco._process.copying import Uncopied
from aioduco._wire.rpc import AsyncRpc, WireCall
from aioduco.errors import ParameterError, Refused, RobotStateError
from aioduco.models import ranges
from aioduco.models.enums import Outcome, TaskState
from aioduco.models.host_port import host_port
from aioduco.models.names import ManualNames
from aioduco.supervision.command import HeldMotion, MotionCommand
from aioduco.supervision.concurrency import every, run_to_completion
from aioduco.supervision.task import task_error
from aioduco.supervision.task_command import Aim, Command, shown
from aioduco.supervision.task_state import ContinuousMotion, JointEta, TaskLifecycle, added_entries

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from aioduco.models.rules import Real
    from aioduco.supervision.permits import Permits
    from aioduco.supervision.supervisor import Supervisor
    from aioduco.supervision.task_follower import TaskFollower


T = TypeVar("T")

#: seconds after which a jog without a step ends if the program gives no time
JOG_TIME: Final = 1.0
#: time for which an arm may swing after the end of its motion, and interval of the polls [s]
_SETTLING: Final = 0.5
_ASK_AGAIN: Final = 0.02
#: seconds within which the controller must have carried out a function that takes no time
_CARRY_OUT_WITHIN: Final = 10.0
#: how often a call must add to the error list to count as failed, if only the list tells; what is
#: added once may be of something else that happened meanwhile
LOOKS: Final = 2


def _finished(answer: int) -> bool:
    """Whether an answer is the end state of a task that succeeded."""
    return answer == TaskState.FINISHED


class Section(Uncopied, ManualNames):
    """A section of the manual: functions of one robot."""

    __slots__ = ("_rpc", "_supervisor")

    def __init__(self, supervisor: Supervisor) -> None:
        self._supervisor = supervisor
        #: the functions of the wire with the robot's call_timeout
        self._rpc = supervisor.rpc

    def __repr__(self) -> str:
        where = host_port(self._supervisor.host, self._supervisor.port)
        return f"<{type(self).__name__} of {where}, {self._supervisor.state}>"

    @property
    def _permits(self) -> Permits:
        return self._supervisor.permits

    @property
    def _follower(self) -> TaskFollower:
        return self._supervisor.stop_coordinator.follower

    async def _finish(self, call: WireCall[int]) -> None:
        """Call a function that answers with the end state of a task, and check that it finished."""
        await self._checked(call, self._rpc, _finished)

    async def _finish_within(self, call: WireCall[int], timeout: float) -> None:
        """The same for a call that may take long; it is made on a thread.

        Args:
            call: the call, with block true if it has that argument.
            timeout: time-out in place of the robot's call_timeout [s].
        """
        rpc = self._supervisor.blocking.within(ranges.TIMEOUT("timeout", timeout))
        await self._checked(call, rpc, _finished)

    async def _accept(self, call: WireCall[int]) -> None:
        """Call a function that returns nothing according to the manual: see `_accepted`."""
        await self._checked(call, self._rpc, _accepted)

    async def _checked(
        self, call: WireCall[int], rpc: AsyncRpc, good: Callable[[int], bool]
    ) -> None:
        """Make a call and check its answer; an error has what the call added to the error list.

        Args:
            call: the call.
            rpc: makes it.
            good: whether an answer is that of a call that succeeded.
        """
        before = await self._follower.error_list()
        await self._check(call.name, await rpc.send(call), before, good)

    async def _check(
        self,
        name: str,
        answer: int,
        before: Sequence[str],
        good: Callable[[int], bool] = _finished,
    ) -> None:
        """Check an answer; an error has what the error list has more than `before` the call."""
        if not good(answer):
            check_finished(name, answer, await self._follower.new_errors(before))

    def _motion(
        self,
        call: WireCall[int],
        r: Real = 0.0,
        *,
        superseded: bool = False,
        eta: JointEta | None = None,
        aim: Aim | None = None,
        frame: str = "",
    ) -> MotionCommand:
        """Make a motion as a value.

        Args:
            call: the call, with block false.
            r: blend radius [m].
            superseded: whether the next motion may replace it before its end.
            eta: target of the motion, if it is known in joint angles.
            aim: converts the motion into the wire's frame when it is sent.
            frame: the frame in which it is given, if there is an `aim`.
        """
        blends = superseded or bool(r > 0.0)
        command = Command(call.name, call.args, blends=blends, eta=eta, frame=frame, aim=aim)
        return MotionCommand(self._supervisor.dispatcher, command)

    def _held(
        self,
        call: WireCall[int],
        ending: str,
        *,
        time: Real | None = None,
        timed_by_program: bool = False,
        until_commanded: bool = False,
        aim: Aim | None = None,
        frame: str = "",
    ) -> HeldMotion:
        """Make a motion that runs until something ends it, as a value.

        Args:
            call: the call, with block false.
            ending: the function of the wire that ends it.
            time: seconds after which it ends; None if it does not.
            timed_by_program: whether this program, not the controller, ends it after `time`.
            until_commanded: whether it continues while the arm stands, until a command ends it.
            aim: converts the motion into the wire's frame when it is sent.
            frame: the frame in which it is given, if there is an `aim`.
        """
        continuous = ContinuousMotion(
            ending, None if time is None else float(time), timed_by_program, until_commanded
        )
        command = Command(
            *(call.name, call.args),
            blends=not until_commanded,
            continuous=continuous,
            frame=frame,
            aim=aim,
        )
        return HeldMotion(self._supervisor.dispatcher, command)

    async def _end(self, ending: str, step: Callable[[], Awaitable[None]] | None = None) -> None:
        """End a motion or a mode that runs until a command ends it.

        Args:
            ending: the function of the wire that ends it.
            step: calls it; None if it answers with the id of a task.
        """
        self._supervisor.check_open(ending)
        await self._supervisor.stop_coordinator.end(ending, step)

    async def _run_blocking(self, call: WireCall[int]) -> None:
        """Carry out a motion whose function has no `block`, and wait for its end.

        Args:
            call: the call.
        """
        supervisor, command = self._supervisor, Command(call.name, call.args)
        supervisor.check_permitted(call.name)
        before = await self._follower.error_list()
        lane, dispatcher = supervisor.blocking, supervisor.dispatcher
        answer = await dispatcher.conduct(command, lane, None, as_task=True)
        if answer > max(TaskState):
            # Not an end state, so it is the id of a task. The task is followed like any other.
            await dispatcher.adopt(command, answer, before)
        else:
            await self._check(call.name, answer, before)

    async def _block(self, motion: MotionCommand) -> TaskState:
        """Carry out a motion by the manual's blocking call, and return the state of its task.

        Raises:
            ParameterError: only a command ends it; nothing was sent.
            TaskError: it ended otherwise than by itself: one of the subclasses.
        """
        supervisor, command = self._supervisor, motion.command
        motion.mark_used()
        held = command.continuous
        if held is not None and (held.time is None or held.timed_by_program):
            raise ParameterError(
                *("motion", shown(command)),
                "one that ends by itself: a velocity for a time, or a jog with a step. "
                f"robot.motion.{command.name} makes one that a command ends",
            )
        supervisor.check_permitted(command.name)
        before = await self._follower.error_list()
        state = await motion.block(supervisor.blocking)
        if state is not TaskState.INTERRUPT or not command.blends:
            await self._check(command.name, state, before)
        return state

    async def _enter(self, call: WireCall[int], ending: str, args: tuple[bool, ...]) -> None:
        """Enter a mode in which the arm follows or gives way, for which the controller has no task.

        Args:
            call: the call.
            ending: the function of the wire that ends the mode.
            args: arguments of `ending`.
        """
        supervisor, command = self._supervisor, Command(call.name, call.args)
        lane, timeout = supervisor.calls, supervisor.settings.call_timeout
        supervisor.check_permitted(call.name)
        before = await self._follower.error_list()
        answer = await supervisor.dispatcher.conduct(command, lane, timeout, (ending, args))
        await self._check(call.name, answer, before)

    async def _feed(self, call: WireCall[int], ending: str) -> int:
        """Send points that the arm may follow at once, without a task of their own.

        Args:
            call: the call.
            ending: the function of the wire that ends the mode of the points, or removes them.

        Returns:
            The answer.
        """
        supervisor = self._supervisor
        supervisor.check_open(call.name)
        command = Command(call.name, call.args)
        return await supervisor.dispatcher.feed(command, supervisor.calls, (ending, ()))

    async def _perform(self, call: WireCall[int], timeout: float) -> None:
        """Carry out a function that becomes a task and moves nothing, and wait for its end.

        Args:
            call: the call, with block false.
            timeout: seconds within which it must end.
        """
        limit = ranges.TIMEOUT("timeout", timeout)
        self._supervisor.check_open(call.name)
        await self._supervisor.dispatcher.perform(call.name, call.args, limit)

    async def _carry_out(self, call: WireCall[int]) -> None:
        """Carry out a function that has no `block`, takes no time, and answers with a task's id."""
        self._supervisor.check_open(call.name)
        before = await self._follower.error_list()
        await self._end_of(call, await self._rpc.send(call), before)

    async def _end_of(self, call: WireCall[int], answer: int, before: Sequence[str]) -> None:
        """Wait for the end of a call that was answered; `_carry_out` describes it."""
        if answer > max(TaskState):
            command = Command(call.name, call.args, motion=False)
            task = self._supervisor.dispatcher.adopt(command, answer, before)
            await self._follower.completed(task, _CARRY_OUT_WITHIN)
        else:
            await self._check(call.name, answer, before)

    async def _begin(self, call: WireCall[int]) -> None:
        """Call a function that answers with the id of a task, which may last after what it began.

        Its state is read once: a controller answers with an id although it refuses the task.

        Args:
            call: the call.

        Raises:
            TaskError: the task has ended, and did not succeed.
            Refused: the answer is no id.
        """
        before = await self._follower.error_list()
        answer, good = await self._rpc.send(call), _finished
        if answer > max(TaskState):
            answer, good = await self._rpc.get_noneblock_taskstate(answer), _accepted
        await self._check(call.name, answer, before, good)

    async def _read_checked(
        self, call: WireCall[T], name: str, nothing: Callable[[T], bool] = not_
    ) -> T:
        """Read a value that the wire answers with zero or nothing if it cannot be read.

        Zero or nothing may also be the true value. So the value is read again: if that adds an
        entry to the controller's error list each time, the read has failed, and the entry says why.

        Args:
            call: the call.
            name: name of the value.
            nothing: whether an answer may stand for a failure: one that is zero or empty.

        Raises:
            Refused: the value could not be read.
        """
        answer, why = await self._rpc.send(call), ""
        for _ in range(LOOKS):
            if not nothing(answer):
                return answer
            answer, why = await self._send_listed(call, name)
            if not why:
                return answer
        if nothing(answer):
            raise Refused(call.name, answer, why)
        return answer

    async def _send_listed(self, call: WireCall[T], name: str) -> tuple[T, str]:
        """Make a call; return its answer, and what it has added to the controller's error list."""
        before = await self._rpc.get_last_error()
        answer = await self._rpc.send(call)
        after = await self._rpc.get_last_error()
        why = "; ".join(new_errors(before, after, call.name, name))
        if why:
            self._follower.have_told(after)
        return answer, why

    async def _carry_out_standing(self, call: WireCall[int]) -> None:
        """As `_carry_out`, of a function that would make a moving arm jump.

        Raises:
            RobotStateError: the arm moves; nothing was sent.
        """
        self._supervisor.check_open(call.name)
        async with self._supervisor.dispatcher.in_order:
            await self._check_standstill(call.name)
            before, lane = await self._follower.error_list(), self._supervisor.calls
            sent = lane.prepare(call.name, call.args)
            lane.send(sent)
            # also if this is cancelled: a motion may not come before it
            _, cancelled = await run_to_completion(sent.wait)
            if (error := cancelled or sent.error) is not None:
                raise error
            await self._end_of(call, sent.value, before)

    async def _check_standstill(self, function: str) -> None:
        """Check that the arm stands; it may swing a little after the end of a motion."""
        ticker = every(_ASK_AGAIN)
        until = ticker.due + _SETTLING
        async for due in ticker:
            stands = not await self._rpc.robotmoving()
            # after the question: a motion that begins meanwhile counts
            if self._supervisor.stop_coordinator.moving or due >= until:
                break
            if stands:
                return
        raise RobotStateError(
            f"{function} was not sent: the arm moves, and would move in an unforeseen way; "
            "wait until all motions have ended, or stop it"
        )


def new_errors(
    before: Sequence[str], after: Sequence[str], function: str, name: str
) -> Sequence[str]:
    """Return the new entries of the controller's error list, which drops its oldest entries.

    A list full of equal entries does not change with one more of them. Then an entry counts as new
    if it contains `name` and does not begin with the name of another function of the wire.

    Args:
        before: the list before the call.
        after: the list after the call.
        function: the function that was called.
        name: name of the value that the call was about.
    """
    new = added_entries(before, after)
    if new or len(after) < 2 or set(after) != {after[0]} or name not in after[0]:
        return new
    teller = after[0].partition(":")[0]
    return () if teller != function and hasattr(AsyncRpc, teller) else after[:1]


def check_finished(function: str, answer: int, errors: Sequence[str] = ()) -> None:
    """Check the end state of a task that a blocking function returned.

    Args:
        function: the function of the wire.
        answer: what it returned.
        errors: what the controller's error list says of it.

    Raises:
        TaskError: the task did not succeed: one of the subclasses.
        Refused: the answer is not an end state of a task.
    """
    state = TaskState(answer)
    if state is TaskState.FINISHED:
        return
    if not state.ended:
        why = "; ".join(errors) or "it does not take these arguments in its present state"
        raise Refused(function, answer, why)
    life = TaskLifecycle()
    life.observe(state)
    outcome = life.outcome or Outcome.UNKNOWN
    raise task_error(function, None, outcome, errors)


def checked_task_id(function: str, answer: int) -> int:
    """Check the id of a task that is not followed, and return it.

    Args:
        function: the function of the wire.
        answer: what it returned.

    Raises:
        Refused: the answer is not an id.
    """
    if answer < 0:
        raise Refused(function, answer, "it does not take these arguments in its present state")
    return answer


def _accepted(answer: int) -> bool:
    """Whether an answer is that of a function that returns nothing according to the manual.

    The wire nevertheless returns a number. A negative number is a failure, and so is the end
    state of a task that failed; any other number means only that the call was accepted. So does 0:
    the manual gives it no meaning here, and a function without a value may well answer with it.
    Programs of the vendor's class do not look at it; to refuse it would refuse what has been done.
    """
    return _finished(answer) or (answer >= 0 and not TaskState(answer).ended)
