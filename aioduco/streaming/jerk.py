"""The limiter that also keeps a limit of jerk, by ruckig."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.streaming.limits import Limits
    from aioduco.streaming.space import Config, Displacement, Space

__all__ = ["JerkLimiter"]

_ZERO: Displacement = (0.0,) * 6
_MET = 1e-9  # displacement, speed and acceleration below which nothing moves any more
#: displacement from the target that counts as kept from it by the limits [rad, m]
FAR = 1e-3
_MARGIN = 0.98  # of the speed limit: the fastest target, so that a lag can be caught up


class JerkLimiter:
    """Follows a moving target within limits of velocity, acceleration and jerk.

    Each tick plans the fastest way to meet the target and goes the first tick of it. The plan
    is made in a frame that moves with the target, so that a target of constant speed is
    followed without a lag. The limits of a group of three hold for its length, so each of its
    axes has 1/√3 of them.

    Args:
        space: the space of the set-points.
        limits: velocity, acceleration and jerk.
        period: time between two ticks [s].
        start: where the arm is, at rest.

    Attributes:
        config: the set-point of the last tick.
        velocity: its velocity, per second.
        limited: ticks in which the limits kept it 1 mrad or 1 mm from its target, or more.
    """

    def __init__(self, space: Space, limits: Limits, period: float, start: Config) -> None:
        # imported here: only this way of up-sampling needs it
        import ruckig  # noqa: PLC0415

        self._modes: Any = ruckig.ControlInterface
        self._error: type[Exception] = ruckig.RuckigError
        self._generator = ruckig.Ruckig(6, period)
        self._input = ruckig.InputParameter(6)
        self._output = ruckig.OutputParameter(6)
        self._top = _per_axis(space, limits.velocity)
        self._input.max_acceleration = _per_axis(space, limits.acceleration)
        self._input.max_jerk = _per_axis(space, limits.jerk)
        self._input.synchronization = ruckig.Synchronization.No
        self._space = space
        self._period = period
        self._target = start
        self._acceleration: Displacement = _ZERO
        self.config: Config = start
        self.velocity: Displacement = _ZERO
        self.limited: int = 0

    @property
    def at_rest(self) -> bool:
        """Whether the last target is met, and nothing moves."""
        return self.config == self._target and self.velocity == _ZERO

    def follow(self, target: Config) -> Config:
        """One tick towards the target of this tick; returns the set-point."""
        if target == self._target and self.at_rest:
            return self.config
        period, plan = self._period, self._input
        speeds = (d / period for d in self._space.difference(self._target, target))
        frame = [
            max(-_MARGIN * top, min(_MARGIN * top, v))
            for v, top in zip(speeds, self._top, strict=True)
        ]
        # `target` is where to be at the end of this tick; the plan begins where it was before.
        gap = self._space.difference(self.config, target)
        behind = [f * period - g for f, g in zip(frame, gap, strict=True)]
        self._target = target
        plan.control_interface = self._modes.Position
        plan.current_position = behind
        plan.current_velocity = [v - f for v, f in zip(self.velocity, frame, strict=True)]
        plan.current_acceleration = list(self._acceleration)
        plan.target_position = plan.target_velocity = [0.0] * 6
        plan.max_velocity = [t - f for t, f in zip(self._top, frame, strict=True)]
        plan.min_velocity = [-t - f for t, f in zip(self._top, frame, strict=True)]
        self._one_tick()
        rest = self._output.new_position
        moved = [p - b + f * period for p, b, f in zip(rest, behind, frame, strict=True)]
        self.velocity = tuple(v + f for v, f in zip(self._output.new_velocity, frame, strict=True))
        miss = max(map(abs, rest))
        met = miss <= _MET
        self.limited += miss > FAR
        still = max(map(abs, self.velocity)) <= _MET > max(map(abs, self._acceleration))
        if met and still:
            self.config, self.velocity, self._acceleration = target, _ZERO, _ZERO
        else:
            self.config = self._space.moved(self.config, tuple(moved))
        return self.config

    def brake(self) -> Config:
        """One tick of coming to rest within the limits; returns the set-point."""
        if self.velocity == _ZERO and self._acceleration == _ZERO:
            return self.config
        plan = self._input
        plan.control_interface = self._modes.Velocity
        plan.current_position = plan.target_velocity = [0.0] * 6
        plan.current_velocity = list(self.velocity)
        plan.current_acceleration = list(self._acceleration)
        plan.max_velocity = list(self._top)
        plan.min_velocity = None
        self._one_tick()
        self.velocity = tuple(self._output.new_velocity)
        if max(map(abs, self.velocity)) <= _MET > max(map(abs, self._acceleration)):
            self.velocity, self._acceleration = _ZERO, _ZERO
        self.config = self._space.moved(self.config, tuple(self._output.new_position))
        self._target = self.config
        return self.config

    def _one_tick(self) -> None:
        """Go the first tick of a new plan.

        For a few states in a million ruckig finds no way to a place (its error -110). Then this
        tick matches the target's speed instead, within the same limits; the next one finds one.
        """
        try:
            self._generator.reset()
            self._generator.update(self._input, self._output)
        except self._error:
            self._input.control_interface = self._modes.Velocity
            self._generator.reset()
            self._generator.update(self._input, self._output)
        self._acceleration = tuple(self._output.new_acceleration)


def _per_axis(space: Space, limits: Sequence[float]) -> list[float]:
    """The limit of each of the six axes, from those of the groups."""
    found: list[float] = []
    for group, limit in zip(space.groups, limits, strict=True):
        width = group.stop - group.start
        found += [limit / width**0.5] * width
    return found
