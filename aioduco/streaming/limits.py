"""Speed and acceleration limits that no set-point of a stream exceeds, whatever it is fed."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from aioduco.streaming.space import Config, Displacement, Space

__all__ = ["JERK", "Limiter", "Limits"]

#: the limit of jerk where none is given: full acceleration after 0.1 s [1/s]
JERK = 10.0

_ZERO: Displacement = (0.0,) * 6
_SLACK = 1 + 1e-9  # a trajectory exactly at its limits passes in spite of rounding


class Limits(NamedTuple):
    """Limits of a stream, one number per group of its space.

    Six numbers each for joints; two each for poses, for translation and for rotation.

    Attributes:
        velocity: [rad/s], or [m/s, rad/s].
        acceleration: [rad/s²], or [m/s², rad/s²].
        jerk: [rad/s³], or [m/s³, rad/s³]; only up-sampling by ruckig keeps it.
    """

    velocity: tuple[float, ...]
    acceleration: tuple[float, ...]
    jerk: tuple[float, ...] = ()


class Limiter:
    """Follows a moving target as closely as the limits allow. Pure: one call is one tick.

    A target that moves within the limits is met exactly. Any other is approached: with the
    acceleration limit up to the speed limit, and braking in time. Each group is limited by
    itself, since the controller moves each joint by itself too (manual 1.3.5, servoj).

    Args:
        space: the space of the set-points.
        limits: velocity and acceleration; jerk is not kept here.
        period: time between two ticks [s].
        start: where the arm is, at rest.

    Attributes:
        config: the set-point of the last tick.
        limited: ticks in which the target could not be met.
    """

    __slots__ = (
        "_axes",
        "_period",
        "_rules",
        "_space",
        "_step",
        "_target",
        "config",
        "limited",
    )

    def __init__(self, space: Space, limits: Limits, period: float, start: Config) -> None:
        self._space = space
        self._period = period
        self._rules = tuple(zip(space.groups, limits.velocity, limits.acceleration, strict=True))
        # The same limits as displacements in one tick, where each axis has its own.
        self._axes = tuple(
            (v * period * _SLACK, a * period * period * _SLACK)
            for group, v, a in self._rules
            if group.stop - group.start == 1
        )
        self.config: Config = start
        self.limited: int = 0
        self._step: Displacement = _ZERO
        self._target = start

    @property
    def velocity(self) -> Displacement:
        """Velocity of the last tick, per second."""
        return tuple(step / self._period for step in self._step)

    @property
    def at_rest(self) -> bool:
        """Whether the last target is met, and nothing moves."""
        return self.config == self._target and self._step == _ZERO

    def follow(self, target: Config) -> Config:
        """One tick towards the target of this tick; returns the set-point."""
        gap = self._space.difference(self.config, target)
        moved = self._space.difference(self._target, target)
        self._target = target
        if self._axes:
            for (top, change), g, s, m in zip(self._axes, gap, self._step, moved, strict=False):
                if not (
                    -top <= g <= top and -change <= g - s <= change and -change <= g - m <= change
                ):
                    break
            else:
                self._step = gap
                self.config = target
                return target
        return self._limit(target, gap, moved)

    def _limit(self, target: Config, gap: Displacement, moved: Displacement) -> Config:
        """The tick, when the target may be beyond the limits."""
        period, velocity = self._period, self.velocity
        new: list[float] = []
        met = True
        for group, top, acceleration in self._rules:
            change = acceleration * period
            wanted = [g / period for g in gap[group]]
            speed = [m / period for m in moved[group]]
            if (
                _length(wanted) <= top * _SLACK
                and _distance(wanted, velocity[group]) <= change * _SLACK
                and _distance(wanted, speed) <= change * _SLACK
            ):
                new += wanted
                continue
            met = False
            ahead = _at_most(speed, top)
            behind = [g - a * period for g, a in zip(gap[group], ahead, strict=True)]
            closing = _closing_speed(_length(behind), acceleration, period)
            wished = [a + c for a, c in zip(ahead, _of_length(behind, closing), strict=True)]
            delta = [w - v for w, v in zip(wished, velocity[group], strict=True)]
            reached = zip(velocity[group], _at_most(delta, change), strict=True)
            new += _at_most([v + d for v, d in reached], top)
        self._step = tuple(v * period for v in new)
        if met:
            self.config = target
        else:
            self.limited += 1
            self.config = self._space.moved(self.config, self._step)
        return self.config

    def brake(self) -> Config:
        """One tick of coming to rest, all axes at the same moment; returns the set-point."""
        velocity = self.velocity
        rest = max(_length(velocity[group]) / a for group, _, a in self._rules)
        share = 1 - self._period / rest if rest > self._period else 0.0
        self._step = tuple(step * share for step in self._step)
        self.config = self._space.moved(self.config, self._step)
        self._target = self.config
        return self.config


def _length(vector: tuple[float, ...] | list[float]) -> float:
    if len(vector) == 1:
        return abs(vector[0])
    return sqrt(sum(v * v for v in vector))


def _distance(a: tuple[float, ...] | list[float], b: tuple[float, ...] | list[float]) -> float:
    if len(a) == 1:
        return abs(a[0] - b[0])
    return sqrt(sum((x - y) ** 2 for x, y in zip(a, b, strict=True)))


def _at_most(vector: list[float], length: float) -> list[float]:
    return vector if _length(vector) <= length else _of_length(vector, length)


def _of_length(vector: list[float], length: float) -> list[float]:
    now = _length(vector)
    return [v * length / now for v in vector] if now else vector


def _closing_speed(distance: float, acceleration: float, period: float) -> float:
    """The greatest speed from which the rest of a distance suffices to stop, tick by tick.

    The speeds u, u - a·dt, … down to zero cover u²/2a + u·dt/2.
    """
    half = period / 2
    speed = acceleration * (sqrt(half * half + 2 * distance / acceleration) - half)
    return min(speed, distance / period)
