"""The controller's time: what a program measures on the arm, it measures by this.

Times of the arm (how long a jog lasts, until when a motion must have ended) and times of the
program (how long a call may take, when the heartbeat is due) are the same on a real arm. On a
simulated one that runs faster or slower than the wall they are not.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Clock", "ScaledClock", "WallClock"]


@runtime_checkable
class Clock(Protocol):
    """A clock of the controller's time, given to `aioduco.connect`.

    It is read on the robot's event loop, and does not block. It never goes back.
    """

    def now(self) -> float:
        """The controller's time, from any beginning [s]."""
        ...

    def hold(self, at: float) -> Callable[[], None]:
        """Ask that the controller's time does not pass `at` before it is let go again.

        So a program ends a motion at the time at which it is due, however long it takes to do so.
        A clock that cannot be held goes on: this then has no effect.

        Args:
            at: time of this clock [s]; one that has passed is now.

        Returns:
            Lets it go on. Calling it again has no effect.
        """
        ...


class WallClock:
    """The time of this computer, which is that of a real controller."""

    def __repr__(self) -> str:
        return "WallClock()"

    def now(self) -> float:
        """Seconds of `time.monotonic`."""
        return time.monotonic()

    def hold(self, at: float) -> Callable[[], None]:
        """No effect: this clock cannot be held."""
        del at
        return _nothing


class ScaledClock:
    """The time of a simulated controller in another process, from how fast it goes.

    It is right as far as that computer keeps up with the speed, and cannot be held.

    Args:
        speed: the controller's seconds in one of the wall, above 0.

    Raises:
        ValueError: the speed is none: one without a limit tells nothing of the time.
    """

    def __init__(self, speed: float) -> None:
        if not 0.0 < speed < float("inf"):
            raise ValueError(f"speed is {speed}, but must be above 0 and finite")
        self._speed = speed

    def __repr__(self) -> str:
        return f"ScaledClock({self._speed:g})"

    def now(self) -> float:
        """The controller's time [s]."""
        return time.monotonic() * self._speed

    def hold(self, at: float) -> Callable[[], None]:
        """No effect: this clock cannot be held."""
        del at
        return _nothing


def _nothing() -> None:
    """Let go of what was not held."""
