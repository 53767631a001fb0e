"""Timing of a curve: as fast as the limits of speed, acceleration and jerk of the joints allow.

Two passes along the curve find a fast time law for speed and acceleration. Its acceleration jumps;
a moving average of the speed over the time that the jerk needs makes it continuous. Then `time_law`
finds the pace at which this law is fastest within all limits. Last, the times are scaled a little,
because the interpolation between the points slightly exceeds a limit, or leaves some room. A plan
has at most a given number of points, so that the work does not grow with its duration.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.planning.spline import BSpline
from aioduco.planning.time_law import PaceSpline, PathNodes, faster

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.planning.motion_limits import MotionLimits

    Points = NDArray[np.float64]


_GRID = 0.02  # between two nodes of the first law [rad of the joint that moves most]
_LEAST = 40
_TICK = 0.008  # between two points of the result, at most [s]
_FINEST = 0.002  # and at least, if the jerk may be high [s]
_TICKS = 40  # least number of points of a short path, about
_MOST = 4000  # largest number of points, about
_ORDER = 5
_SPAN = 2  # ticks in a span of the pace
_EDGE = 6  # ticks at either end where points are twice as close
_PLACES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # samples in an interval, as shares of it
_BETWEEN = 1.0004  # times slower than they need: speed and acceleration are higher between them
_ROUNDS = 3
_CLOSE = 1.004  # times too fast: below this, another round is not worthwhile
_SOFT = 8e-3  # weight of the barriers in another round


class TimedPath(NamedTuple):
    """Joints with times.

    Attributes:
        times: [s]. Shape (n,).
        positions: [rad]. Shape (n, 6).
        velocities: [rad/s]. Shape (n, 6).
        accelerations: [rad/s²]. Shape (n, 6).
    """

    times: Points
    positions: Points
    velocities: Points
    accelerations: Points


def timed(curve: BSpline, limits: MotionLimits, rate: float = np.inf) -> TimedPath:
    """Give the joints over time along a curve, from rest to rest.

    Args:
        curve: of joints [rad].
        limits: limits that no joint exceeds.
        rate: largest derivative of the curve's length over time [its unit per second].
    """
    law, ramp = _slower(curve, limits, rate)
    end = law.end
    tick = max(min(max(0.08 * ramp, _FINEST), _TICK, end / _TICKS), end / _MOST)
    times = _ticks(curve, law, end, tick)
    pace = PaceSpline(end, int(np.ceil(end / (_SPAN * tick))))
    tighter = np.ones((len(times), 3))
    best: TimedPath | None = None
    for count in range(_ROUNDS):
        nodes = _nodes(curve, law, times, tighter, tick)
        pace = faster(nodes, pace, limits, rate, *([_SOFT] if count else []))
        found = _along(curve, law, times, pace)
        beyond = _beyond(found, limits)
        excess = _BETWEEN * float((beyond ** (1.0, 1.0 / 2.0, 1.0 / 3.0)).max())
        # Slower if a limit is exceeded; faster if there is room left, but not along a line.
        slower = max(excess, 1.0) if np.isfinite(rate) else excess
        if best is None or slower * found.times[-1] < best.times[-1]:
            best = TimedPath(
                found.times * slower,
                found.positions,
                found.velocities / slower,
                found.accelerations / slower**2,
            )
        if slower < _CLOSE:
            break
        # Where a limit is exceeded, the next round uses a lower one.
        more = np.maximum(beyond, 1.0)
        tighter[:-1] *= more
        tighter[1:] *= np.where(tighter[1:] < tighter[:-1], more, 1.0)
    assert best is not None
    return best


def _slower(curve: BSpline, limits: MotionLimits, rate: float) -> tuple[BSpline, float]:
    """Give a law whose acceleration is continuous, and the time from rest to full acceleration."""
    speed, acceleration, jerk = limits.arrays
    begin, end = curve.begin, curve.end
    turned = np.abs(np.diff(curve(np.linspace(begin, end, 50)), axis=0)).sum(axis=0)
    grid = np.linspace(begin, end, max(int(turned.max() / _GRID), _LEAST) + 1)
    rates = np.sqrt(_squares(curve, grid, limits, rate))
    # The rate is linear over time between two nodes.
    steps = 2.0 * np.diff(grid) / (rates[1:] + rates[:-1])
    times = np.concatenate([[0.0], np.cumsum(steps)])
    # A joint that reaches its speed, or its end, before its full acceleration has a shorter ramp.
    ramps = acceleration / jerk, np.sqrt(speed / jerk), np.cbrt(turned / jerk)
    ramp = float(np.min(ramps, axis=0).max())
    return _smooth(grid, times, rates, ramp), ramp


def _squares(curve: BSpline, grid: Points, limits: MotionLimits, rate: float) -> Points:
    """Give the square of the rate at each node: fast, within speed and acceleration at the nodes.

    At a rate with the square `x` and the slope `x'` over the length, a joint's acceleration is
    q' x'/2 + q'' x. So x' has a largest value where x is known: one pass from the start goes up as
    fast as that allows, one from the end likewise, and the lower of the two is taken.
    """
    speed, acceleration, jerk = limits.arrays
    along, bend, change = (curve(grid, order) for order in (1, 2, 3))
    with np.errstate(divide="ignore"):
        most = np.minimum((speed / np.abs(along)).min(axis=1), min(rate, 1e3)) ** 2
        most = np.minimum(most, (acceleration / np.abs(bend)).min(axis=1))
        most = np.minimum(most, (jerk / np.abs(change)).min(axis=1) ** (2.0 / 3.0))
    # The slope is that of the node before; along 1e-12 a joint does not limit it.
    weights = 2.0 * np.diff(grid)[0] / np.maximum(np.abs(along), 1e-12)

    def one_pass(sense: float, order: slice) -> Points:
        tops, squares = most[order], [0.0]
        bends, nodes = (sense * np.sign(along) * bend)[order], weights[order]
        for i, top in enumerate(tops[1:]):
            last = squares[-1]
            step = float((nodes[i] * (acceleration - bends[i] * last)).min())
            squares.append(min(max(last + step, 1e-6 * top), top))
        return np.array(squares)[order]

    return np.minimum(one_pass(1.0, slice(None)), one_pass(-1.0, slice(None, None, -1)))


def _smooth(grid: Points, times: Points, rates: Points, window: float) -> BSpline:
    """Give the position over time after a moving average of the rate, from rest to rest.

    It is a spline of fifth degree, whose derivatives are exact.
    """
    count = int(np.clip(np.ceil(times[-1] / _TICK), 2, _MOST))
    tick = float(times[-1]) / count
    rate = np.interp((np.arange(count) + 0.5) * tick, times, rates)
    for width in (window, 0.25 * window):
        taps = max(round(width / tick), 1)
        rate = np.convolve(rate, np.full(taps, 1.0 / taps))
    places = np.concatenate([[0.0], np.cumsum(rate)])
    places = grid[0] + places * ((grid[-1] - grid[0]) / places[-1])
    control = np.concatenate([np.full(_ORDER, places[0]), places, np.full(_ORDER, places[-1])])
    return BSpline(tick * (np.arange(len(control) + _ORDER + 1) - _ORDER), control, _ORDER)


def _ticks(curve: BSpline, law: BSpline, end: float, tick: float) -> Points:
    """Times of the law for the points of the result.

    There is a point at each knot of the curve, where its third derivative jumps.
    """
    times = np.linspace(0.0, end, int(np.ceil(end / tick)) + 1)
    if curve.degree >= _ORDER:
        return times
    places = np.unique(curve.knots)[1:-1]
    jumps = np.interp(places, law(times), times)
    # Two steps of Newton's method make the linear interpolation more exact.
    for _ in range(2):
        jumps = np.clip(jumps - (law(jumps) - places) / np.maximum(law(jumps, 1), 1e-6), 0.0, end)
    jumps = jumps[(jumps > tick) & (jumps < end - tick)]
    jumps = jumps[np.concatenate([[True], np.diff(jumps) > 0.3 * tick])] if len(jumps) else jumps
    away = np.abs(times[:, None] - jumps).min(axis=1) if len(jumps) else np.full(len(times), tick)
    return np.sort(np.concatenate([times[away > 0.3 * tick], jumps]))


def _nodes(curve: BSpline, law: BSpline, times: Points, tighter: Points, tick: float) -> PathNodes:
    """Give the nodes for the limits: all points, more at the ends, and both sides of a jump."""
    half = 0.5 * (times[:-1] + times[1:])
    near = half[(half < _EDGE * tick) | (half > times[-1] - _EDGE * tick)]
    uneven = np.diff(times) < 0.99 * np.diff(times).max()
    sides = times[:-1][uneven] + 1e-6 * tick, times[1:][uneven] - 1e-6 * tick
    at = np.unique(np.concatenate([times, near, *sides]))
    place = np.clip(law(at), curve.begin, curve.end)
    one, two, three = (law(at, order)[:, None] for order in (1, 2, 3))
    first, second, third = (curve(place, order) for order in (1, 2, 3))
    left = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 1)
    right = np.clip(np.searchsorted(times, at), 0, len(times) - 1)
    return PathNodes(
        at,
        first * one,
        second * one**2 + first * two,
        third * one**3 + 3.0 * second * one * two + first * three,
        one[:, 0],
        np.maximum(tighter[left], tighter[right]),
    )


def _along(curve: BSpline, law: BSpline, times: Points, pace: PaceSpline) -> TimedPath:
    """Give the joints over time for a law at a pace."""
    place = np.clip(law(times), curve.begin, curve.end)
    place[[0, -1]] = curve.begin, curve.end
    one, two = law(times, 1), law(times, 2)
    square, slope, _ = pace(times)
    rate = one * np.sqrt(square)
    change = two * square + 0.5 * one * slope
    first, second = curve(place, 1), curve(place, 2)
    velocities = first * rate[:, None]
    accelerations = first * change[:, None] + second * rate[:, None] ** 2
    velocities[[0, -1]] = accelerations[[0, -1]] = 0.0
    return TimedPath(pace.times_at(times), curve(place), velocities, accelerations)


def _beyond(found: TimedPath, limits: MotionLimits) -> Points:
    """For each interval, speed, acceleration and jerk over their limits. Shape (n - 1, 3)."""
    step = np.diff(found.times)[:, None]
    p, v, a = (part * step**i for i, part in enumerate(_starts(found)))
    way = found.positions[1:] - p
    come, bent = found.velocities[1:] * step, found.accelerations[1:] * step**2
    third = 10 * way - 6 * v - 4 * come - 1.5 * a + 0.5 * bent
    fourth = -15 * way + 8 * v + 7 * come + 1.5 * a - bent
    fifth = 6 * way - 3 * v - 3 * come - 0.5 * a + 0.5 * bent
    speed, acceleration, jerk = limits.arrays
    u = np.array(_PLACES)[:, None, None]
    one = v + u * (a + u * (3 * third + u * (4 * fourth + u * 5 * fifth)))
    two = a + u * (6 * third + u * (12 * fourth + u * 20 * fifth))
    # The jerk is a parabola of u: check its extremum and both ends.
    with np.errstate(divide="ignore", invalid="ignore"):
        top = np.nan_to_num(np.clip(-0.2 * fourth / fifth, 0.0, 1.0))
    three = np.stack([6 * third + at * (24 * fourth + at * 60 * fifth) for at in (0.0, top, 1.0)])
    shares = (
        one / (step * speed),
        two / (step**2 * acceleration),
        three / (step**3 * jerk),
    )
    return np.stack([np.abs(share).max(axis=(0, 2)) for share in shares], axis=1)


def _starts(found: TimedPath) -> tuple[Points, Points, Points]:
    return found.positions[:-1], found.velocities[:-1], found.accelerations[:-1]
