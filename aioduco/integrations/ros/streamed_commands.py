"""When commands that arrive as a stream may be followed: of joints, of speeds, for hand guiding.

Guarantee: after a stop, further commands are ignored. They are followed again only after they have
ceased, or after the arm was brought up or recovered.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import anyio

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco import Robot, WorkerOptions
    from aioduco._process.reporting import BackgroundLogger


_AGAIN = 2.0  # seconds before a warning of the same kind is logged again


class StreamedCommands:
    """Commands for one arm, followed by a stream that is open while they arrive.

    Args:
        robot: the robot, open.
        log: the logger for refused commands.
        busy: returns whether something else uses the arm, such as a trajectory goal.
        timeout: time without commands after which the stream ends [s].
        options: options of the stream; None: in a separate process.

    Attributes:
        following: whether the stream is open.
    """

    def __init__(
        self,
        robot: Robot,
        log: BackgroundLogger,
        *,
        busy: Callable[[], bool],
        timeout: float,
        options: WorkerOptions | None,
    ) -> None:
        self._robot = robot
        self._busy = busy
        self._timeout = timeout
        self._options = options
        self.following: bool = False
        self._came = -math.inf
        self._blocked = False
        self._changed = anyio.Event()
        self._log = log
        self._said: dict[str, float] = {}

    def _opened(self) -> None:
        """Note that the stream is open."""
        self.following = True

    def _ended(self) -> None:
        """Note that the stream has ended, so that the arm is free."""
        self.following = False

    def allow(self) -> None:
        """Accept commands again: the arm was brought up or recovered."""
        self._blocked = False

    def ignore(self) -> None:
        """Ignore the commands that arrive at present: the arm is stopped or paused."""
        if anyio.current_time() - self._came <= self._timeout:
            self._block()

    def _block(self) -> None:
        """Ignore commands until they cease, those that are not followed yet, too."""
        self._blocked = True
        self._came = anyio.current_time()  # time in which this driver stood still does not count

    def _note_command(self) -> float:
        """Note that a command has come; return when [s]."""
        now = anyio.current_time()
        if now - self._came > self._timeout:
            self._blocked = False
        self._came = now
        return now

    def _warn(self, kind: str, text: str, *values: object) -> None:
        """Log a warning that may come with every message, unless one of its kind was just now."""
        now = anyio.current_time()
        if now - self._said.get(kind, -math.inf) > _AGAIN:
            self._said[kind] = now
            self._log.warning(text, *values)
