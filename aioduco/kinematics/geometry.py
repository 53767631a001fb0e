"""The lengths that all DUCO arms share, and their Denavit-Hartenberg tables."""

from __future__ import annotations

import math
from typing import NamedTuple

LENGTHS = ("d1", "d2", "a2", "a3", "d5", "d6")
"""The six lengths of `Geometry`, in order."""


class DhCorrections(NamedTuple):
    """What one arm adds to the table of its model: the result of a calibration.

    Attributes:
        a: link lengths [m], six.
        d: link offsets [m], six.
        alpha: link twists [rad], six.
        theta: joint offsets [rad], six.
    """

    a: tuple[float, ...] = (0.0,) * 6
    d: tuple[float, ...] = (0.0,) * 6
    alpha: tuple[float, ...] = (0.0,) * 6
    theta: tuple[float, ...] = (0.0,) * 6


class Geometry(NamedTuple):
    """The six lengths of an arm whose joints 2, 3 and 4 are parallel [m].

    Attributes:
        d1: height of joint 2 above the base.
        d2: offset of the arm's plane from the axis of joint 1.
        a2: length of the upper arm.
        a3: length of the forearm.
        d5: distance from joint 4 to joint 6, along the axis of joint 5.
        d6: distance from joint 5 to the flange, along the axis of joint 6.
        corrections: what one arm adds to the table of these lengths; None for nothing. With them,
            joints 2, 3 and 4 need not be parallel: inverse kinematics then improve the solutions
            of the six lengths step by step.
    """

    d1: float
    d2: float
    a2: float
    a3: float
    d5: float
    d6: float
    corrections: DhCorrections | None = None

    @property
    def lengths(self) -> tuple[float, float, float, float, float, float]:
        """The six lengths alone [m]."""
        return self[:6]

    @property
    def a(self) -> tuple[float, ...]:
        """Link lengths of the standard convention [m]."""
        return self._corrected((0.0, self.a2, self.a3, 0.0, 0.0, 0.0), 0)

    @property
    def d(self) -> tuple[float, ...]:
        """Link offsets of the standard convention [m]."""
        return self._corrected((self.d1, self.d2, 0.0, 0.0, self.d5, self.d6), 1)

    @property
    def alpha(self) -> tuple[float, ...]:
        """Link twists of the standard convention [rad]."""
        return self._corrected((-math.pi / 2, 0.0, 0.0, math.pi / 2, -math.pi / 2, 0.0), 2)

    @property
    def theta(self) -> tuple[float, ...]:
        """Joint offsets of the standard convention [rad]: at zero the arm stands straight up."""
        return self._corrected((0.0, -math.pi / 2, 0.0, math.pi / 2, 0.0, 0.0), 3)

    def _corrected(self, column: tuple[float, ...], number: int) -> tuple[float, ...]:
        if self.corrections is None:
            return column
        return tuple(map(sum, zip(column, self.corrections[number], strict=True)))
