"""Limits that no set-point of a stream exceeds, whatever the program sends.

`Limiter` keeps the limits of speed and acceleration, `JerkLimiter` also that of jerk;
`SpeedGenerator` keeps the limits of set-points that are speeds.
"""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.streaming.shared.space import Config, Displacement, Limits, Space

    #: for each group: its slice, and the limits of its speed and of the change of its speed
    _Rules = tuple[tuple[slice, float, float], ...]


_ZERO: Displacement = (0.0,) * 6
_SLACK = 1 + 1e-9  # a trajectory exactly at its limits passes in spite of rounding
_TICK = 1 - 1e-9  # in spite of rounding
_MET = 1e-9  # displacement, speed and acceleration up to which the arm counts as at rest
#: displacement from the target above which a tick counts as limited [rad, m]
_FAR = 1e-3
_MARGIN = 0.98  # share of the speed limit for the moving frame, so that a lag can be caught up


class Limiter:
    """Follows a moving target as closely as the limits allow. Pure: one call is one tick.

    A target that moves within the limits is met exactly. Any other target is approached: with the
    acceleration limit up to the speed limit, and braking in time. Each group is limited separately,
    because the controller also moves each joint separately (manual 1.3.5, servoj).

    Args:
        space: the space of the set-points.
        limits: limits of velocity and acceleration; this class ignores the jerk limit.
        period: time between two ticks [s].
        start: position of the arm, at rest.

    Attributes:
        config: the set-point of the last tick.
        limited: ticks in which the target could not be met.
    """

    def __init__(self, space: Space, limits: Limits, period: float, start: Config) -> None:
        self._space = space
        self._period = period
        self._rules = tuple(zip(space.groups, limits.velocity, limits.acceleration, strict=True))
        # The same limits as displacements in one tick, if each axis has its own limits.
        self._axes = tuple(
            (v * period * _SLACK, a * period * period * _SLACK)
            for group, v, a in self._rules
            if group.stop - group.start == 1
        )
        #: ticks that it takes to come to rest, per displacement in one tick
        self._slowing = tuple(
            1 / (a * period * period) for _, _, a in self._rules[: len(self._axes)]
        )
        self.config: Config = start
        self.limited: int = 0
        self._step: Displacement = _ZERO
        self._target = start

    @property
    def velocity(self) -> Displacement:
        """Velocity in the last tick, per second."""
        return tuple(step / self._period for step in self._step)

    @property
    def at_rest(self) -> bool:
        """Whether the last target is met, and the set-point is at rest."""
        return self.config == self._target and self._step == _ZERO

    def snapshot(self) -> tuple[Any, ...]:
        """A snapshot of the state, for `restore`."""
        return self.config, self._step, self._target

    def restore(self, snapshot: tuple[Any, ...]) -> None:
        """Restore the state of a snapshot that `snapshot` returned."""
        self.config, self._step, self._target = snapshot

    def ticks_to_rest(self) -> float:
        """The braking distance as a multiple of the last step."""
        if self._slowing:
            # `brake` in terms of steps: their number is that of the slowest axis
            a, b, c, d, e, f = self._step
            p, q, r, s, t, u = self._slowing
            return max(abs(a) * p, abs(b) * q, abs(c) * r, abs(d) * s, abs(e) * t, abs(f) * u) / 2
        return _time_to_rest(self.velocity, self._rules) / 2 / self._period

    def braking(self) -> Displacement:
        """The displacement while braking to rest from the present state."""
        ticks = self.ticks_to_rest()
        return tuple([step * ticks for step in self._step])

    def fastest(self) -> Displacement:
        """Velocity that each axis still reaches if it brakes from now on, per second."""
        return self.velocity

    def stopping(self, count: int) -> list[Config]:
        """Positions on the braking path from the present state to rest, at equal distances."""
        rest = self.braking()
        moved = self._space.moved
        return [
            moved(self.config, tuple([n / count * r for r in rest])) for n in range(1, count + 1)
        ]

    def follow(self, target: Config) -> Config:
        """Advance by one tick towards the target of this tick; returns the set-point."""
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
        """Compute the tick when the target may be beyond the limits."""
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

    def brake(self, passed: int = 1) -> Config:
        """Brake for the ticks that have passed, so that all axes stop at the same time.

        It is one step further all the same: an arm whose steps come late is that much slower.

        Returns:
            The set-point.
        """
        share = _braked_share(self.velocity, self._rules, self._period * passed)
        self._step = tuple(step * share for step in self._step)
        self.config = self._space.moved(self.config, self._step)
        self._target = self.config
        return self.config


class JerkLimiter:
    """Follows a moving target within limits of velocity, acceleration and jerk.

    Each tick plans the fastest path that meets the target, and executes the first tick of it. The
    plan is made in a frame that moves with the target, so that a target of constant speed is
    followed without a lag. The limits of a group of three apply to its length, so each of its axes
    gets 1/√3 of them.

    Args:
        space: the space of the set-points.
        limits: limits of velocity, acceleration and jerk.
        period: time between two ticks [s].
        start: position of the arm, at rest.

    Attributes:
        config: the set-point of the last tick.
        velocity: velocity of the set-point, per second.
        limited: ticks in which the limits kept the set-point more than 1 mrad or 1 mm from its
            target.
    """

    def __init__(self, space: Space, limits: Limits, period: float, start: Config) -> None:
        # imported here: only this up-sampling method needs it
        import ruckig  # noqa: PLC0415

        self._modes: Any = ruckig.ControlInterface
        self._error: type[Exception] = ruckig.RuckigError
        self._generator = ruckig.Ruckig(6, period)
        self._input = ruckig.InputParameter(6)
        self._output = ruckig.OutputParameter(6)
        self._trajectory = ruckig.Trajectory(6)
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
        """Whether the last target is met, and the set-point is at rest."""
        return self.config == self._target and self.velocity == _ZERO

    def snapshot(self) -> tuple[Any, ...]:
        """A snapshot of the state, for `restore`."""
        return self.config, self.velocity, self._acceleration, self._target

    def restore(self, snapshot: tuple[Any, ...]) -> None:
        """Restore the state of a snapshot that `snapshot` returned."""
        self.config, self.velocity, self._acceleration, self._target = snapshot

    def braking(self) -> Displacement:
        """The largest displacement of each axis while braking to rest from the present state."""
        plan = self._input
        limits = zip(plan.max_acceleration, plan.max_jerk, strict=True)
        state = zip(self.velocity, self._acceleration, limits, strict=True)
        return tuple(_braking(v, a, top, jerk) for v, a, (top, jerk) in state)

    def fastest(self) -> Displacement:
        """Velocity that each axis still reaches if it brakes from now on, per second.

        While its acceleration falls to zero, an axis that speeds up gets faster.
        """
        state = zip(self.velocity, self._acceleration, self._input.max_jerk, strict=True)
        return tuple(v + a * abs(a) / (2 * jerk) if v * a > 0 else v for v, a, jerk in state)

    def stopping(self, count: int) -> list[Config]:
        """Positions on the braking path from the present state to rest, at equal times."""
        self._plan_rest()
        self._generator.calculate(self._input, self._trajectory)
        duration = self._trajectory.duration
        moved = self._space.moved
        return [
            moved(self.config, tuple(self._trajectory.at_time(n / count * duration)[0]))
            for n in range(1, count + 1)
        ]

    def follow(self, target: Config) -> Config:
        """Advance by one tick towards the target of this tick; returns the set-point."""
        if target == self._target and self.at_rest:
            return self.config
        period, plan = self._period, self._input
        speeds = (d / period for d in self._space.difference(self._target, target))
        frame = [
            max(-_MARGIN * top, min(_MARGIN * top, v))
            for v, top in zip(speeds, self._top, strict=True)
        ]
        # `target` is the position at the end of this tick; the plan begins at its start.
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
        self.limited += miss > _FAR
        still = max(map(abs, self.velocity)) <= _MET > max(map(abs, self._acceleration))
        if met and still:
            self.config, self.velocity, self._acceleration = target, _ZERO, _ZERO
        else:
            self.config = self._space.moved(self.config, tuple(moved))
        return self.config

    def brake(self, passed: int = 1) -> Config:
        """Brake for the ticks that have passed, within the limits, in one step.

        Returns:
            The set-point.
        """
        if self.velocity == _ZERO and self._acceleration == _ZERO:
            return self.config
        for _ in range(passed):
            self._plan_rest()
            self._one_tick()
            self.velocity = tuple(self._output.new_velocity)
        if max(map(abs, self.velocity)) <= _MET > max(map(abs, self._acceleration)):
            self.velocity, self._acceleration = _ZERO, _ZERO
        self.config = self._space.moved(self.config, tuple(self._output.new_position))
        self._target = self.config
        return self.config

    def _plan_rest(self) -> None:
        plan = self._input
        plan.control_interface = self._modes.Velocity
        plan.current_position = plan.target_velocity = [0.0] * 6
        plan.current_velocity = list(self.velocity)
        plan.current_acceleration = list(self._acceleration)
        plan.max_velocity = list(self._top)
        plan.min_velocity = None

    def _one_tick(self) -> None:
        """Execute the first tick of a new plan.

        For a few states in a million ruckig finds no path to a position (its error -110). Then this
        tick matches the target's speed instead, within the same limits; the next tick finds a path.
        """
        try:
            self._generator.reset()
            self._generator.update(self._input, self._output)
        except self._error:
            self._input.control_interface = self._modes.Velocity
            self._generator.reset()
            self._generator.update(self._input, self._output)
        self._acceleration = tuple(self._output.new_acceleration)


class SpeedGenerator:
    """Generates a speed per tick, within limits of its magnitude and of its rate of change.

    Args:
        space: the space whose groups are limited, each by its length.
        limits: `velocity` is the largest speed, `acceleration` its largest change per second.
        period: time between two ticks [s].
        allowed: returns the share of speeds with which the arm can come to rest within the robot's
            envelope; None if it cannot, and then it brakes from the speeds before them.

    Attributes:
        config: the speed of the last tick.
        limited: ticks in which the limits kept the speed from its target.
    """

    def __init__(
        self,
        space: Space,
        limits: Limits,
        period: float,
        allowed: Callable[[Config], float | None] | None = None,
    ) -> None:
        self._allowed = allowed
        self._rules = tuple(zip(space.groups, limits.velocity, limits.acceleration, strict=True))
        self._period = period
        self._target: Displacement = _ZERO
        self.config: Config = _ZERO
        self.limited: int = 0
        #: ticks until the time of the target is over; negative after it
        self._left = 0.0

    @property
    def ready(self) -> bool:
        """Whether the time of the last target is over in this tick: the next one can be taken."""
        return self._left < _TICK

    @property
    def at_rest(self) -> bool:
        """Whether the speed and its target are zero."""
        return self.config == self._target == _ZERO

    def aim(self, target: Config, interval: float, duration: float) -> None:  # noqa: ARG002
        """Take a new speed, to be reached as soon as the limits allow it."""
        self._target = target
        # its time begins with the end of the last one's, which may be between two ticks
        self._left = (self._left if 0.0 < self._left < _TICK else 0.0) + interval / self._period

    def step(self, passed: int = 1) -> Config:
        """Advance, or brake before the envelope; returns the speed.

        Args:
            passed: number of ticks that each call takes on a slow connection: a speed changes with
                time, and not with the calls that are possible.
        """
        self._left -= passed
        config = self._towards(self._target, passed)
        if self._allowed is not None:
            share = self._allowed(config)
            if share is None:
                return self.brake(passed)
            if share < 1.0:
                slower = tuple([share * each for each in config])
                config = self._towards(slower, passed)
                if config != slower:
                    config = self._braked(passed)
        self.config = config
        self.limited += config != self._target
        return config

    def _towards(self, target: Displacement, passed: int) -> Displacement:
        """The speed after so many ticks, on the way to another one within the limits."""
        if self.config == target:
            return target
        new: list[float] = []
        for group, top, change in self._rules:
            now = self.config[group]
            wanted = _at_most(list(target[group]), top)
            delta = [w - n for w, n in zip(wanted, now, strict=True)]
            step = _at_most(delta, change * self._period * passed)
            if step is delta:
                new += wanted
            else:
                new += (n + s for n, s in zip(now, step, strict=True))
        return tuple(new)

    def brake(self, passed: int = 1) -> Config:
        """Brake for the ticks that have passed, so that all axes stop at the same time.

        Returns:
            The speed.
        """
        self._target = _ZERO
        self.config = self._braked(passed)
        return self.config

    def _braked(self, passed: int) -> Displacement:
        share = _braked_share(self.config, self._rules, self._period * passed)
        return tuple(r * share for r in self.config) if share else _ZERO


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


def _time_to_rest(velocity: Displacement, rules: _Rules) -> float:
    """How long it takes until all axes have stopped, at the limits of acceleration [s]."""
    return max(_length(velocity[group]) / change for group, _, change in rules)


def _braked_share(velocity: Displacement, rules: _Rules, period: float) -> float:
    """The share of a velocity that is left after one tick of braking, all axes alike."""
    rest = _time_to_rest(velocity, rules)
    return 1 - period / rest if rest > period else 0.0


def _closing_speed(distance: float, acceleration: float, period: float) -> float:
    """The greatest speed from which the rest of a distance is enough to stop, tick by tick.

    The speeds u, u - a·dt, … down to zero cover u²/2a + u·dt/2.
    """
    half = period / 2
    speed = acceleration * (sqrt(half * half + 2 * distance / acceleration) - half)
    return min(speed, distance / period)


def _braking(speed: float, acceleration: float, top: float, jerk: float) -> float:
    """The largest braking distance of an axis under acceleration and jerk limits, with its sign."""
    sign = 1.0 if speed + acceleration * abs(acceleration) / (2 * jerk) >= 0 else -1.0
    v, a = sign * speed, max(0.0, sign * acceleration)
    # First the acceleration goes to zero; then the axis brakes as from a constant speed.
    fade = a / jerk
    way = v * fade + a * fade * fade / 3
    v += a * fade / 2
    time = v / top + top / jerk if v * jerk >= top * top else 2 * sqrt(max(v, 0.0) / jerk)
    return sign * (way + v * time / 2)


def _per_axis(space: Space, limits: Sequence[float]) -> list[float]:
    """The limit of each of the six axes, from the limits of the groups."""
    found: list[float] = []
    for group, limit in zip(space.groups, limits, strict=True):
        width = group.stop - group.start
        found += [limit / width**0.5] * width
    return found
