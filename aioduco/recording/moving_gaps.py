"""Gaps in a recording while it is made: the times in which the arm moved and no sample came."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence


#: time between two samples of a moving arm [s] from which on it is a gap: a curve through them is
#: off by less than 0.1 mrad up to there, at a jerk of 100 rad/s³
MAX_GAP: Final = 0.1
#: distance between two samples [rad] from which on the arm moved between them
MOVED: Final = 3e-4


class MovingGaps:
    """Times between two samples between which the arm moved.

    Attributes:
        longest: the longest one [s].
        count: those longer than `MAX_GAP`.
    """

    def __init__(self) -> None:
        self.longest: float = 0.0
        self.count: int = 0
        self._last: tuple[float, tuple[float, ...]] | None = None

    def sampled(self, at: float, joints: Sequence[float]) -> None:
        """Take the next sample.

        Args:
            at: when it was received [s].
            joints: where the arm is to be then [rad].
        """
        here = tuple(joints)
        last, self._last = self._last, (at, here)
        if last is None or all(abs(a - b) <= MOVED for a, b in zip(here, last[1], strict=True)):
            return
        gap = at - last[0]
        self.longest = max(self.longest, gap)
        self.count += gap > MAX_GAP
