"""The base of what blocking programs use: an object of the asyncio interface, and its runner."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self, TypeVar

from aioduco._process.copying import Uncopied
from aioduco.models.similar import MisspeltRefused

if TYPE_CHECKING:
    from collections.abc import Coroutine

    from aioduco.sync._runner import Runner


T = TypeVar("T")


class Blocking(Uncopied, MisspeltRefused):
    """An object whose functions return when they are done: they run on the robot's event loop.

    Args:
        runner: runs the robot's event loop.
        made: the same object for asyncio programs.
    """

    __slots__ = ("_made", "_runner")

    def __init__(self, runner: Runner, made: Any) -> None:
        self._runner = runner
        self._made = made

    def __repr__(self) -> str:
        return repr(self._made)

    def _call(self, work: Coroutine[Any, Any, T]) -> T:
        return self._runner.call(work)


class Block(Blocking):
    """What is used in `with`, which calls `_enter` and `_leave`."""

    def __enter__(self) -> Self:
        self._enter()
        return self

    def __exit__(self, _kind: object, exc: BaseException | None, _trace: object) -> None:
        self._leave(exc)

    def _enter(self) -> None:
        """Begin."""

    def _leave(self, exc: BaseException | None) -> None:
        """End, after an error of the block or without one."""


class Started(Block):
    """A recording, a publication or a twin: `with` or `start` begins it."""

    def start(self) -> Self:
        """Begin to record, publish or watch the robot.

        Raises:
            RobotStateError: the robot is not open, this was started before, or the twin's process
                cannot be started.
            RecordingError: the file cannot be written, or the address cannot be listened on.
            MissingExtra: the extra `record` is not installed.
        """
        self._runner.call(self._made.start(), undo=lambda _: self._made.stop())
        return self

    def stop(self) -> None:
        """Write the remaining data, and close the file, the port or the process.

        A failure is logged and not raised; it is in `error`.
        """
        if self._runner.running:
            self._runner.call(self._made.stop())

    def _enter(self) -> None:
        self.start()

    def _leave(self, exc: BaseException | None) -> None:  # noqa: ARG002
        self.stop()
