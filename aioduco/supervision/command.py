"""A motion as a value, which a program awaits, starts, or ties to a block."""

from __future__ import annotations

import sys
import warnings
from typing import TYPE_CHECKING, Any, get_args

from aioduco._process import trial
from aioduco._process.copying import Uncopied
from aioduco.errors import MotionCarriedOut, ParameterError
from aioduco.models.enums import Outcome, TaskState
from aioduco.models.ranges import TIMEOUT as SECONDS
from aioduco.models.words import one_of
from aioduco.supervision.permits import Permits, asked_at_call
from aioduco.supervision.task import OnCancel, Task
from aioduco.supervision.task_command import Command, blocking, shown

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable

    from aioduco._wire.lane import WireLane
    from aioduco.supervision.dispatcher import Dispatcher


class MotionCommand(Uncopied):
    """A motion as a value: checked, but not sent. It moves the arm when it is awaited or started.

    - `await motion` sends it and waits for its end; it raises unless it finished.
    - `task = await motion.start()` returns as soon as the controller has accepted it.
    - `async with motion as task:` ties it to a block: when the block is left, the motion has
      ended, by itself, or by a stop if the block raised or was cancelled. Leaving a block that did
      not raise raises the motion's error, as `await task` does, also one that the block has
      handled: a `try` around the block handles both.

    It is no coroutine, so `asyncio.create_task` does not accept it: `start` returns a task. One
    that is given to `asyncio.gather` is asked for when its task begins: no stop before ends it.

    It may be used again: each use moves the arm again. A motion that was never used gives a
    warning, as a coroutine does.
    """

    __slots__ = ("__weakref__", "_dispatcher", "_open", "_tied", "_used", "command")

    #: how to send a motion that was not sent
    _HINT = "await it, or `task = await motion.start()` to go on beside it"

    def __init__(self, dispatcher: Dispatcher, command: Command) -> None:
        self._dispatcher = dispatcher
        self._used = False
        self._tied = False
        self._open: Task | None = None
        self.command: Command = command
        if trial.current is not None:
            trial.current.made(self)

    def __repr__(self) -> str:
        # asyncio puts this into its TypeError when `create_task` is given a motion
        hint = "" if self._used else f": not sent; {self._HINT}"
        frame = f" frame={self.command.frame!r}" if self.command.frame else ""
        return f"<{shown(self.command)}{frame}{hint}>"

    def __del__(self) -> None:
        used: bool = getattr(self, "_used", True)
        if trial.current is not None and hasattr(self, "command"):
            trial.current.forgotten(self, shown(self.command), used=used)
        if not used:
            # the names of the arguments are not there any more when the interpreter ends
            what = self.command.name if sys.is_finalizing() else shown(self.command)
            warnings.warn(
                f"the motion <{what}> was never awaited or started: the arm did not move",
                RuntimeWarning,
                source=self,
                stacklevel=2,
            )

    @property
    def _permits(self) -> Permits:
        return self._dispatcher.permits

    @property
    def aimed(self) -> bool:
        """Whether it depends on what is there when it is sent, so that it is not sent ahead."""
        return self.command.aim is not None

    def mark_used(self) -> None:
        """Mark this motion as used, so that it does not warn that it was never used."""
        self._used = True

    def moves_arm_of(self, dispatcher: Dispatcher) -> bool:
        """Whether it moves the arm of the robot to which this dispatcher belongs."""
        return self._dispatcher is dispatcher

    @asked_at_call
    async def start(
        self, *, deadline: float | None = None, on_cancel: OnCancel | None = None
    ) -> Task:
        """Send the motion and return its task as soon as the controller has accepted it.

        If this is cancelled, a motion that was sent is stopped; otherwise it is not sent at all.
        A stop or a pause after the call ends it, too, also before a task or the loop of another
        thread has begun it.

        Args:
            deadline: seconds after which the arm is stopped if the motion has not ended; None
                for no such limit.
            on_cancel: what happens to the arm if the await of the task is cancelled: "stop",
                "pause", or "detach" (it moves on); None for the `on_cancel` of the robot.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: the controller refused it.
            RobotStateError: the robot is being closed, or its heartbeat is not running.
            TaskStopped: the arm was stopped after the call; nothing was sent.
            OutcomeUnknown: it was sent, but not answered; the arm was stopped.
            ConnectionLost: it was not sent.
        """
        self.mark_used()
        if deadline is not None:
            deadline = SECONDS("deadline", deadline)
        if on_cancel is not None:
            one_of("on_cancel", on_cancel, get_args(OnCancel))
        with trial.started():
            return await self._dispatcher.launch(
                self.command, deadline=deadline, on_cancel=on_cancel
            )

    async def block(self, lane: WireLane) -> TaskState:
        """Send the motion by the manual's blocking call, and return its state at its end.

        Args:
            lane: lane on which it is sent.
        """
        return await self._dispatcher.block(blocking(self.command), lane)

    def __await__(self) -> Generator[Any, Any, Outcome]:
        # Here and not in the coroutine: a coroutine that is never awaited gives its own warning.
        self.mark_used()
        return self._run().__await__()

    async def _run(self) -> Outcome:
        task = await self._dispatcher.launch(self.command)
        held = self.command.continuous
        if held is not None and held.mode and held.time is None:
            return Outcome.FINISHED  # it was entered; to leave it is another call
        return await task

    async def __aenter__(self) -> Task:
        if self._tied:
            raise RuntimeError(f"{self!r} is tied to a block already: make another one like it")
        self.mark_used()
        self._tied = True  # before it is sent: another task must not tie it meanwhile
        try:
            self._open = await self._dispatcher.launch(self.command)
        except BaseException:
            self._tied = False
            raise
        return self._open

    async def __aexit__(self, _kind: object, exc: BaseException | None, _trace: object) -> None:
        task, self._open, self._tied = self._open, None, False
        assert task is not None
        if exc is None:
            await (task if self.command.continuous is None else task.end())
        elif not task.done:
            await task._on_wait_cancelled()


class HeldMotion(MotionCommand):
    """A continuous motion: at a velocity, a jog, hand guiding. It is best tied to a block.

    - `async with motion as task:` ends it when the block is left, and returns when the arm stands.
    - `await motion` waits until its time is over, or until other code ends it.
    - `task = await motion.start()` returns as soon as the controller has accepted it;
      `await task.end()` ends it.

    It has ended when the arm stands. If it continues for two seconds after its time, or is paused
    when it is to be ended, the arm is stopped.
    """

    __slots__ = ()

    _HINT = "use it in `async with`, or `task = await motion.start()`"


def check_motions(given: Iterable[object], kind: type, meant: str) -> None:
    """Check that all objects to run are motions.

    Args:
        given: the objects to run.
        kind: the class of motions.
        meant: the correct code, for a caller that carried out a motion instead of passing it.

    Raises:
        MotionCarriedOut: an object is the outcome of a motion.
        ParameterError: an object is no motion for another reason.
    """
    for number, each in enumerate(given):
        if isinstance(each, kind):
            continue
        listed = list(each) if isinstance(each, (list, tuple)) else [each]
        for one in listed:
            if isinstance(one, Outcome):
                raise MotionCarriedOut(f"motions[{number}]", one, meant)
        for one in listed:
            if isinstance(one, MotionCommand):
                one.mark_used()  # the error replaces the warning
        hint = ""
        if listed and all(isinstance(one, kind) for one in listed):
            hint = " by itself, not a list of them: write run(first, second) or run(*motions)"
        raise ParameterError(f"motions[{number}]", each, f"a motion{hint}")
