"""Follows the program's targets, tick by tick, within the limits and within an envelope."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.streaming.worker.interpolation import interpolator
from aioduco.streaming.worker.limiter import JerkLimiter, Limiter

if TYPE_CHECKING:
    from aioduco.streaming.shared.space import Config, Displacement, Limits, Space
    from aioduco.streaming.worker.checked import EnvelopeCheck
    from aioduco.streaming.worker.chunks import ActionTimeline
    from aioduco.streaming.worker.interpolation import Linear

__all__ = ["Follower"]


class Follower:
    """A reference and the limiter that follows it.

    With a check, the arm can come to rest within the envelope from every set-point. A set-point
    that breaks this is not sent: the follower brakes from the one before it.

    Args:
        way: method of up-sampling, see `Feeding`.
        space: the space of the set-points.
        limits: limits of velocity and acceleration; for "ruckig" also of jerk.
        period: time between two ticks of the stream [s].
        start: position of the arm, at rest.
        reference: joins chunks of actions; it starts at `start`. None: an interpolator.
        check: checks set-points against the robot's envelope; None: there is none.
    """

    def __init__(
        self,
        way: str,
        space: Space,
        limits: Limits,
        period: float,
        start: Config,
        reference: ActionTimeline | None = None,
        check: EnvelopeCheck | None = None,
    ) -> None:
        self._reference: Linear | ActionTimeline = reference or interpolator(
            way, space, period, start
        )
        kind = JerkLimiter if way == "ruckig" else Limiter
        self._limiter = kind(space, limits, period, start)
        self._check = check

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
        """Advance by one tick, or brake before the envelope; returns the set-point."""
        limiter, check = self._limiter, self._check
        if check is None:
            return limiter.follow(self._reference.step())
        snapshot = limiter.snapshot()
        config = limiter.follow(self._reference.step())
        found = check.look(config, limiter)
        if found is None:
            return config
        limiter.restore(snapshot)
        if found.action != "slow":
            check.crossed(found)
            return self.brake()
        config = limiter.brake()
        check.moved(config)
        return config

    def brake(self) -> Config:
        """Brake for one tick within the limits and return the set-point."""
        config = self._limiter.brake()
        self._reference.reset(config)
        if self._check is not None:
            self._check.moved(config)
        return config
