"""Streams whose set-points are speeds or increments: they are ramped, and end at zero."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aioduco.streaming.limits import Limits
    from aioduco.streaming.space import Config, Displacement, Space

__all__ = ["Rates"]

_ZERO: Displacement = (0.0,) * 6


class Rates:
    """Follows a speed within a limit of its size and of its change.

    Args:
        space: whose groups are limited, each by its length.
        limits: `velocity` is the largest speed, `acceleration` its change per second.
        period: time between two ticks [s].

    Attributes:
        config: the speed of the last tick.
        limited: ticks in which the limits kept it from what was asked for.
    """

    ready = True

    def __init__(self, space: Space, limits: Limits, period: float) -> None:
        self._rules = tuple(zip(space.groups, limits.velocity, limits.acceleration, strict=True))
        self._period = period
        self._target: Displacement = _ZERO
        self.config: Config = _ZERO
        self.limited: int = 0

    @property
    def at_rest(self) -> bool:
        """Whether it is zero, and to stay so."""
        return self.config == self._target == _ZERO

    def aim(self, target: Config, interval: float, duration: float) -> None:  # noqa: ARG002
        """Take a new speed, to be met as soon as the limits allow it."""
        self._target = target

    def step(self) -> Config:
        """Go on by one tick and return the speed."""
        if self.config == self._target:
            return self.config
        new: list[float] = []
        for group, top, change in self._rules:
            now = self.config[group]
            wanted = _at_most(self._target[group], top)
            delta = tuple(w - n for w, n in zip(wanted, now, strict=True))
            step = _at_most(delta, change * self._period)
            if step is delta:
                new += wanted
            else:
                new += (n + s for n, s in zip(now, step, strict=True))
        self.config = tuple(new)
        self.limited += self.config != self._target
        return self.config

    def brake(self) -> Config:
        """Go on by one tick of coming to rest, all axes at the same moment."""
        self._target = _ZERO
        rest = max(_length(self.config[group]) / change for group, _, change in self._rules)
        share = 1 - self._period / rest if rest > self._period else 0.0
        self.config = tuple(r * share for r in self.config) if share else _ZERO
        return self.config


def _length(vector: tuple[float, ...]) -> float:
    return sqrt(sum(v * v for v in vector))


def _at_most(vector: tuple[float, ...], length: float) -> tuple[float, ...]:
    """The vector itself, or a shorter one of the same direction."""
    now = _length(vector)
    return vector if now <= length else tuple(v * length / now for v in vector)
