"""Distance of an arm from the nearest thing."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["FURTHEST", "Clearance"]

FURTHEST = 0.1
"""Distances beyond this are not told apart [m]."""


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
        if self.distance < 0.0:
            return f"{one} is {-self.distance * 1e3:.1f} mm deep in {other}"
        return f"{one} is {self.distance * 1e3:.1f} mm from {other}"
