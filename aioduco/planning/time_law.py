"""The fastest timing of a path: an interior-point method that starts from a slower time law.

A law gives the position on the path over time. It is run at another pace: with `b`, the square of
the pace over that time, speed, acceleration and jerk of each joint are

    q' √b,    q'' b + q' b'/2,    √b (q''' b + 3/2 q'' b' + q' b''/2)

where q', q'', q''' are those of the law itself. The ends are at rest at any pace, since the law's
ends are at rest. `b` is a cubic spline. Newton's method finds its coefficients: it minimizes the
duration plus barriers at the limits, which are made steeper from step to step. The cost of a step
grows linearly with the number of nodes. Internally, the last axis of arrays is the nodes: numpy
then sums over six joints of a thousand nodes several times as fast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.planning.band import BandMatrix

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.planning.motion_limits import MotionLimits

    Points = NDArray[np.float64]


_STEPS = 40  # of Newton's method, at most
_SOFT, _HARD = 0.025, 2.5e-3  # weight of the barriers of all nodes, at first and at last
_STEEPER = 0.15
_INSIDE = 0.97  # share of the limits at which the method begins
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))  # pairs of derivatives
_ENOUGH = 5e-3  # share of the duration that a step may still gain at the end
_BASES = 4  # basis functions of a cubic spline that are not zero at one place


class PathNodes(NamedTuple):
    """Points of a law at which the limits are enforced.

    Attributes:
        times: rising, from 0 [s]. Shape (n,).
        first, second, third: derivatives of the joints over the time. Shape (n, 6) each.
        rates: derivatives of the path's length over the time. Shape (n,).
        tighter: factors by which speed, acceleration and jerk have to be lower than their limits.
            Shape (n, 3).
    """

    times: Points
    first: Points
    second: Points
    third: Points
    rates: Points
    tighter: Points


class PaceSpline:
    """The square of a pace over the time of a law.

    Args:
        end: end of the law [s].
        spans: number of spans of the spline.
        coefficients: coefficients of the spline. Shape (spans + 3,); None for a pace of one.
    """

    def __init__(self, end: float, spans: int, coefficients: Points | None = None) -> None:
        self.end: float = end
        self.spans: int = spans
        self.coefficients: Points = (
            np.ones(spans + _BASES - 1) if coefficients is None else coefficients
        )

    def __call__(self, times: Points) -> Points:
        """The square and its first two derivatives. Shape (3, n)."""
        first, bases = self.bases(times)
        return _weighed(bases, self.coefficients[_rows(first)])

    def bases(self, times: Points) -> tuple[Any, Points]:
        """The first coefficient with an effect at each time, and the factors of it and the next.

        Returns:
            Shapes (n,) and (4, 3, n): value and two derivatives.
        """
        width = self.end / self.spans
        at = np.clip(times / width, 0.0, self.spans)
        first = np.minimum(at.astype(int), self.spans - 1)
        u = at - first
        w = 1.0 - u
        value = [w**3, 3 * u**3 - 6 * u**2 + 4, 3 * w**3 - 6 * w**2 + 4, u**3]
        slope = [-(w**2), 3 * u**2 - 4 * u, -3 * w**2 + 4 * w, u**2]
        bend = [w, 3 * u - 2, 3 * w - 2, u]
        found = np.empty((_BASES, 3, len(times)))
        found[:, 0] = value
        found[:, 1] = slope
        found[:, 2] = bend
        found *= np.array([1.0 / 6.0, 0.5 / width, 1.0 / width**2])[:, None]
        return first, found

    def times_at(self, times: Points) -> Points:
        """Give the times at which the law's times are reached at this pace [s]. Shape (n,)."""
        # Gauss's rule of three points in each interval.
        off, weights = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]), np.array([5.0, 8.0, 5.0]) / 18
        widths = np.diff(times)
        inner = times[:-1, None] + widths[:, None] * (0.5 + 0.5 * off)
        slowness = 1.0 / np.sqrt(self(inner.ravel())[0])
        took = slowness.reshape(inner.shape) @ weights * widths
        return np.concatenate([[0.0], np.cumsum(took)])


class _Barriers:
    """The duration plus barriers at the limits, as a function of the spline's coefficients.

    Args:
        nodes: points at which the limits are enforced.
        pace: spline whose coefficients are changed.
        limits: limits of the joints.
        rate: largest derivative of the path's length over time.
    """

    def __init__(
        self, nodes: PathNodes, pace: PaceSpline, limits: MotionLimits, rate: float
    ) -> None:
        speed, acceleration, jerk = (limit[:, None] for limit in limits.arrays)
        times, rates, tighter = nodes.times, nodes.rates, nodes.tighter.T
        one, two, three = (
            np.ascontiguousarray(part.T) for part in (nodes.first, nodes.second, nodes.third)
        )
        self._first, self._bases = pace.bases(times)
        self._rows = _rows(self._first)
        self._count = len(pace.coefficients)
        shares = np.zeros(len(times))
        shares[:-1] += np.diff(times)
        shares[1:] += np.diff(times)
        self._shares = 0.5 * shares / times[-1]
        hard = tighter[1] / acceleration
        sharp = tighter[2] / jerk
        # Factors of b and its derivatives in acceleration and jerk, as shares of the limits.
        self._hard = two * hard, 0.5 * one * hard
        self._sharp = three * sharp, 1.5 * two * sharp, 0.5 * one * sharp
        self._fast = np.maximum(
            (np.abs(one) * tighter[0] / speed).max(axis=0) ** 2, (rates / rate) ** 2
        )
        first_of, other = np.triu_indices(_BASES)
        # Factors of each second derivative by b and its derivatives, for pairs of coefficients.
        left, right = self._bases[first_of], self._bases[other]
        self._curves = np.empty((len(first_of), len(_PAIRS), len(times)))
        for column, (i, j) in enumerate(_PAIRS):
            np.multiply(left[:, i], right[:, j], out=self._curves[:, column])
            if i != j:
                self._curves[:, column] += left[:, j] * right[:, i]

    def at(self, coefficients: Points) -> Points:
        """The square of the pace and its derivatives at the nodes. Shape (3, n)."""
        return _weighed(self._bases, coefficients[self._rows])

    def worst(self, b: Points) -> float:
        """Factor by which the square of the pace is too large."""
        hard, unscaled = self.shares(b)
        sharpest = float((np.abs(unscaled).max(axis=0) * np.sqrt(b[0])).max())
        fastest = float((self._fast * b[0]).max())
        return max(float(np.abs(hard).max()), float(np.cbrt(sharpest**2)), fastest)

    def shares(self, b: Points) -> tuple[Points, Points]:
        """Shares of the limits of acceleration, and of jerk at a pace of one; linear in b."""
        hard = self._hard[0] * b[0] + self._hard[1] * b[1]
        return hard, self._sharp[0] * b[0] + self._sharp[1] * b[1] + self._sharp[2] * b[2]

    def value(self, square: Points, hard: Points, unscaled: Points, weight: float) -> float:
        """The function to minimize; infinite outside of the limits."""
        if square.min() <= 0.0:
            return float("inf")
        room = 1.0 - hard * hard
        sharp = 1.0 - unscaled * unscaled * square
        left = 1.0 - self._fast * square
        if min(sharp.min(), room.min(), left.min()) <= 0.0:
            return float("inf")
        barriers = np.log(room.prod(axis=0) * left * sharp.prod(axis=0)).sum()
        return float((self._shares / np.sqrt(square)).sum() - weight * barriers)

    def furthest(self, square: Points, hard: Points, change: Points, of_hard: Points) -> float:
        """Largest share of a step, at most 1, within the limits of speed and acceleration."""
        with np.errstate(divide="ignore"):
            ends = [
                (np.abs(of_hard) / (1.0 - np.where(of_hard > 0.0, hard, -hard))).max(),
                (self._fast * change / (1.0 - self._fast * square)).max(),
                (-change / square).max(),
            ]
        return min(1.0, 0.95 / max(float(max(ends)), 1e-9))

    def step(
        self, value: Points, hard: Points, unscaled: Points, weight: float
    ) -> tuple[Points, float]:
        """Newton's step of the coefficients, and the decrease of the value that it predicts.

        Raises:
            LinAlgError: there is no such step.
        """
        root = np.sqrt(value)
        sharp = unscaled * root
        hard_room, sharp_room, left = 1.0 - hard**2, 1.0 - sharp**2, 1.0 - self._fast * value
        # Derivatives of the shares of acceleration and jerk by b, b' and b''.
        ones = self._hard
        twos = [share * root for share in self._sharp]
        twos[0] += 0.5 * unscaled / root
        push, pull = hard / hard_room, sharp / sharp_room
        slope = np.empty((3, len(value)))
        for i, share in enumerate(twos):
            slope[i] = (pull * share).sum(axis=0)
        for i, share in enumerate(ones):
            slope[i] += (push * share).sum(axis=0)
        slope *= 2.0 * weight
        slope[0] += weight * self._fast / left - 0.5 * self._shares * value**-1.5
        # Only the part of the second derivatives that is never negative (Gauss-Newton).
        stiff, stiffer = (1.0 + hard**2) / hard_room**2, (1.0 + sharp**2) / sharp_room**2
        curves = np.empty((len(_PAIRS), len(value)))
        for column, (i, j) in enumerate(_PAIRS):
            curves[column] = (stiffer * twos[i] * twos[j]).sum(axis=0)
            if j < 2:
                curves[column] += (stiff * ones[i] * ones[j]).sum(axis=0)
        curves *= 2.0 * weight
        curves[0] += 0.75 * self._shares * value**-2.5 + weight * (self._fast / left) ** 2
        local = np.einsum("kn,pkn->pn", curves, self._curves)
        count = self._count
        slopes = np.einsum("kn,pkn->pn", slope, self._bases)
        gradient = np.bincount(self._rows.ravel(), slopes.ravel(), count)
        found = -BandMatrix(self._first, local, count, _BASES).solve(gradient)
        return found, float(-(gradient @ found))


def faster(
    nodes: PathNodes,
    pace: PaceSpline,
    limits: MotionLimits,
    rate: float,
    soft: float = _SOFT,
) -> PaceSpline:
    """Give the pace at which a law is fastest within all limits.

    Args:
        nodes: points at which the limits are enforced.
        pace: pace to begin with; it is first scaled to be within the limits.
        limits: limits of the joints.
        rate: largest derivative of the path's length over time [its unit per second].
        soft: weight of all barriers at first; less for a pace that is nearly the best.
    """
    barriers = _Barriers(nodes, pace, limits, rate)
    coefficients = pace.coefficients
    weight, last = soft / len(nodes.times), _HARD / len(nodes.times)
    coefficients = coefficients * (_INSIDE / barriers.worst(barriers.at(coefficients)))
    b = barriers.at(coefficients)
    square, hard, sharp = b[0], *barriers.shares(b)
    for _ in range(_STEPS):
        try:
            step, gain = barriers.step(square, hard, sharp, weight)
        except np.linalg.LinAlgError:
            break
        b = barriers.at(step)
        change, of_hard, of_sharp = b[0], *barriers.shares(b)
        before = barriers.value(square, hard, sharp, weight)
        part = barriers.furthest(square, hard, change, of_hard)
        while True:
            moved = square + part * change, hard + part * of_hard, sharp + part * of_sharp
            if barriers.value(*moved, weight) <= before - 1e-4 * part * gain:
                break
            part *= 0.5
            if part < 1e-6:
                return PaceSpline(pace.end, pace.spans, coefficients)
        coefficients = coefficients + part * step
        square, hard, sharp = moved
        if weight <= last and gain < _ENOUGH:
            break
        if part > 0.2:
            weight = max(weight * _STEEPER, last)
    return PaceSpline(pace.end, pace.spans, coefficients)


def _rows(first: Any) -> Any:
    return first + np.arange(_BASES)[:, None]


def _weighed(bases: Points, coefficients: Points) -> Points:
    found: Points = np.einsum("pn,pkn->kn", coefficients, bases)
    return found
