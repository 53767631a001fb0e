"""Where a motion of the joints leads: how long it takes, and how far it has come. Without a clock.

Only for motions whose target is known in joint angles. For all others nothing is told: their way
depends on what the controller alone knows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Course"]


@dataclass(frozen=True, slots=True)
class Course:
    """A motion of all joints together, from where the arm stands.

    Attributes:
        target: where to. Shape (6,) [rad].
        v: speed of the joint with the longest way [rad/s].
        a: its acceleration [rad/s²]; None if the controller chooses it.
    """

    target: Sequence[float]
    v: float
    a: float | None

    def seconds(self, start: Sequence[float]) -> float | None:
        """How long it takes: speed up, go on, slow down; None if that cannot be told.

        Args:
            start: joints at which it begins. Shape (6,) [rad].
        """
        if self.a is None:
            return None
        way = max(abs(end - begin) for begin, end in zip(start, self.target, strict=False))
        if way >= self.v * self.v / self.a:
            return way / self.v + self.v / self.a
        return 2.0 * math.sqrt(way / self.a)

    def part(self, start: Sequence[float], now: Sequence[float]) -> float:
        """Which part of the way has been gone, 0 to 1: along the straight line between the joints.

        Args:
            start: joints at which it began. Shape (6,) [rad].
            now: joints now. Shape (6,) [rad].
        """
        way = [end - begin for begin, end in zip(start, self.target, strict=False)]
        gone = [here - begin for begin, here in zip(start, now, strict=False)]
        square = sum(step * step for step in way)
        if square == 0.0:
            return 1.0  # it was there from the beginning
        along = sum(step * done for step, done in zip(way, gone, strict=True))
        return min(1.0, max(0.0, along / square))
