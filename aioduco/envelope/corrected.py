"""Positions of a calibrated arm's bodies, whose joints have a table of their own.

In plain floats: the worker of a stream checks each set-point by them, and has no numpy.
"""

from __future__ import annotations

import math
from math import cos, sin
from operator import add
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.envelope.zones import Point


class CorrectedTable:
    """The Denavit-Hartenberg table of an arm with corrections.

    Args:
        lengths: d1, d2, a2, a3, d5 and d6 [m].
        corrections: what each joint has more of a, d [m], alpha and theta [rad]. Shape (4, 6).
    """

    __slots__ = ("_links", "_rows")

    def __init__(self, lengths: Sequence[float], corrections: Sequence[Sequence[float]]) -> None:
        d1, d2, a2, a3, d5, d6 = lengths
        right = math.pi / 2
        own_a, own_d, own_alpha, own_theta = corrections
        a = [*map(add, (0.0, a2, a3, 0.0, 0.0, 0.0), own_a)]
        d = [*map(add, (d1, d2, 0.0, 0.0, d5, d6), own_d)]
        alpha = [*map(add, (-right, 0.0, 0.0, right, -right, 0.0), own_alpha)]
        theta = [*map(add, (0.0, -right, 0.0, right, 0.0, 0.0), own_theta)]
        self._links = list(zip(map(abs, a), map(abs, d), strict=True))
        self._rows = tuple(zip(theta, map(cos, alpha), map(sin, alpha), a, d, strict=True))

    def reaches(self, tip: float) -> tuple[tuple[float, ...], tuple[float, float]]:
        """Return how far the bodies are from the axes of the joints, at most.

        Args:
            tip: distance of the tip from the flange [m].

        Returns:
            Of the tip from the axis of each joint; of the elbow from the first two [m].
        """
        lengths = list(map(sum, self._links))
        of_tip = tuple([self._links[i][0] + sum(lengths[i + 1 :]) + tip for i in range(6)])
        return of_tip, (self._links[0][0] + lengths[1], self._links[1][0])

    def places(self, q: Sequence[float], offset: Sequence[float]) -> tuple[Point, ...]:
        """Return the positions of tip, elbow and flange in the base frame [m].

        Args:
            q: joints. Shape (6,) [rad].
            offset: the tip in the flange's frame [m].
        """
        # the axes of a joint's frame, and its origin
        x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
        at = elbow = (0.0, 0.0, 0.0)
        for number, (angle, (turn, ca, sa, a, d)) in enumerate(zip(q, self._rows, strict=True)):
            c, s = cos(angle + turn), sin(angle + turn)
            x, side = _mixed(c, x, s, y), _mixed(-s, x, c, y)
            at = _mixed(1.0, _mixed(1.0, at, a, x), d, z)
            y, z = _mixed(ca, side, sa, z), _mixed(-sa, side, ca, z)
            if number == 1:
                elbow = at
        u, v, w = offset
        tip = _mixed(1.0, _mixed(1.0, at, u, x), 1.0, _mixed(v, y, w, z))
        return tip, elbow, at


def _mixed(a: float, one: Point, b: float, other: Point) -> Point:
    """The sum of two vectors, each times a number."""
    x, y, z = one
    u, v, w = other
    return a * x + b * u, a * y + b * v, a * z + b * w
