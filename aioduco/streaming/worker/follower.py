"""Followers of the program's targets, tick by tick, within the limits and within an envelope."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco.streaming.worker.interpolation import REFERENCES
from aioduco.streaming.worker.limiter import JerkLimiter, Limiter, Rates

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.envelope.checker import EnvelopeChecker
    from aioduco.envelope.limits import Crossing
    from aioduco.streaming.shared.space import Config, Displacement, Limits, Space
    from aioduco.streaming.worker.interpolation import Reference

__all__ = ["CheckedFollower", "CheckedRates", "Follower"]

#: deviation from the straight line, as a share of its length, if each axis brakes in its own time;
#: 7 % for two axes
_DEVIATION = 0.1
#: the same for one step of the closer check; larger, because the last step ends with cubic motion
_DEVIATION_OF_STEP = 0.4
_STEPS = 16


class Follower:
    """A reference and the limiter that follows it.

    Args:
        way: one of `REFERENCES`.
        space: the space of the set-points.
        limits: limits of velocity and acceleration; for "ruckig" also of jerk.
        period: time between two ticks of the stream [s].
        start: position of the arm, at rest.
        reference: reference to use instead of one of `REFERENCES`; it starts at `start`.
    """

    def __init__(
        self,
        way: str,
        space: Space,
        limits: Limits,
        period: float,
        start: Config,
        reference: Reference | None = None,
    ) -> None:
        self._reference: Reference = reference or REFERENCES[way](space, period, start)
        kind = JerkLimiter if way == "ruckig" else Limiter
        self._limiter = kind(space, limits, period, start)

    @property
    def config(self) -> Config:
        """The set-point of the last tick."""
        return self._limiter.config

    @property
    def velocity(self) -> Displacement:
        """Velocity of the set-point, per second."""
        return self._limiter.velocity

    @property
    def limited(self) -> int:
        """Ticks in which the limits kept the set-point from the reference."""
        return self._limiter.limited

    @property
    def ready(self) -> bool:
        """Whether the time of the last target is over, so that the next one can be taken."""
        return self._reference.ready

    @property
    def at_rest(self) -> bool:
        """Whether the last target is met and the set-point is at rest."""
        return self._reference.ready and self._limiter.at_rest

    def aim(self, target: Config, interval: float, duration: float) -> None:
        """Take a new target, to be reached if the limits allow it.

        Args:
            target: the target.
            interval: time since the target before it [s].
            duration: time in which to reach it [s].
        """
        self._reference.aim(target, interval, duration)

    def step(self) -> Config:
        """Advance by one tick and return the set-point."""
        return self._limiter.follow(self._reference.step())

    def brake(self) -> Config:
        """Brake for one tick within the limits and return the set-point."""
        config = self._limiter.brake()
        self._reference.reset(config)
        return config


class CheckedFollower(Follower):
    """A follower that sends only set-points from which the arm can stop within the envelope.

    From every set-point the arm can come to rest within the limits of the stream and within the
    envelope. A set-point that breaks this is not sent; the follower brakes from the one before it.

    Args:
        way: one of `REFERENCES`.
        space: the space of the set-points.
        limits: limits of velocity and acceleration; for "ruckig" also of jerk.
        period: time between two ticks of the stream [s].
        start: position of the arm, at rest.
        checker: checks configurations of the arm.
        seen: converts a set-point into a configuration for the checker.
        crossed: callback with the limit that would have been crossed; it must end the stream.
        reference: reference to use instead of one of `REFERENCES`; it starts at `start`.
    """

    def __init__(
        self,
        way: str,
        space: Space,
        limits: Limits,
        period: float,
        start: Config,
        checker: EnvelopeChecker,
        seen: Callable[[Config], Sequence[float]],
        crossed: Callable[[Crossing], None],
        reference: Reference | None = None,
    ) -> None:
        super().__init__(way, space, limits, period, start, reference)
        self._space = space
        self._period = period
        self._checker = checker
        self._configuration = seen
        # With a jerk limit each axis comes to rest in its own time, so the path is not straight.
        self._checker.deviation = _DEVIATION if way == "ruckig" else 0.0
        self._crossed = crossed
        self._seen = seen(start)

    def begin(self) -> Crossing | None:
        """Check the arm's position, and return the limit that it is beyond, if any."""
        return self._checker.begin(self._seen)

    def step(self) -> Config:
        """Advance by one tick, or brake, and return the set-point."""
        limiter = self._limiter
        snapshot = limiter.snapshot()
        config = super().step()
        here = self._configuration(config)
        found = self._look(config, here)
        if found is None:
            self._seen = here
            return config
        limiter.restore(snapshot)
        if found.action != "slow":
            self._crossed(found)
            return self.brake()
        config = limiter.brake()
        self._braked(config)
        return config

    def brake(self) -> Config:
        """Brake for one tick within the limits and return the set-point."""
        config = super().brake()
        self._braked(config)
        return config

    def _braked(self, config: Config) -> None:
        self._seen = self._configuration(config)
        self._checker.moved(self._seen)

    def _look(self, config: Config, here: Sequence[float]) -> Crossing | None:
        checker = self._checker
        speed = math.inf
        if checker.times:
            # The last position first: the checker still has it cached.
            before, now = checker.places(self._seen)[0], checker.places(here)[0]
            speed = math.dist(before, now) / self._period
            found = checker.too_fast(speed)
            if found is not None:
                return found
        limiter = self._limiter
        if isinstance(limiter, Limiter) and checker.clear(here, limiter.ticks_to_rest()):
            return None
        rest = limiter.braking()
        if not any(rest):
            return checker.sweep(here, here, speed)
        found = checker.sweep(here, self._configuration(self._space.moved(config, rest)), speed)
        if found is None or found.action == "slow":
            return found
        return self._look_closer(here, speed)

    def _look_closer(self, here: Sequence[float], speed: float) -> Crossing | None:
        """Check the braking path in small steps: for one large step the bound is too large."""
        checker = self._checker
        seed, deviation = checker.seed, checker.deviation
        checker.deviation = deviation and _DEVIATION_OF_STEP
        try:
            for config in self._limiter.stopping(_STEPS):
                there = self._configuration(config)
                found = checker.sweep(here, there, speed)
                if found is not None:
                    return found
                here = there
            return None
        finally:
            checker.seed, checker.deviation = seed, deviation


class CheckedRates(Rates):
    """Speeds within limits, with which the arm can come to rest within the envelope.

    Speeds that break this are not sent; the stream brakes from those before them.

    Args:
        space: the space whose groups are limited, each by its length.
        limits: `velocity` is the largest speed, `acceleration` its largest change per second.
        period: time between two ticks [s].
        look: returns the limit that the arm would cross with speeds, if any, and the share of them
            that is allowed.
        crossed: callback with the limit that would have been crossed; it must end the stream.
    """

    config: Config
    limited: int

    def __init__(
        self,
        space: Space,
        limits: Limits,
        period: float,
        look: Callable[[Config], tuple[Crossing | None, float]],
        crossed: Callable[[Crossing], None],
    ) -> None:
        super().__init__(space, limits, period)
        self._look = look
        self._crossed = crossed

    def step(self) -> Config:
        """Advance by one tick, or brake, and return the speed."""
        before = self.config
        config = super().step()
        found, share = self._look(config)
        if found is not None:
            self.config = before
            self._crossed(found)
            return self.brake()
        if share < 1.0:
            self.config = tuple([share * each for each in config])
            self.limited += 1
        return self.config
