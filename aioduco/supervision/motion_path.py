"""A sequence of motions, each sent while the previous one still moves the arm.

Guarantees:
- When the block is left, every motion of it has ended, or the action of `on_cancel` has been done;
  also one that another task was sending.
- No motion is sent after an earlier one has failed, or after the arm was stopped.
- Each motion is followed to its end, also one whose successor was sent long ago.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Self

import anyio

from aioduco._process import trial
from aioduco._process.copying import Uncopied
from aioduco.errors import DucoError, ParameterError, RobotStateError
from aioduco.supervision.command import MotionCommand

if TYPE_CHECKING:
    from aioduco.models.enums import Outcome
    from aioduco.supervision.dispatcher import Dispatcher
    from aioduco.supervision.gate import Permit
    from aioduco.supervision.permits import Permits
    from aioduco.supervision.task import Task


class MotionPath(Uncopied):
    """A path of motions that blend, tied to a block. `robot.motion.path` makes it.

    The controller gets a few motions ahead, so that it has each one before the previous one comes
    to its blend. When the block is left, the arm has reached the end of the last motion. If the
    block raises or is cancelled, the arm is stopped, or the action of `on_cancel` is done. Leaving
    a block that did not raise raises the error of the first motion that failed, also one that the
    block has handled.

    Attributes:
        ahead: maximum number of motions in the controller, the running one included.
    """

    def __init__(self, ahead: int, permits: Permits, dispatcher: Dispatcher) -> None:
        self.ahead: int = ahead
        self._permits = permits
        self._dispatcher = dispatcher
        self._permit: Permit | None = None
        self._closed = False
        #: whether the block was left otherwise than at its end
        self._broken = False
        self._adding = anyio.Lock()
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
        """How the motions before those of `tasks` ended: finished or blended."""
        return tuple(self._outcomes)

    async def add(self, motion: MotionCommand) -> Task:
        """Send a motion after the others, and return its task when it is accepted.

        While the controller has `ahead` motions, this first waits until one of them has ended. So
        the program is ahead of the arm: an action at a place of the path belongs into an `op` of
        the motion, or after the block.

        Args:
            motion: the motion, such as `robot.motion.movel(..., r=0.03)`.

        Raises:
            ParameterError: it is no motion, or one of another robot; nothing was sent.
            TaskError: an earlier motion did not succeed; nothing was sent.
            Refused: the controller refused it.
            RobotStateError: the block was left, the arm was stopped, or another task is adding a
                motion; this one was not sent. If the block ended by an error or a cancellation
                while it was being sent, it was stopped.
            HeartbeatLost, OutcomeUnknown, ConnectionLost: as `MotionCommand.start` says.
        """
        if not isinstance(motion, MotionCommand):
            raise ParameterError("motion", motion, "a motion")
        motion.mark_used()
        # a stop of the other robot would not hold back what this path sends
        if not motion.moves_arm_of(self._dispatcher):
            raise ParameterError("motion", motion, "a motion of this robot")
        permit = self._permit
        if permit is None or self._closed:
            raise RobotStateError(
                f"{motion!r} was not sent: a path takes motions within its block alone"
            )
        try:
            self._adding.acquire_nowait()
        except anyio.WouldBlock:
            raise RobotStateError(
                f"{motion!r} was not sent: another task is adding a motion to this path, whose "
                "motions are sent one after another"
            ) from None
        try:
            return await self._send(motion, permit)
        finally:
            self._adding.release()

    async def _send(self, motion: MotionCommand, permit: Permit) -> Task:
        # The tool's pose is known only after the earlier motions have ended.
        await self._until(0 if motion.aimed else self.ahead - 1)
        for earlier in self._live:
            if earlier.done:
                earlier.result()
        if self._permits.gate.ending(permit) is not None:
            await self._until(0)
            raise RobotStateError(f"{motion!r} was not sent: the arm was stopped on this path")
        if self._closed:
            raise RobotStateError(f"{motion!r} was not sent: the path's block was left meanwhile")
        behind = self._live[-1] if self._live else None
        with self._permits.within(permit), trial.started():
            task = await self._dispatcher.launch(motion.command, behind=behind)
        self._live.append(task)
        if self._broken:
            await task.cancel()
            raise RobotStateError(f"{motion!r} was stopped: the path's block was left meanwhile")
        return task

    async def _until(self, most: int) -> None:
        """Wait until at most `most` motions are in progress; the block's end and `add` may both."""
        while len(self._live) > most:
            outcome = await (first := self._live[0])
            if self._live and self._live[0] is first:
                self._live.popleft()
                self._outcomes.append(outcome)

    async def __aenter__(self) -> Self:
        if self._permit is not None:
            raise RuntimeError("this path is tied to a block already: make another one")
        self._permit = self._permits.ask("path", lasting=True)
        return self

    async def __aexit__(self, _kind: object, exc: BaseException | None, _trace: object) -> None:
        self._closed = True
        self._broken = exc is not None
        if exc is None:
            try:
                await self._until(0)
                async with self._adding:  # it ends, or has sent its motion
                    await self._until(0)
            except BaseException as error:
                self._broken = True
                if isinstance(error, DucoError):
                    await self._stop_rest()
                raise
        elif isinstance(exc, DucoError):
            await self._stop_rest()
        else:
            for task in self._live:
                if not task.done:
                    await task._on_wait_cancelled()
                    break

    async def _stop_rest(self) -> None:
        """Stop the other motions after one was refused or failed: they must not run without it."""
        for task in self._live:
            if not task.done:
                await task.cancel()
                break
