"""The lengths that all DUCO arms share, and their Denavit-Hartenberg tables."""

from __future__ import annotations

import math
from typing import NamedTuple

__all__ = ["Geometry"]


class Geometry(NamedTuple):
    """The six lengths of an arm whose joints 2, 3 and 4 are parallel [m].

    Attributes:
        d1: height of joint 2 above the base.
        d2: offset of the arm's plane from the axis of joint 1.
        a2: length of the upper arm.
        a3: length of the forearm.
        d5: distance from joint 4 to joint 6, along the axis of joint 5.
        d6: distance from joint 5 to the flange, along the axis of joint 6.
    """

    d1: float
    d2: float
    a2: float
    a3: float
    d5: float
    d6: float

    @property
    def a(self) -> tuple[float, ...]:
        """Link lengths of the standard convention [m]."""
        return (0.0, self.a2, self.a3, 0.0, 0.0, 0.0)

    @property
    def d(self) -> tuple[float, ...]:
        """Link offsets of the standard convention [m]."""
        return (self.d1, self.d2, 0.0, 0.0, self.d5, self.d6)

    @property
    def alpha(self) -> tuple[float, ...]:
        """Link twists of the standard convention [rad]."""
        return (-math.pi / 2, 0.0, 0.0, math.pi / 2, -math.pi / 2, 0.0)

    @property
    def theta(self) -> tuple[float, ...]:
        """Joint offsets of the standard convention [rad]: at zero the arm stands straight up."""
        return (0.0, -math.pi / 2, 0.0, math.pi / 2, 0.0, 0.0)
