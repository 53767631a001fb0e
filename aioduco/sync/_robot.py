"""How a robot for blocking programs is opened and closed."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, NoReturn

from aioduco.models.ranges import WAIT
from aioduco.sync._blocking import Block

if TYPE_CHECKING:
    from aioduco import robot as aio_robot


class _Unawaited:
    """What functions that await a robot ask first, in a robot whose calls are not awaited."""

    @staticmethod
    def from_now(name: str) -> NoReturn:
        raise TypeError(
            "this robot is for programs that do not await: write "
            f"`aioduco.sync.{name}(robot, …)`. Nothing was sent"
        )


class RobotLifecycle(Block):
    """Opening and closing a robot, by `with` or by a call."""

    _made: aio_robot.Robot

    def __del__(self) -> None:
        runner = getattr(self, "_runner", None)
        if runner is not None and runner.running:
            warnings.warn(f"unclosed {self!r}", ResourceWarning, source=self, stacklevel=2)
            runner.ask_to_close()

    def open(self) -> None:
        """Connect, check that a controller answers, and start the heartbeat.

        This is for notebooks and interactive prompts: between two cells, and while a cell computes,
        the heartbeat continues. Programs use `with`, which closes the robot in every case.

        Raises:
            ConnectError: the host is unknown, the port is closed, or nothing answers.
            NotAController: something other than a controller answers.
            ConnectTimeout: something accepts connections, but does not answer.
            RobotStateError: it was opened before.
        """
        self._runner.open()

    def close(self) -> None:
        """Stop this program's motions, wait until the arm stands, end the heartbeat, close.

        This runs to its end even if it is interrupted.

        Raises:
            StopUnconfirmed: it is not known that the arm stands.
        """
        self._runner.close()

    if not TYPE_CHECKING:  # hidden from type checkers, since these methods only raise an error

        async def __aenter__(self) -> None:
            raise TypeError(
                "this robot is for programs that do not await: write `with aioduco.sync.connect(…) "
                "as robot`, or `async with aioduco.connect(…) as robot`. Nothing was sent"
            )

        async def __aexit__(self, *_: object) -> None:
            """Do nothing: Python looks this method up before it calls `__aenter__`."""

        _permits = _Unawaited()

    def _enter(self) -> None:
        self.open()

    def _leave(self, exc: BaseException | None) -> None:  # noqa: ARG002
        self.close()

    def sleep(self, seconds: float) -> None:
        """Wait. Unlike `time.sleep`, this counts as a call: see `hold_limit` of `connect`.

        Args:
            seconds: duration of the wait [s].

        Raises:
            ParameterError: the duration is below 0.
        """
        self._runner.sleep(WAIT("seconds", seconds))


def made_of(robot: RobotLifecycle) -> aio_robot.Robot:
    """Return the robot that a blocking one stands for; one that is awaited is refused."""
    given: object = robot
    if not isinstance(given, RobotLifecycle):
        raise TypeError(
            f"robot is {given!r}, but must be one that `aioduco.sync.connect` made: in a program "
            "that awaits, leave out `sync`. Nothing was sent"
        )
    return given._made
