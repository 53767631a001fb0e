"""When the arm is where on a curve: as fast as speed, acceleration and jerk of the joints allow.

TOPP-RA finds the fastest time law for speed and acceleration. Its acceleration jumps; a moving
average of the speed over the time that the jerk needs makes it continuous, and the whole is slowed
down by the little that is then still beyond a limit.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from aioduco.errors import PlanningError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.planning.curve import Curve
    from aioduco.planning.motion_limits import MotionLimits

    Points = NDArray[np.float64]

    toppra: Any  # without types
else:
    import toppra
    import toppra.constraint

__all__ = ["TimedPath", "timed"]

_GRID = 0.02  # between two nodes of the time law [rad of the joint that moves most]
_TICK = 0.008  # between two points of the result [s]
_ORDER = 5
_PLACES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)  # in an interval at which speeds are looked at
_LEAST = 40
_ROUNDS = 2
_WINDOWS = (1.0, 1.4, 2.0)  # of the moving average, of the time from rest to full acceleration
_CLOSE = 1.02


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


def timed(curve: Curve, limits: MotionLimits, rate: float = np.inf) -> TimedPath:
    """Give the joints over time along a curve, from rest to rest.

    Args:
        curve: of joints [rad].
        limits: what no joint exceeds.
        rate: how fast the curve's length may be passed [its unit per second].

    Raises:
        PlanningError: no time law was found.
    """
    logging.getLogger("toppra").setLevel(logging.CRITICAL)  # what it warns of is raised here
    _, acceleration, jerk = limits.arrays
    begin, end = float(curve.t[0]), float(curve.t[-1])
    moved = np.abs(np.diff(curve(np.linspace(begin, end, 50)), axis=0)).sum(axis=0).max()
    grid = np.linspace(begin, end, max(int(moved / _GRID), _LEAST) + 1)
    path = _Path(curve)
    least = float((acceleration / jerk).max())
    ease = np.ones(len(grid))
    best: TimedPath | None = None
    for _ in range(_ROUNDS):
        law = toppra.algorithm.TOPPRA(
            [_Bounds(limits, ease, rate)], path, grid, solver_wrapper="seidel"
        )
        rates = law.compute_parameterization(0.0, 0.0)[1]
        if rates is None or not np.isfinite(rates).all():
            raise PlanningError("no speeds were found along the path within the limits")
        times, rates = _law(grid, np.asarray(rates))
        tries = []
        for window in _WINDOWS:
            smooth = _smooth(grid, times, rates, window * least)
            found = _along(curve, smooth)
            excess = _excess(found, limits)
            excess = np.maximum(excess, 1e-9)
            tries.append((float(excess.max()) * found.times[-1], found, excess, smooth[1]))
        _, found, excess, places = min(tries, key=lambda each: each[0])
        slower = max(float(excess.max()), 1.0 if np.isfinite(rate) else 1e-3)
        if best is None or slower * found.times[-1] < best.times[-1]:
            best = TimedPath(
                found.times * slower,
                found.positions,
                found.velocities / slower,
                found.accelerations / slower**2,
            )
        if slower < _CLOSE:
            break
        # Where a limit is exceeded, less is asked for the next time.
        here = np.interp(grid, places[:-1], np.minimum(1.0 / excess, 1.0) ** 2)
        ease *= np.minimum.reduce([here, np.roll(here, 1), np.roll(here, -1)])
    assert best is not None
    return best


class _Path:
    """A curve as TOPP-RA wants it."""

    def __init__(self, curve: Curve) -> None:
        self._curve = curve
        self.path_interval: Points = np.array([curve.t[0], curve.t[-1]])
        self.dof = 6
        self.waypoints = None

    def __call__(self, at: Any, order: int = 0) -> Points:
        return self._curve(at, order)


def _law(grid: Points, rates: Points) -> tuple[Points, Points]:
    """Give the rate over time, from that at each node: straight between two of them."""
    steps = 2.0 * np.diff(grid) / np.maximum(rates[1:] + rates[:-1], 1e-9)
    return np.concatenate([[0.0], np.cumsum(steps)]), rates


def _smooth(grid: Points, times: Points, rates: Points, window: float) -> tuple[Points, ...]:
    """Give place, rate and its change at equal intervals, after a moving average of the rate.

    The place is a spline of fifth order, whose derivatives are exact.

    Returns:
        Times, places, rates, and their derivatives.
    """
    count = max(int(np.ceil(times[-1] / _TICK)), 2)
    tick = float(times[-1]) / count
    rate = np.interp((np.arange(count) + 0.5) * tick, times, rates)
    for width in (window, 0.25 * window):
        taps = max(round(width / tick), 1)
        rate = np.convolve(rate, np.full(taps, 1.0 / taps))
    places = np.concatenate([[0.0], np.cumsum(rate)])
    places = grid[0] + places * ((grid[-1] - grid[0]) / places[-1])
    control = np.concatenate([np.full(_ORDER, places[0]), places, np.full(_ORDER, places[-1])])
    knots = tick * (np.arange(len(control) + _ORDER + 1) - _ORDER)
    law = BSpline(knots, control, _ORDER)
    at = tick * np.arange(len(control) - _ORDER + 1)
    place: Points = np.clip(law(at), grid[0], grid[-1]).astype(np.float64)
    rate_then: Points = law(at, 1)
    change: Points = law(at, 2)
    return at.astype(np.float64), place, rate_then, change


def _along(curve: Curve, law: tuple[Points, ...]) -> TimedPath:
    """Give the joints at places reached with a rate."""
    times, places, rates, pushes = law
    one, two = curve(places, 1), curve(places, 2)
    velocities = one * rates[:, None]
    return TimedPath(
        times, curve(places), velocities, one * pushes[:, None] + two * rates[:, None] ** 2
    )


def _excess(found: TimedPath, limits: MotionLimits) -> Points:
    """By interval, how many times slower it must be to be within all limits. Shape (n - 1,)."""
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
    # The jerk is a parabola of u: its extreme besides its ends.
    with np.errstate(divide="ignore", invalid="ignore"):
        top = np.nan_to_num(np.clip(-0.2 * fourth / fifth, 0.0, 1.0))
    three = [6 * third + at * (24 * fourth + at * 60 * fifth) for at in (0.0, top, 1.0)]
    fast = np.abs(one / (step * speed)).max(axis=(0, 2))
    hard = np.abs(two / (step**2 * acceleration)).max(axis=(0, 2))
    sharp = np.abs(np.array(three) / (step**3 * jerk)).max(axis=(0, 2))
    worst: Points = np.maximum(np.maximum(fast, np.sqrt(hard)), np.cbrt(sharp))
    return worst


def _starts(found: TimedPath) -> tuple[Points, Points, Points]:
    return found.positions[:-1], found.velocities[:-1], found.accelerations[:-1]


class _Bounds(toppra.constraint.LinearConstraint):  # type: ignore[misc]  # TOPP-RA has no types
    """The limits at each node, and a lower rate where the curve bends more and more sharply."""

    def __init__(self, limits: MotionLimits, ease: Points, rate: float) -> None:
        super().__init__()
        self._limits, self._ease, self._rate = limits, ease, min(rate, 1e3)
        self.identical = True
        self.set_discretization_type(1)  # between the nodes too

    def compute_constraint_params(self, path: Any, grid: Points, *_: Any) -> tuple[Any, ...]:
        """Coefficients of the limits, as TOPP-RA wants them."""
        speed, acceleration, jerk = self._limits.arrays
        ease = self._ease[:, None]
        along, bend, change = (path(grid, order) for order in (1, 2, 3))
        with np.errstate(divide="ignore"):
            fastest = (speed / np.abs(along)).min(axis=1) ** 2
            smooth = (jerk / np.abs(change)).min(axis=1) ** (2.0 / 3.0)
        most = np.minimum(np.minimum(fastest, smooth), self._rate**2) * self._ease
        bounds = np.column_stack([np.zeros(len(grid)), most])
        scale = ease * acceleration
        sides = np.vstack([np.eye(6), -np.eye(6)])
        zero = np.zeros((len(grid), 6))
        return along / scale, bend / scale, zero, sides, np.ones(12), None, bounds
