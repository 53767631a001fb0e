"""Motions one behind the other, each sent while the one before it still moves the arm.

Guarantees:
- When the block is left, every motion of it has ended, or what `on_cancel` says has been done.
- No motion is sent after one before it has failed, or after the arm was stopped.
- Each motion is followed to its end, also one whose successor was sent long ago.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from aioduco.errors import DucoError, ParameterError, RobotStateError
from aioduco.supervision.command import MotionCommand

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType
    from typing import Self

    from aioduco.models.enums import Outcome
    from aioduco.supervision.task import Task

__all__ = ["MotionPath"]


class MotionPath:
    """A path made of motions, which blend; tied to a block. `robot.motion.path` makes it.

    The controller has a few motions ahead, so that each is known before the one before it comes to
    its blend. When the block is left, the arm has come to the end of the last one. If the block
    raises or is cancelled, the arm is stopped, or what `on_cancel` says.

    Attributes:
        ahead: how many motions the controller has at most, the running one included.
    """

    def __init__(self, ahead: int, stops: Callable[[], int]) -> None:
        self.ahead: int = ahead
        self._stops = stops
        self._began: int | None = None
        self._closed = False
        self._live: deque[Task] = deque()
        self._outcomes: list[Outcome] = []

    def __repr__(self) -> str:
        ended = len(self._outcomes)
        return f"<MotionPath of {ended + len(self._live)} motions, {ended} ended>"

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The motions that were sent and are not known to have ended, the earliest first."""
        return tuple(self._live)

    @property
    def outcomes(self) -> tuple[Outcome, ...]:
        """How those before them ended: finished or blended."""
        return tuple(self._outcomes)

    async def add(self, motion: MotionCommand) -> Task:
        """Send a motion behind the others, and return its task when it is accepted.

        While the controller has `ahead` motions, it waits before that until one of them has ended.
        So the program is ahead of the arm: what is to happen at a place belongs into an `op` of
        the motion, or behind the block. To be called by one task at a time.

        Args:
            motion: the motion, such as `robot.motion.movel(..., r=0.03)`.

        Raises:
            ParameterError: it is no motion; nothing was sent.
            TaskError: one before it did not succeed; nothing was sent.
            Refused: the controller refused it.
            RobotStateError: the block was left, or the arm was stopped since; nothing was sent.
            HeartbeatLost, OutcomeUnknown, ConnectionLost: as `MotionCommand.start` says.
        """
        if not isinstance(motion, MotionCommand):
            raise ParameterError("motion", motion, "a motion")
        motion.hand_over()
        if self._began is None or self._closed:
            raise RobotStateError(
                f"{motion!r} was not sent: a path takes motions within its block, "
                "async with robot.motion.path() as path"
            )
        # Where the tool will be is not known before those in front of it have ended.
        await self._until(0 if motion.aimed else self.ahead - 1)
        for earlier in self._live:
            if earlier.done:
                earlier.result()
        if self._stops() != self._began:
            await self._until(0)
            raise RobotStateError(f"{motion!r} was not sent: the arm was stopped on this path")
        task = await motion.start()
        self._live.append(task)
        if self._stops() != self._began:
            # The stop came before the motion was sent, so it did not hold for it.
            await task.cancel()
            await self._until(0)
            raise RobotStateError("the arm was stopped on this path")
        return task

    async def _until(self, most: int) -> None:
        """Wait until no more than so many motions are under way."""
        while len(self._live) > most:
            self._outcomes.append(await self._live[0])
            self._live.popleft()

    async def __aenter__(self) -> Self:
        if self._began is not None:
            raise RuntimeError("this path is tied to a block already: make another one")
        self._began = self._stops()
        return self

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._closed = True
        if exc is None:
            try:
                await self._until(0)
            except DucoError:
                await self._stop_rest()
                raise
        elif isinstance(exc, DucoError):
            await self._stop_rest()
        else:
            for task in self._live:
                if not task.done:
                    await task._forsake()
                    break

    async def _stop_rest(self) -> None:
        """One was refused, or failed: those that were sent must not go on without it."""
        for task in self._live:
            if not task.done:
                await task.cancel()
                break
