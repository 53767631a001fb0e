"""Conversion of overlapping chunks of actions to one target per tick. This module reads no clock.

A policy gives its actions in chunks: a number of actions at a fixed rate, from a given time on. The
next chunk arrives before the last one is over. From its time on the newer chunk replaces the older
one, and the transition is blended: the target has no step in position or in velocity. The limiter
after it keeps the limits of acceleration and jerk.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.streaming.shared.space import Config, Displacement, Space


_ZERO: Displacement = (0.0,) * 6
_CATCH_UP = 0.25  # share of a period per tick by which missed time is made up for
_ROUNDING = 1e-7


class _Curve:
    """A cubic curve through the actions of one chunk; it overshoots none, and ends at rest.

    Slopes are computed only where they are needed: a chunk is usually replaced before its end. When
    it is entered from another motion, it begins with a blend from there.
    """

    def __init__(
        self, space: Space, begin: float, interval: float, actions: Sequence[Config]
    ) -> None:
        self._space = space
        self._actions = actions
        self._interval = interval
        self.begin = begin
        #: when its last action is due
        self._last = begin + (len(actions) - 1) * interval
        self._since = begin
        self._blend = 0.0
        #: displacement from the curve to the earlier motion, and its rate of change [1/s]
        self._gap = self._drift = _ZERO

    @property
    def end(self) -> float:
        """When the curve and its blend are over [s]."""
        return max(self._last, self._since + self._blend)

    def enter(self, since: float, blend: float, gap: Displacement, drift: Displacement) -> None:
        """Begin at a time with a blend from another motion, which is `gap` away."""
        self._since, self._blend, self._gap, self._drift = since, blend, gap, drift

    def blended(self, time: float) -> Config:
        """The point at a time, with the blend from the earlier motion."""
        config = self.at(time)
        share = (time - self._since) / self._blend if self._blend else 1.0
        if share >= 1:
            return config
        keep = (1 - share) ** 2 * (1 + 2 * share)
        out = share * (1 - share) ** 2 * self._blend
        fading = [keep * g + out * d for g, d in zip(self._gap, self._drift, strict=True)]
        return self._space.moved(config, tuple(fading))

    def at(self, time: float) -> Config:
        """The point of the curve at a time; outside of the curve its first or last action."""
        last = len(self._actions) - 1
        if time >= self._last:
            return self._actions[last]
        place = (time - self.begin) / self._interval
        if place <= 0:
            return self._actions[0]
        index = min(int(place), last - 1)
        share = place - index
        way = self._way(index)
        out, come = self._slope(index), self._slope(index + 1)
        keep = share * share * (3 - 2 * share)
        p, q = share * (1 - share) ** 2, share * share * (share - 1)
        moved = tuple([keep * w + p * a + q * b for w, a, b in zip(way, out, come, strict=True)])
        return self._space.moved(self._actions[index], moved)

    def _way(self, index: int) -> Displacement:
        return self._space.difference(self._actions[index], self._actions[index + 1])

    def _slope(self, index: int) -> Displacement:
        """Displacement per interval at an action."""
        if index == len(self._actions) - 1:
            return _ZERO
        after = self._way(index)
        if index == 0:
            return after
        return tuple(map(_between, self._way(index - 1), after))


class ActionTimeline:
    """The target of each tick, from overlapping chunks. One call of `advance` is a tick.

    Args:
        space: the space of the actions.
        period: time between two ticks [s].
        interval: time between two actions of a chunk [s].
        blend: time of the transition from an older chunk to a newer one [s].

    Attributes:
        now: time of this tick [s].
        taken: chunks that were taken, dropped ones included.
        late: of these, chunks some of whose actions were already past.
        dropped: of these, chunks all of whose actions were already past; the earlier chunks stay.
        late_actions: number of single actions that arrived too late.
        exhausted: how often the actions ran out before a new chunk arrived.
    """

    def __init__(self, space: Space, period: float, interval: float, blend: float) -> None:
        self._space = space
        self._period = period
        self._interval = interval
        self._blend = blend
        self._followed: _Curve | None = None
        #: chunks whose time has not come yet, in order of their begin
        self._coming: list[_Curve] = []
        self._place: Config = ()
        self._running = False
        self._over = True
        self.now: float = 0.0
        self.taken: int = 0
        self.late: int = 0
        self.dropped: int = 0
        self.late_actions: int = 0
        self.exhausted: int = 0

    @property
    def ready(self) -> bool:
        """Whether the time of all actions is over."""
        followed = self._followed
        return not self._coming and (followed is None or self.now >= followed.end)

    @property
    def met(self) -> bool:
        """Whether the last action is reached."""
        return self.ready

    def advance(self, clock: float, *, closing: bool = False) -> None:
        """Advance to the next tick.

        The time advances by one period, so that uneven ticks do not make the motion uneven. Missed
        ticks are made up for gradually.

        Args:
            clock: time of the clock [s].
            closing: whether no more chunks are expected.
        """
        if not self._running:
            self._running, self.now = True, clock
        else:
            self.now += self._period
            behind = clock - self.now
            if behind > self._period:
                self.now += min(behind, _CATCH_UP * self._period)
        while self._coming and self._coming[0].begin <= self.now:
            self._follow(self._coming.pop(0))
        if not self._over and self.ready:
            self._over = True
            self.exhausted += not closing

    def take(self, begin: float | None, actions: Sequence[Config]) -> Config | None:
        """Take a chunk. From its begin on it replaces all earlier chunks.

        Args:
            begin: when its first action is due [s]; None: now.
            actions: one or more actions, an interval apart.

        Returns:
            The chunk's position when it takes over; None: all of it was late, so it was dropped.
        """
        begin = self.now if begin is None else begin
        # An action counts as late if even this tick could not have sent it in time.
        passed = (self.now - self._period - begin) / self._interval
        late = min(len(actions), max(0, -int(-passed // 1) if passed > _ROUNDING else 0))
        dropped = late == len(actions)
        self.taken += 1
        self.late += bool(late)
        self.dropped += dropped
        self.late_actions += late
        if dropped:
            return None
        curve = _Curve(self._space, begin, self._interval, actions)
        self._coming = [each for each in self._coming if each.begin < begin]
        self._over = False
        if begin <= self.now:
            self._follow(curve)
        else:
            self._coming.append(curve)
        return curve.at(max(begin, self.now))

    def aim(self, target: Config, interval: float, duration: float) -> None:  # noqa: ARG002
        """Take one action for now."""
        self.take(None, [target])

    def step(self) -> Config:
        """The desired position at this tick."""
        return self._place if self._followed is None else self._followed.blended(self.now)

    def reset(self, config: Config) -> None:
        """Discard all chunks, and stay at a point."""
        self._place = config
        self._followed = None
        self._coming.clear()
        self._over = True

    def _follow(self, curve: _Curve) -> None:
        """Switch to a curve at this tick, without a step in position or velocity."""
        space, now, soon = self._space, self.now, self.now + self._period
        before = self._followed
        if before is None:
            here = there = self._place
        else:
            here, there = before.blended(now), before.blended(soon)
        gap = space.difference(curve.at(now), here)
        later = space.difference(curve.at(soon), there)
        drift = tuple([(b - a) / self._period for a, b in zip(gap, later, strict=True)])
        curve.enter(now, self._blend, gap, drift)
        self._followed = curve


def _between(before: float, after: float) -> float:
    """Slope between two displacements: their harmonic mean, or zero if the direction reverses."""
    product = before * after
    return 2 * product / (before + after) if product > 0 else 0.0
