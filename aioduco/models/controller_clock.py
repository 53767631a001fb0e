"""The controller's time: the clock by which a program measures what the arm does.

Times of the arm (how long a jog lasts, until when a motion must have ended) and times of the
program (how long a call may take, when the heartbeat is due) are the same on a real arm. They
differ on a simulated arm that runs faster or slower than real time.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Callable


@runtime_checkable
class Clock(Protocol):
    """A clock of the controller's time, given to `aioduco.connect`.

    It is read on the robot's event loop, and must not block. It never goes back.
    """

    def now(self) -> float:
        """The controller's time, from an arbitrary start [s]."""
        ...

    def hold(self, at: float) -> Callable[[], None]:
        """Keep the controller's time from passing `at` until it is released.

        So a program can end a motion exactly when it is due, however long the program takes. On a
        clock that cannot be held, this has no effect.

        Args:
            at: time of this clock [s]; a time that has passed means now.

        Returns:
            A function that releases the clock. Calling it again has no effect.
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
        return release_nothing


class ScaledClock:
    """The time of a simulated controller in another process, computed from its speed.

    It is right only while that process keeps up with the speed, and cannot be held.

    Args:
        speed: the controller's seconds per second of real time, above 0 and finite.

    Raises:
        ValueError: the speed is out of range: an unlimited speed does not determine the time.
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
        return release_nothing


def release_nothing() -> None:
    """Do nothing: the release of a clock that is not held."""
