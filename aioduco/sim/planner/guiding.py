"""Hand guiding (牵引示教, manual 1.3.5, teach_mode): the arm carries its weight and gives way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.planner.follower import Follower
from aioduco.sim.planner.mover import SetPoint

if TYPE_CHECKING:
    from aioduco.models.rotation import Array

__all__ = ["Guiding"]

_GIVING = 0.8  # share of a joint's speed that the drives do not resist; an assumption
_STICKING = 0.01  # speed below which a joint that nobody pushes is held [rad/s]
_LOOSE = 0.001  # distance by which a held joint has to be pushed to come loose [rad]


class Guiding(Follower):
    """Commands the joints to be where they are.

    What the drives do against gravity they do anyway; of the speed they command a part, so that
    what is left damps the motion. A joint that hardly moves is held until it is pushed away.
    """

    _held: Array | None = None

    def _next(self, q: Array, qd: Array) -> SetPoint:
        if self._held is None:
            if float(np.abs(qd).max()) < _STICKING:
                self._held = q
        elif float(np.abs(q - self._held).max()) > _LOOSE:
            self._held = None
        if self._held is not None:
            return SetPoint.at_rest(self._held)
        return SetPoint(q + self._cycle * qd, _GIVING * qd, np.zeros(6))
