"""From targets at a low rate to one place per tick: held, or on lines or cubic curves between them.

Nothing here reads a clock: one call is one tick.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from aioduco.streaming.shared.space import Config, Displacement, Space

__all__ = ["REFERENCES", "Cubic", "Linear", "Reference", "ZeroOrderHold"]

_ZERO: Displacement = (0.0,) * 6


class Reference(Protocol):
    """What brings targets to the stream's rate."""

    @property
    def ready(self) -> bool:
        """Whether the last target has had its time, so that the next one may come."""
        ...

    def aim(self, target: Config, interval: float, duration: float) -> None:
        """Take a new target.

        Args:
            target: the target.
            interval: time since the target before it [s].
            duration: time in which to meet it [s].
        """

    def step(self) -> Config:
        """Go on by one tick and return where the arm should be."""
        ...

    def rest(self, config: Config) -> None:
        """Forget the target, and stand at a point."""


class ZeroOrderHold:
    """Targets as they come, each until the next one."""

    ready = True

    def __init__(self, space: Space, period: float, start: Config) -> None:  # noqa: ARG002
        self._target = start

    def aim(self, target: Config, interval: float, duration: float) -> None:  # noqa: ARG002
        """Take a new target, to be met at once."""
        self._target = target

    def step(self) -> Config:
        """Go on by one tick and return where the arm should be."""
        return self._target

    def rest(self, config: Config) -> None:
        """Forget the target, and stand at a point."""
        self._target = config


class Linear:
    """A straight line to each target."""

    def __init__(self, space: Space, period: float, start: Config) -> None:
        self._space = space
        self._period = period
        self._from = self._target = self._now = start
        self._way: Displacement = _ZERO
        self._step = self._steps = 0

    @property
    def ready(self) -> bool:
        """Whether the last target has had its time, so that the next one may come."""
        return self._step >= self._steps

    def aim(self, target: Config, interval: float, duration: float) -> None:  # noqa: ARG002
        """Take a new target.

        Args:
            target: the target.
            interval: time since the target before it [s].
            duration: time in which to meet it [s].
        """
        self._from = self._now
        self._target = target
        self._way = self._space.difference(self._now, target)
        self._step, self._steps = 0, max(1, round(duration / self._period))

    def step(self) -> Config:
        """Go on by one tick and return where the arm should be."""
        self._step += 1
        if self._step < self._steps:
            self._now = self._space.moved(self._from, self._at(self._step / self._steps))
        else:
            self._now = self._target
        return self._now

    def rest(self, config: Config) -> None:
        """Forget the target, and stand at a point."""
        self._target = self._now = config
        self._step = self._steps = 0

    def _at(self, share: float) -> Displacement:
        return tuple(share * w for w in self._way)


class Cubic(Linear):
    """A cubic curve to each target, without a step in velocity.

    The velocity at a target comes from the last two slopes of the targets. It is zero where
    their signs differ, and small where one of them is: so a single step is not overshot.
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
            duration: time in which to meet it [s].
        """
        leaving = self._rate()
        step = self._space.difference(self._target, target)
        super().aim(target, interval, duration)
        slope = tuple(s / interval for s in step)
        self._leaving = leaving
        self._arriving = tuple(map(_slope_at_end, self._slope, slope))
        self._slope = slope

    def rest(self, config: Config) -> None:
        """Forget the target, and stand at a point."""
        super().rest(config)
        self._slope = self._arriving = _ZERO

    def _at(self, share: float) -> Displacement:
        time = self._steps * self._period
        keep = share * share * (3 - 2 * share)
        out = share * (1 - share) ** 2 * time
        come = share * share * (share - 1) * time
        return self._blend(keep, out, come)

    def _rate(self) -> Displacement:
        """The velocity of the curve where it is now; zero once the arm waits at its end."""
        if self._step > self._steps:
            return _ZERO
        if self._step == self._steps:
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


#: by way of up-sampling; "ruckig" is one that the limiter makes smooth
REFERENCES: dict[str, type[ZeroOrderHold | Linear]] = {
    "none": ZeroOrderHold,
    "linear": Linear,
    "cubic": Cubic,
    "ruckig": Cubic,
}


def _slope_at_end(before: float, last: float) -> float:
    """Velocity at the end of two segments, of second order where the motion is smooth."""
    if before * last <= 0:
        return 0.0
    most = 2 * (before if abs(before) < abs(last) else last)
    return max(min(0.0, most), min(max(0.0, most), 1.5 * last - 0.5 * before))
