"""The open streams of a robot, as its supervision sees them: at most one, ended by any stop.

Guarantees:
- `halt` is synchronous and waits for nothing. After it, a lane sends at most the set-point that is
  on its way.
- That one may reach the controller behind a stop, and set the arm moving again. So whoever stops
  the arm calls `halt`, sends the stop, waits for `settled` or `quiet`, and sends it once more.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

import anyio

from aioduco.errors import RobotStateError

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["OpenStream", "Streams"]

_LOOK = 0.001  # seconds between two looks at whether a lane is quiet


class OpenStream(Protocol):
    """What the supervision needs of a stream."""

    @property
    def quiet(self) -> bool:
        """Whether its lane can send nothing any more; from any thread."""
        ...

    def halt(self) -> None:
        """Send nothing more, at once; from any thread or signal handler."""

    def kill(self) -> None:
        """End a lane that does not end by itself."""

    async def ended(self) -> None:
        """Wait until its lane is gone."""


class Streams:
    """The open streams of one robot: at most one, since the arm can follow only one."""

    def __init__(self) -> None:
        self._open: list[OpenStream] = []

    def __len__(self) -> int:
        return len(self._open)

    def __iter__(self) -> Iterator[OpenStream]:
        return iter(tuple(self._open))

    def __repr__(self) -> str:
        return f"<Streams {self._open}>"

    def add(self, stream: OpenStream) -> None:
        """Take a stream that is being opened.

        Raises:
            RobotStateError: another one is open.
        """
        for other in self:
            raise RobotStateError(
                f"{other!r} is open on this robot; close it before you open another one. "
                "Nothing was sent"
            )
        self._open.append(stream)

    def remove(self, stream: OpenStream) -> None:
        """Forget a stream that is over."""
        if stream in self._open:
            self._open.remove(stream)

    def halt(self) -> bool:
        """Have no stream send anything more; from any thread or signal handler.

        Returns:
            Whether there was a stream.
        """
        streams = tuple(self._open)
        for stream in streams:
            stream.halt()
        return bool(streams)

    async def settled(self, timeout: float) -> None:
        """Wait until no lane can send anything more; one that goes on after that is ended.

        Args:
            timeout: seconds for that.
        """
        for stream in self:
            with anyio.move_on_after(timeout) as scope:
                await stream.ended()
            if scope.cancelled_caught:
                stream.kill()

    def quiet(self, timeout: float) -> None:
        """As `settled`, from any thread, without ending anything.

        Args:
            timeout: seconds to wait.
        """
        start = time.monotonic()
        looks = 0
        while not all(stream.quiet for stream in self):
            looks += 1
            due = start + looks * _LOOK
            if due > start + timeout:
                return
            time.sleep(max(0.0, due - time.monotonic()))
