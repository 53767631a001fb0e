"""The fastest motion along a path: the distance along it as a function of time.

With x = (ds/dt)², a constant acceleration is a straight line of x over s. Between two nodes of a
path the highest x is the least of three lines: the x that acceleration can reach from the previous
node, the x that is allowed there, and the x from which braking can still meet the limits ahead. One
pass from each end finds them all, and the time law is exact for the limits at the nodes.

The forward pass goes only as far as the law was queried. So a law of many thousand nodes costs no
more at its beginning than a law of two, and its later pieces are computed as the arm reaches them.
"""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from typing import TYPE_CHECKING, NamedTuple

from aioduco.sim.planner.arrays import joined, shifted
from aioduco.sim.planner.slices import slices

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence


_SHORTEST = 1e-9  # least length of a piece, as a share of the whole
_SAME = 1e-9  # accelerations with a smaller relative difference are the same
_ROUNDING = 1e-15  # of a distance
_DONE = object()


class PathLimits(NamedTuple):
    """Limits of the motion along a path, in the path's own unit of length.

    Attributes:
        nodes: distances s, rising.
        ceiling: highest (ds/dt)² at each node.
        push: highest acceleration along the path between nodes that the joints allow.
        total: highest acceleration of the tool centre point between nodes, along and across the
            path together; infinite where only the joints count.
        curvature: curvature of the path of the tool centre point between nodes.
        brake: acceleration along the path between nodes that the arm's drives can do; a stop
            uses it.
        waits: distances of the nodes at which the motion stands, and for how long [s].
    """

    nodes: Sequence[float]
    ceiling: Sequence[float]
    push: Sequence[float]
    total: Sequence[float]
    curvature: Sequence[float]
    brake: Sequence[float]
    waits: tuple[tuple[float, float], ...] = ()

    def stricter(self, other: PathLimits) -> PathLimits:
        """Give the stricter of these limits and others at the same nodes, which are of joints."""
        return self._replace(
            ceiling=joined(map(min, self.ceiling, other.ceiling)),
            push=joined(map(min, self.push, other.push)),
            brake=joined(map(min, self.brake, other.brake)),
        )

    def waiting(self, stops: Sequence[tuple[float, float]]) -> PathLimits:
        """Give these limits with stops, each at the node nearest to a distance, for a time [s]."""
        nodes, ceiling = self.nodes, joined(self.ceiling)
        waits = []
        for at, time in stops:
            i = bisect_left(nodes, at)
            if i == len(nodes) or (i > 0 and at - nodes[i - 1] < nodes[i] - at):
                i -= 1
            ceiling[i] = 0.0
            waits.append((nodes[i], time))
        return self._replace(ceiling=ceiling, waits=tuple(waits))

    def along(self, piece: int, x: float) -> float:
        """Give the acceleration that is left along the path at (ds/dt)² = x."""
        across = self.curvature[piece] * x
        if across == 0.0:
            return min(self.push[piece], self.total[piece])
        total = self.total[piece]
        return min(self.push[piece], math.sqrt(max(total * total - across * across, 0.0)))

    def at(self, s: float, v: float) -> tuple[float, float]:
        """Give the accelerations for the motion and for a stop, at distance s and ds/dt = v."""
        piece = min(max(bisect_right(self.nodes, s) - 1, 0), len(self.push) - 1)
        along = self.along(piece, v * v)
        return along, max(along, self.brake[piece])

    def slice(self, start: float, end: float) -> PathLimits:
        """Give the limits from `start` to `end`, with the same distances."""
        # No piece is so short that rounding could make it vanish.
        least = _SHORTEST * (self.nodes[-1] - self.nodes[0])
        first = bisect_right(self.nodes, start + least) - 1
        last = bisect_left(self.nodes, end - least)
        part = slice(first, last)
        inner = slice(first + 1, last)
        return PathLimits(
            joined((start,), self.nodes[inner], (end,)),
            joined(
                (self._ceiling_at(first, start),),
                self.ceiling[inner],
                (self._ceiling_at(last - 1, end),),
            ),
            self.push[part],
            self.total[part],
            self.curvature[part],
            self.brake[part],
            tuple(wait for wait in self.waits if start < wait[0] < end),
        )

    def _ceiling_at(self, piece: int, s: float) -> float:
        a, b = self.nodes[piece], self.nodes[piece + 1]
        part = min(max((s - a) / (b - a), 0.0), 1.0)
        return (1.0 - part) * self.ceiling[piece] + part * self.ceiling[piece + 1]

    def then(self, other: PathLimits) -> PathLimits:
        """Give these limits followed by others, whose distances are shifted accordingly."""
        shift = self.nodes[-1] - other.nodes[0]
        joint = min(self.ceiling[-1], other.ceiling[0])
        return PathLimits(
            joined(self.nodes, shifted(other.nodes[1:], shift)),
            joined(self.ceiling[:-1], (joint,), other.ceiling[1:]),
            joined(self.push, other.push),
            joined(self.total, other.total),
            joined(self.curvature, other.curvature),
            joined(self.brake, other.brake),
            self.waits + tuple((at + shift, time) for at, time in other.waits),
        )


class TimeLaw:
    """Distance over time, in pieces of constant acceleration.

    A law from `fastest` is computed only as far as it was queried. That changes no result,
    only the time of the work. But a query may extend the law, so only one thread at a time may use
    it. A query about the whole law (its duration or the speed at its end) computes all of it.
    """

    __slots__ = (
        "_ahead",
        "_duration",
        "_end",
        "_end_speed",
        "_goal",
        "_rate",
        "_s",
        "_t",
        "_v",
        "_waits",
    )

    def __init__(self, start: float, speed: float) -> None:
        self._s, self._v, self._t = [start], [speed], [0.0]
        self._rate: list[float] = []
        self._waits: list[tuple[float, float]] = []  # where they are, and when they begin
        self._ahead: Iterator[None] | None = None  # each step extends the law to the next node
        self._goal = start
        self._end = start
        self._duration = 0.0
        self._end_speed = speed

    @property
    def end(self) -> float:
        """The distance s at the end."""
        return self._end if self._ahead is None else self._goal

    @property
    def duration(self) -> float:
        """Time from the beginning to the end [s]."""
        self._extend_to()
        return self._duration

    @property
    def end_speed(self) -> float:
        """The speed ds/dt at the end."""
        self._extend_to()
        return self._end_speed

    def over(self, t: float) -> bool:
        """Whether the law has ended at time t [s]."""
        self._extend_to(time=t)
        return self._ahead is None and t >= self._duration

    def set_generator(self, ahead: Iterator[None], goal: float) -> None:
        """Set the generator that extends the law to `goal`, one piece or more per step."""
        self._ahead, self._goal = ahead, goal

    def _extend_to(self, *, distance: float = math.inf, time: float = math.inf) -> None:
        """Extend the law until it is beyond a distance or a time [s], or at its end."""
        while self._ahead is not None and (self._s[-1] <= distance and self._t[-1] <= time):
            if next(self._ahead, _DONE) is _DONE:
                self._ahead = None

    def extend(self, end: float, x: float) -> None:
        """Extend the law to distance `end`, where (ds/dt)² is x, at a constant acceleration."""
        length = end - self._end
        if length <= 1e-15 * abs(end):
            return  # a corner that rounding has put on top of another
        speed = math.sqrt(max(x, 0.0))
        rate = 0.5 * (speed - self._end_speed) * (speed + self._end_speed) / length
        self._duration += 2.0 * length / (speed + self._end_speed)
        # A piece that grows keeps its acceleration: results of earlier queries stay true.
        if self._rate and abs(rate - self._rate[-1]) <= _SAME * max(abs(rate), 1.0):
            self._s.pop()
            self._v.pop()
            self._t.pop()
        else:
            self._rate.append(rate)
        self._s.append(end)
        self._v.append(speed)
        self._t.append(self._duration)
        self._end, self._end_speed = end, speed

    def wait(self, time: float) -> None:
        """Extend the law by a wait of some time [s] at its end, where it stands."""
        self._v[-1] = self._end_speed = 0.0  # apart from rounding, it is 0 already
        self._waits.append((self._end, self._duration))
        self._duration += time
        self._rate.append(0.0)
        self._s.append(self._end)
        self._v.append(0.0)
        self._t.append(self._duration)

    def piece(self, s: float, hint: int = 0) -> int:
        """Give the index of the piece at distance s, searching forward from `hint`."""
        if self._s[-1] <= s and self._ahead is not None:
            self._extend_to(distance=s)
        return max(min(bisect_right(self._s, s, hint) - 1, len(self._rate) - 1), hint)

    def at(self, t: float, hint: int = 0) -> tuple[int, float, float, float]:
        """Give the piece, s, ds/dt and d²s/dt² at time t [s], searching forward from `hint`."""
        if self._t[-1] <= t and self._ahead is not None:
            self._extend_to(time=t)
        last = len(self._rate) - 1
        while hint < last and t >= self._t[hint + 1]:
            hint += 1
        since, v, rate = t - self._t[hint], self._v[hint], self._rate[hint]
        return hint, self._s[hint] + (v + 0.5 * rate * since) * since, v + rate * since, rate

    def first_wait(self, start: float, end: float) -> tuple[float, float] | None:
        """Give the first wait from one distance to another: where it is, and when it begins [s]."""
        self.piece(end)
        i = bisect_left(self._waits, (start - _ROUNDING, 0.0))
        return self._waits[i] if i < len(self._waits) and self._waits[i][0] <= end else None

    def speed(self, s: float, hint: int = 0) -> float:
        """Give ds/dt at distance s."""
        i = self.piece(s, hint)
        v = self._v[i]
        return math.sqrt(max(v * v + 2.0 * self._rate[i] * (s - self._s[i]), 0.0))

    def time(self, s: float) -> float:
        """Give the time at distance s [s]."""
        i = self.piece(s)
        mean = 0.5 * (self._v[i] + self.speed(s, i))
        return self._t[i] + ((s - self._s[i]) / mean if mean > 0.0 else 0.0)


def backward(limits: PathLimits, x: float) -> array[float]:
    """Give the highest (ds/dt)² at each node from which x at the last node can be reached.

    Args:
        limits: limits of the whole path.
        x: (ds/dt)² at its last node.
    """
    nodes, ceiling = limits.nodes, limits.ceiling
    x = min(x, ceiling[-1])
    reached = array("d", (x,))
    last = len(nodes) - 2
    for part in slices(len(nodes) - 1):
        for i in range(last - part.start, last - part.stop, -1):
            x = min(x + 2.0 * _rate(limits, i, x) * (nodes[i + 1] - nodes[i]), ceiling[i])
            reached.append(x)
    reached.reverse()
    return reached


def allowed(limits: PathLimits, back: Sequence[float], s: float) -> float:
    """Give the highest (ds/dt)² at distance s; `back` is the result of `backward`."""
    i = min(max(bisect_right(limits.nodes, s) - 1, 0), len(limits.nodes) - 2)
    braking = back[i + 1] + 2.0 * _rate(limits, i, back[i + 1]) * (limits.nodes[i + 1] - s)
    # An excess by rounding is allowed.
    return min(braking, limits._ceiling_at(i, s)) * (1.0 + 1e-9) + 1e-15


def _rate(limits: PathLimits, piece: int, x: float) -> float:
    # The acceleration is constant over a piece, so it is the one at the piece's fastest point.
    if limits.curvature[piece] == 0.0:
        return limits.along(piece, x)
    length = limits.nodes[piece + 1] - limits.nodes[piece]
    fastest = x + 2.0 * limits.along(piece, x) * length
    top = max(limits.ceiling[piece], limits.ceiling[piece + 1])
    return limits.along(piece, min(fastest, top))


def fastest(limits: PathLimits, back: Sequence[float], start: float, speed: float) -> TimeLaw:
    """Give the fastest law from a point of the path.

    Args:
        limits: limits of the whole path.
        back: result of `backward` for these limits.
        start: distance s at which the law begins.
        speed: ds/dt there; not more than what `backward` allows.

    Returns:
        A law from `start` to the end of the path.
    """
    law = TimeLaw(start, speed)
    law.set_generator(_forward_pass(law, limits, back, start, speed), limits.nodes[-1])
    return law


def _forward_pass(
    law: TimeLaw, limits: PathLimits, back: Sequence[float], start: float, speed: float
) -> Iterator[None]:
    """Extend the law to the next node in each step, as fast as the limits allow."""
    nodes, ceiling = limits.nodes, limits.ceiling
    waits = dict(limits.waits)
    x = speed * speed
    first = max(bisect_right(nodes, start) - 1, 0)
    for i in range(first, len(nodes) - 1):
        a, b = max(nodes[i], start), nodes[i + 1]
        length = b - a
        if length <= 0.0:
            continue
        rate, slow = _rate(limits, i, x), _rate(limits, i, back[i + 1])
        climb = (ceiling[i + 1] - ceiling[i]) / (b - nodes[i])
        lines = (
            (x, 2.0 * rate),
            (ceiling[i] + climb * (a - nodes[i]), climb),
            (back[i + 1] + 2.0 * slow * length, -2.0 * slow),
        )
        for end, value in _least(lines, length):
            law.extend(a + end, value)
        x = min(x + 2.0 * rate * length, ceiling[i + 1])
        if b in waits:
            law.wait(waits[b])
        yield


def _least(lines: tuple[tuple[float, float], ...], length: float) -> list[tuple[float, float]]:
    """Give the corners of the minimum of some lines, each given by its value at zero and its slope.

    Returns:
        Places after zero, up to `length`, and the minimum there.
    """
    corners = []
    place = 0.0
    value, slope = min(lines)
    while True:
        following, best = length, None
        for other, incline in lines:
            if incline < slope:
                crossing = (other - value) / (slope - incline)
                if place <= crossing < following:
                    following, best = crossing, (other, incline)
        if following > place:
            corners.append((following, value + slope * following))
        if best is None:
            return corners
        place, (value, slope) = following, best
