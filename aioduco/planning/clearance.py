"""Distance of an arm from the nearest thing."""

from __future__ import annotations

from typing import NamedTuple

FURTHEST = 0.1
"""Distances beyond this are not told apart [m]."""
TOUCHING = 1e-6
"""Bodies that are this close, or this deep in one another, touch: they do not collide [m]."""


class Clearance(NamedTuple):
    """Distance of the arm from the nearest thing, itself included.

    Attributes:
        distance: distance, at most 0.1; below zero, the depth by which two bodies overlap [m].
        pair: names of the two bodies; None if nothing is within 0.1 m.
        point: a point between the two, in the world's frame [m].
    """

    distance: float
    pair: tuple[str, str] | None = None
    point: tuple[float, float, float] | None = None

    def __str__(self) -> str:
        if self.pair is None:
            return f"nothing within {FURTHEST * 1e3:.0f} mm"
        one, other = self.pair
        if abs(self.distance) <= TOUCHING:
            return f"{one} touches {other}"
        depth = abs(self.distance) * 1e3
        amount = f"{depth:.1f} mm" if depth >= 1.0 else f"{depth:.2g} mm"
        return (
            f"{one} is {amount} deep in {other}"
            if self.distance < 0.0
            else (f"{one} is {amount} from {other}")
        )
