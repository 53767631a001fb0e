"""Commands that become tasks: what is sent, apart from sending it."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol, get_args

from aioduco.errors import ParameterError
from aioduco.models.ranges import TIMEOUT as SECONDS
from aioduco.supervision.task import OnCancel

if TYPE_CHECKING:
    from collections.abc import Generator
    from types import TracebackType

    from aioduco.models.enums import Outcome
    from aioduco.supervision.task import Task
    from aioduco.supervision.task_state import ContinuousMotion, JointEta

__all__ = ["Aim", "Command", "HeldMotion", "MotionCommand"]


@dataclass(frozen=True, slots=True)
class Command:
    """A call that the controller answers with the id of a task.

    Attributes:
        name: the function of the wire.
        args: its arguments, checked and converted, with block false.
        motion: whether it moves the arm.
        blends: whether it asks to be blended into the motion after it, or to be taken over by it.
        continuous: how it comes to its end, if it goes on until something ends it.
        eta: where it leads, if that is known in joint angles.
    """

    name: str
    args: tuple[Any, ...]
    motion: bool = True
    blends: bool = False
    continuous: ContinuousMotion | None = None
    eta: JointEta | None = None


class CommandDispatcher(Protocol):
    """What sends a command, as a motion sees it."""

    async def launch(
        self,
        command: Command,
        *,
        deadline: float | None = None,
        on_cancel: OnCancel | None = None,
    ) -> Task:
        """Send a command and return its task."""
        ...


class Aim(Protocol):
    """What turns a motion into the frame of the wire, by where the tool is when it is sent."""

    @property
    def frame(self) -> str:
        """The frame in which the motion is given."""
        ...

    async def arguments(self, command: Command) -> tuple[Any, ...]:
        """Read where the tool is, and return the arguments in the frame of the wire."""
        ...


class MotionCommand:
    """A motion as a value: checked, but not sent. It moves the arm when it is awaited or started.

    - `await motion` sends it and waits for its end; it raises unless it finished.
    - `task = await motion.start()` returns as soon as the controller has accepted it.
    - `async with motion as task:` ties it to a block: it has ended when the block is left, by
      itself, or by a stop if the block raised or was cancelled.

    It may be used again: each time moves the arm anew. One that was never used warns, as a
    coroutine does.
    """

    __slots__ = ("__weakref__", "_aim", "_dispatcher", "_open", "_used", "command")

    def __init__(
        self, dispatcher: CommandDispatcher, command: Command, aim: Aim | None = None
    ) -> None:
        self._dispatcher = dispatcher
        self._aim = aim
        self._used = False
        self._open: Task | None = None
        self.command: Command = command

    def __repr__(self) -> str:
        shown = ", ".join(_short(arg) for arg in self.command.args)
        frame = "" if self._aim is None else f", frame={self._aim.frame!r}"
        return f"<{self.command.name}({shown}{frame})>"

    def __del__(self) -> None:
        if not getattr(self, "_used", True):
            warnings.warn(
                f"the motion {self!r} was never awaited or started: the arm did not move",
                RuntimeWarning,
                source=self,
                stacklevel=2,
            )

    @property
    def aimed(self) -> bool:
        """Whether it depends on where the tool is when it is sent, so that it is not sent ahead."""
        return self._aim is not None

    def hand_over(self) -> None:
        """Say that somebody else sees to this motion: it will not warn that it was not used."""
        self._used = True

    async def start(
        self, *, deadline: float | None = None, on_cancel: OnCancel | None = None
    ) -> Task:
        """Send the motion and return its task as soon as the controller has accepted it.

        If this is cancelled, a motion that was sent is stopped; one that was not is not sent.

        Args:
            deadline: seconds after which the arm is stopped if the motion has not ended; None
                for no such limit.
            on_cancel: what happens to the arm if the await of the task is cancelled: "stop",
                "pause", or "detach" (it moves on); None for what the robot was opened with.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: the controller refused it.
            RobotStateError: the robot is being closed, or its heartbeat does not beat.
            OutcomeUnknown: it was sent, but not answered; the arm was stopped.
            ConnectionLost: it was not sent.
        """
        self.hand_over()
        if deadline is not None:
            deadline = SECONDS("deadline", deadline)
        if on_cancel is not None and on_cancel not in get_args(OnCancel):
            raise ParameterError("on_cancel", on_cancel, '"stop", "pause" or "detach"')
        command = self.command
        if self._aim is not None:
            command = replace(command, args=await self._aim.arguments(command))
        return await self._dispatcher.launch(command, deadline=deadline, on_cancel=on_cancel)

    def __await__(self) -> Generator[Any, Any, Outcome]:
        # Here and not in the coroutine: one that is never awaited gives its own warning.
        self.hand_over()
        return self._run().__await__()

    async def _run(self) -> Outcome:
        task = await self.start()
        return await task

    async def __aenter__(self) -> Task:
        if self._open is not None:
            raise RuntimeError(f"{self!r} is tied to a block already: make another one like it")
        self._open = await self.start()
        return self._open

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        task, self._open = self._open, None
        assert task is not None
        if exc is None:
            await task
        elif not task.done:
            await task.forsake()


class HeldMotion(MotionCommand):
    """A motion that goes on: at a velocity, a jog, hand guiding. It is best tied to a block.

    - `async with motion as task:` ends it when the block is left, and returns when the arm stands.
    - `await motion` waits until its time is over, or until it was told to end from elsewhere.
    - `task = await motion.start()` returns as soon as the controller has accepted it;
      `await task.end()` ends it.

    Its end is when the arm stands. If it goes on for two seconds after its time, the arm is
    stopped.
    """

    __slots__ = ()

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        task, self._open = self._open, None
        assert task is not None
        if exc is None:
            await task.end()
        elif not task.done:
            await task.forsake()


def _short(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_short(each) for each in value)}]"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
