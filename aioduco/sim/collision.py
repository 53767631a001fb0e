"""Collisions, seen in what the joints' torques do not explain. No clock, no physics.

The controller compares the torques that its drives give with those that its model of arm and load
needs for the motion. What is left comes from outside, or from a load that it knows wrongly: it
cannot tell them apart, on a real arm neither.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]

__all__ = ["LEVELS", "Observer"]

#: by level of detection, torque from outside that is a collision, as a share of a joint's largest.
#: That a higher level is more sensitive, and the shares, are assumptions.
LEVELS = {0: np.inf, 1: 0.5, 2: 0.4, 3: 0.3, 4: 0.2, 5: 0.12}
#: time over which a torque is smoothed, as an observer of momentum does [s]; an assumption
SMOOTHING = 0.008


class Observer:
    """Watches the torques from outside, joint by joint.

    Args:
        effort: largest torques of the joints [N m]. Shape (6,).

    Attributes:
        level: of detection: 0 for none, 1 to 5, more sensitive with each.
        axis: joint of a collision that was not reset, 1 to 6, or 0.
        torque: from outside, smoothed [N m]. Shape (6,).
    """

    def __init__(self, effort: Vector) -> None:
        self.level: int = 3
        self.axis: int = 0
        self.torque: Vector = np.zeros(6)
        self._effort: list[float] = effort.tolist()
        self._time: float | None = None

    def reset(self) -> None:
        """Begin anew, as when brakes have held the arm."""
        self.torque = np.zeros(6)
        self._time = None

    def update(self, time: float, external: Vector) -> int:
        """Take the torques of one cycle.

        Args:
            time: of the simulation [s].
            external: what the motion needed beyond the drives' torques [N m]. Shape (6,).

        Returns:
            The joint that a collision is seen at, 1 to 6, or 0.
        """
        passed = 0.0 if self._time is None else time - self._time
        self._time = time
        gain = passed / (passed + SMOOTHING)
        # Plain floats: for six of them they are several times as fast as arrays.
        old, new = self.torque.tolist(), external.tolist()
        smooth = [before + gain * (now - before) for before, now in zip(old, new, strict=True)]
        self.torque = np.array(smooth)
        if not self.level:
            return 0
        shares = [abs(torque) / most for torque, most in zip(smooth, self._effort, strict=True)]
        largest = max(shares)
        return shares.index(largest) + 1 if largest > LEVELS[self.level] else 0
