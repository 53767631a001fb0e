"""Up-sampling of targets to one position per tick: held, or on lines or cubic curves between them.

This module reads no clock: one call is one tick.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aioduco.streaming.shared.space import Config, Displacement, Space


_ZERO: Displacement = (0.0,) * 6
_ROUNDING = 1e-9  # of a number of ticks


class Linear:
    """A straight line to each target; or each target at once, held until the next one.

    Args:
        space: the space of the targets.
        period: time between two ticks [s].
        start: where the arm is.
        held: whether each target is taken at once (zero-order hold).
    """

    def __init__(self, space: Space, period: float, start: Config, *, held: bool = False) -> None:
        self._space = space
        self._held = held
        self._period = period
        self._from = self._target = self._now = start
        self._way: Displacement = _ZERO
        #: ticks since the target before the last one was due, and until the last one is
        self._step = self._steps = 0.0

    @property
    def ready(self) -> bool:
        """Whether the time of the last target is over in this tick: the next one can be taken."""
        return self._left < 1 - _ROUNDING

    @property
    def met(self) -> bool:
        """Whether the last target is reached."""
        return self._held or self._left <= 0

    @property
    def _left(self) -> float:
        """Ticks until the last target is due; negative after it."""
        return self._steps - self._step

    def aim(self, target: Config, interval: float, duration: float) -> None:  # noqa: ARG002
        """Take a new target.

        Args:
            target: the target.
            interval: time since the target before it [s].
            duration: time in which to reach it [s].
        """
        before, self._target = self._target, target
        # A target may be due between two ticks: the time of the next one begins then.
        rest = max(0.0, self._left) if self.ready else 0.0
        self._from = before if rest else self._now
        self._way = self._space.difference(self._from, target)
        self._step, self._steps = -rest, max(1.0, duration / self._period)

    def step(self) -> Config:
        """Advance by one tick and return the arm's desired position."""
        self._step += 1
        if self._step < self._steps and not self._held:
            self._now = self._space.moved(self._from, self._at(self._step / self._steps))
        else:
            self._now = self._target
        return self._now

    def reset(self, config: Config) -> None:
        """Discard the target, and stay at a point."""
        self._target = self._now = config
        self._step = self._steps = 0.0

    def _at(self, share: float) -> Displacement:
        return tuple(share * w for w in self._way)


class Cubic(Linear):
    """A cubic curve to each target, without a step in velocity.

    The velocity at a target is computed from the last two slopes of the targets. It is zero if
    their signs differ, and small if one of them is small, so a single step is not overshot.
    """

    def __init__(self, space: Space, period: float, start: Config) -> None:
        super().__init__(space, period, start)
        self._slope: Displacement = _ZERO
        self._leaving: Displacement = _ZERO
        self._arriving: Displacement = _ZERO

    def aim(self, target: Config, interval: float, duration: float) -> None:
        """Take a new target.

        Args:
            target: the target.
            interval: time since the target before it [s].
            duration: time in which to reach it [s].
        """
        leaving = self._rate()
        step = self._space.difference(self._target, target)
        super().aim(target, interval, duration)
        slope = tuple(s / interval for s in step)
        self._leaving = leaving
        self._arriving = tuple(map(_slope_at_end, self._slope, slope))
        self._slope = slope

    def reset(self, config: Config) -> None:
        """Discard the target, and stay at a point."""
        super().reset(config)
        self._slope = self._arriving = _ZERO

    def _at(self, share: float) -> Displacement:
        time = self._steps * self._period
        keep = share * share * (3 - 2 * share)
        out = share * (1 - share) ** 2 * time
        come = share * share * (share - 1) * time
        return self._blend(keep, out, come)

    def _rate(self) -> Displacement:
        """The velocity of the curve where the next one begins; zero while the arm waits there."""
        if self._left < -_ROUNDING:
            return _ZERO
        if self.ready:
            return self._arriving
        time = self._steps * self._period
        share = self._step / self._steps
        keep = 6 * share * (1 - share) / time
        return self._blend(keep, (1 - share) * (1 - 3 * share), share * (3 * share - 2))

    def _blend(self, keep: float, out: float, come: float) -> Displacement:
        return tuple(
            keep * w + out * a + come * b
            for w, a, b in zip(self._way, self._leaving, self._arriving, strict=True)
        )


def interpolator(way: str, space: Space, period: float, start: Config) -> Linear:
    """The interpolator of an up-sampling method; for "ruckig" the limiter smooths the motion."""
    if way in ("cubic", "ruckig"):
        return Cubic(space, period, start)
    return Linear(space, period, start, held=way == "none")


def _slope_at_end(before: float, last: float) -> float:
    """Velocity at the end of two segments; of second order where the motion is smooth."""
    if before * last <= 0:
        return 0.0
    most = 2 * (before if abs(before) < abs(last) else last)
    return max(min(0.0, most), min(max(0.0, most), 1.5 * last - 0.5 * before))
