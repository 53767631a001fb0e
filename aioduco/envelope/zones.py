"""Zones as the checker has them: distances of bodies, and when each must be computed next.

Plain floats, without I/O or clock.
"""

from __future__ import annotations

import math
from math import sqrt
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


Point: TypeAlias = tuple[float, float, float]
_Margin: TypeAlias = "Callable[[float, float, float], float]"


class CheckedZone:
    """The checker's data of one zone."""

    __slots__ = ("action", "bodies", "keep_out", "leaving", "margin", "name", "near", "speed",
                 "tolerance")  # fmt: skip

    def __init__(self, name: str, action: str, speed: float, *shape: Any) -> None:
        kind, keep_in, bodies, at, size, turn = shape
        self.name: str = name
        self.action: str = action
        self.speed: float = speed
        self.bodies: tuple[int, ...] = tuple(bodies)
        #: whether bodies must stay outside: a chord may then come nearer than both its ends
        self.keep_out: bool = not keep_in
        sign = -1.0 if keep_in else 1.0
        self.margin: _Margin
        if kind == "plane":
            self.margin = _plane(at, size)
        elif kind == "sphere":
            self.margin = _sphere(sign, at, size[0])
        else:
            self.margin = _box(sign, at, size, turn)
        #: whether a body may reach the zone in the sweep that is being checked
        self.near: bool = False
        #: whether the arm may leave it: it is not deeper beyond it at the end of a sweep
        self.leaving: bool = False
        #: small depth by which the arm was beyond the limit at the start; it may not go deeper [m]
        self.tolerance: float = 0.0


def _plane(at: Sequence[float], normal: Sequence[float]) -> _Margin:
    a, b, c = normal
    d = a * at[0] + b * at[1] + c * at[2]
    return lambda x, y, z: a * x + b * y + c * z - d


def _sphere(sign: float, at: Sequence[float], radius: float) -> _Margin:
    a, b, c = at

    def margin(x: float, y: float, z: float) -> float:
        x -= a
        y -= b
        z -= c
        return sign * (sqrt(x * x + y * y + z * z) - radius)

    return margin


def _box(sign: float, at: Sequence[float], size: Sequence[float], turn: Sequence[float]) -> _Margin:
    a, b, c = at
    hx, hy, hz = (length / 2 for length in size)
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turn

    def margin(x: float, y: float, z: float) -> float:
        x -= a
        y -= b
        z -= c
        u = abs(r00 * x + r10 * y + r20 * z) - hx
        v = abs(r01 * x + r11 * y + r21 * z) - hy
        w = abs(r02 * x + r12 * y + r22 * z) - hz
        outside = 0.0
        if u > 0.0:
            outside = u * u
        if v > 0.0:
            outside += v * v
        if w > 0.0:
            outside += w * w
        if outside:
            return sign * sqrt(outside)
        nearest = u if u > v else v
        return sign * (w if w > nearest else nearest)

    return margin


class BodyZonePair:
    """A pair of a body and a zone.

    Attributes:
        due: summed distance of the body at which the margin must be computed next [m].
    """

    __slots__ = ("body", "due", "margin", "zone")

    def __init__(self, zone: CheckedZone, body: int) -> None:
        self.zone: CheckedZone = zone
        self.body: int = body
        self.margin: _Margin = zone.margin
        self.due: float = 0.0


class BodyZonePairs:
    """The pairs of all bodies that share one summed distance.

    Attributes:
        way: upper bound of the distance that each of the bodies has moved [m].
    """

    __slots__ = ("all", "soonest", "way")

    def __init__(self, zones: Sequence[CheckedZone], bodies: Sequence[int]) -> None:
        self.all: list[BodyZonePair] = [
            BodyZonePair(zone, body) for zone in zones for body in zone.bodies if body in bodies
        ]
        self.begin()

    def begin(self) -> None:
        """Make all pairs due in the next sweep."""
        self.way: float = 0.0
        #: the smallest `due` of all pairs
        self.soonest: float = 0.0 if self.all else math.inf
        for each in self.all:
            each.due = 0.0

    def look(self, places: Sequence[Point], room: float) -> bool:
        """Compute the margins of the pairs that are due within a sweep.

        Args:
            places: positions of the bodies at the start of the sweep [m].
            room: upper bound of their distance from there during the sweep [m].

        Returns:
            Whether a body may reach a zone in the sweep; such zones are marked as near.
        """
        way = self.way
        until, soonest, near = way + room, math.inf, False
        for each in self.all:
            due = each.due
            if due <= until:
                zone = each.zone
                x, y, z = places[each.body]
                margin = each.margin(x, y, z) + zone.tolerance
                if margin > room:
                    each.due = due = way + margin
                else:  # also if the body's position is not known
                    near = zone.near = True
            if due < soonest:  # noqa: PLR1730 - min() would take longer than the rest of the loop
                soonest = due
        self.soonest = soonest
        return near
