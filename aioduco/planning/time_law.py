"""The fastest way through a path in time: an interior-point method, from a law that is slower.

A law gives the place on the path over a time. It is passed at another pace: with `b`, the square of
the pace over that time, speed, acceleration and jerk of each joint are

    q' √b,    q'' b + q' b'/2,    √b (q''' b + 3/2 q'' b' + q' b''/2)

where q', q'', q''' are those of the law itself. The ends are at rest for any pace, as the law is.
`b` is a cubic spline; its coefficients are moved by Newton's method on the duration with barriers
at the limits, which are made steeper from step to step. Each step costs what grows with the
number of nodes, not more.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, solveh_banded

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.planning.motion_limits import MotionLimits

    Points = NDArray[np.float64]

__all__ = ["PaceSpline", "PathNodes", "faster"]

_STEPS = 40  # of Newton's method, at most
_SOFT, _HARD = 1e-3, 3e-6  # weight of the barriers, at first and at last
_STEEPER = 0.3
_INSIDE = 0.97  # of the limits, at which it begins
_BASES = 4  # of a cubic spline that are not zero at one place


class PathNodes(NamedTuple):
    """Places of a law at which the limits are kept.

    Attributes:
        times: rising, from 0 [s]. Shape (n,).
        first, second, third: derivatives of the joints over the time. Shape (n, 6) each.
        rates: of the path's length over the time. Shape (n,).
        tighter: how many times lower speed, acceleration and jerk have to be than their limits.
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
        end: of the law [s].
        spans: of the spline.
        coefficients: Shape (spans + 3,); None for a pace of one.
    """

    def __init__(self, end: float, spans: int, coefficients: Points | None = None) -> None:
        self.end, self.spans = end, spans
        self.coefficients: Points = (
            np.ones(spans + _BASES - 1) if coefficients is None else coefficients
        )

    def __call__(self, times: Points) -> Points:
        """The square and its first two derivatives. Shape (n, 3)."""
        first, bases = self.bases(times)
        return _weighed(bases, self.coefficients[_rows(first)])

    def bases(self, times: Points) -> tuple[Any, Points]:
        """The first coefficient that counts at each time, and what it and the next count.

        Returns:
            Shapes (n,) and (n, 4, 3): value and two derivatives.
        """
        width = self.end / self.spans
        at = np.clip(times / width, 0.0, self.spans)
        first = np.minimum(at.astype(int), self.spans - 1)
        u = at - first
        w = 1.0 - u
        value = [w**3, 3 * u**3 - 6 * u**2 + 4, 3 * w**3 - 6 * w**2 + 4, u**3]
        slope = [-(w**2), 3 * u**2 - 4 * u, -3 * w**2 + 4 * w, u**2]
        bend = [w, 3 * u - 2, 3 * w - 2, u]
        found = np.empty((len(times), _BASES, 3))
        found[:, :, 0] = np.transpose(value) / 6.0
        found[:, :, 1] = np.transpose(slope) / (2.0 * width)
        found[:, :, 2] = np.transpose(bend) / width**2
        return first, found

    def passed(self, times: Points) -> Points:
        """When the law's times are reached at this pace [s]. Shape (n,)."""
        # Gauss's rule of three points in each interval.
        off, weights = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]), np.array([5.0, 8.0, 5.0]) / 18
        widths = np.diff(times)
        inner = times[:-1, None] + widths[:, None] * (0.5 + 0.5 * off)
        slowness = 1.0 / np.sqrt(self(inner.ravel())[:, 0])
        took = slowness.reshape(inner.shape) @ weights * widths
        return np.concatenate([[0.0], np.cumsum(took)])


class _Barriers:
    """The duration with barriers at the limits, over the spline's coefficients.

    Args:
        nodes: where the limits are kept.
        pace: whose coefficients are moved.
        limits: of the joints.
        rate: how fast the path's length may be passed.
    """

    def __init__(
        self, nodes: PathNodes, pace: PaceSpline, limits: MotionLimits, rate: float
    ) -> None:
        speed, acceleration, jerk = limits.arrays
        times, one, two, three, rates, tighter = nodes
        first, self._bases = pace.bases(times)
        self._rows = _rows(first)
        self._count = len(pace.coefficients)
        shares = np.zeros(len(times))
        shares[:-1] += np.diff(times)
        shares[1:] += np.diff(times)
        self._shares = 0.5 * shares / times[-1]
        hard = tighter[:, None, 1] / acceleration
        sharp = tighter[:, None, 2] / jerk
        # What value and derivatives of b count in acceleration and jerk, as shares of the limits.
        self._hard = np.stack([two * hard, 0.5 * one * hard], axis=2)
        self._sharp = np.stack([three * sharp, 1.5 * two * sharp, 0.5 * one * sharp], axis=2)
        self._fast = np.maximum(
            (np.abs(one) * tighter[:, :1] / speed).max(axis=1) ** 2, (rates / rate) ** 2
        )
        # The same, of the coefficients. Shape (n, 6, 4) each.
        self._hard_rows = self._hard @ self._bases[:, :, :2].transpose(0, 2, 1)
        self._sharp_rows = self._sharp @ self._bases.transpose(0, 2, 1)
        upper = np.triu_indices(_BASES)
        self._upper = upper
        band = _BASES - 1 - (upper[1] - upper[0])
        self._places = (band * self._count + first[:, None] + upper[1]).ravel()

    def at(self, coefficients: Points) -> Points:
        """The square of the pace and its derivatives at the nodes. Shape (n, 3)."""
        return _weighed(self._bases, coefficients[self._rows])

    def worst(self, b: Points) -> float:
        """How many times the square of the pace is too large."""
        _, hard, sharp, _ = self._used(b)
        sharpest = float(np.abs(sharp).max()) ** (2.0 / 3.0)
        return max(float(np.abs(hard).max()), sharpest, float((self._fast * b[:, 0]).max()))

    def value(self, b: Points, weight: float) -> float:
        """What is made least; infinite outside of the limits."""
        if b[:, 0].min() <= 0.0:
            return float("inf")
        root, hard, sharp, _ = self._used(b)
        room = [1.0 - hard**2, 1.0 - sharp**2, 1.0 - self._fast * b[:, 0]]
        if min(float(each.min()) for each in room) <= 0.0:
            return float("inf")
        return float((self._shares / root).sum() - weight * sum(np.log(r).sum() for r in room))

    def step(self, b: Points, weight: float) -> tuple[Points, float]:
        """Newton's step of the coefficients, and by how much it is to lower the value.

        Raises:
            LinAlgError: there is none.
        """
        root, hard, sharp, unscaled = self._used(b)
        value = b[:, 0]
        hard_room, sharp_room, left = 1.0 - hard**2, 1.0 - sharp**2, 1.0 - self._fast * value
        bases = self._bases[:, :, 0]
        sharp_rows = self._sharp_rows * root[:, None, None]
        sharp_rows += (0.5 * unscaled / root[:, None])[:, :, None] * bases[:, None, :]
        slope = np.matmul((2.0 * weight * hard / hard_room)[:, None, :], self._hard_rows)[:, 0]
        slope += np.matmul((2.0 * weight * sharp / sharp_room)[:, None, :], sharp_rows)[:, 0]
        of_value = weight * self._fast / left - 0.5 * self._shares * value**-1.5
        slope += of_value[:, None] * bases
        # Of the barriers the part that is never negative (Gauss and Newton's).
        bent = np.concatenate(
            [
                self._hard_rows * (np.sqrt(2.0 * weight * (1.0 + hard**2)) / hard_room)[:, :, None],
                sharp_rows * (np.sqrt(2.0 * weight * (1.0 + sharp**2)) / sharp_room)[:, :, None],
                bases[:, None, :]
                * np.sqrt(
                    0.75 * self._shares * value**-2.5 + weight * (self._fast / left) ** 2
                )[:, None, None],
            ],
            axis=1,
        )
        local = np.matmul(bent.transpose(0, 2, 1), bent)[:, self._upper[0], self._upper[1]]
        count = self._count
        banded = np.bincount(self._places, local.ravel(), _BASES * count).reshape(_BASES, count)
        banded[-1] += 1e-12 * banded[-1].max()
        gradient = np.bincount(self._rows.ravel(), slope.ravel(), count)
        found: Points = -solveh_banded(banded, gradient, check_finite=False)
        return found, float(-(gradient @ found))

    def _used(self, b: Points) -> tuple[Points, Points, Points, Points]:
        root = np.sqrt(b[:, 0])
        hard = np.matmul(self._hard, b[:, :2, None])[:, :, 0]
        unscaled = np.matmul(self._sharp, b[:, :, None])[:, :, 0]
        return root, hard, unscaled * root[:, None], unscaled


def faster(
    nodes: PathNodes,
    pace: PaceSpline,
    limits: MotionLimits,
    rate: float,
    soft: float = _SOFT,
) -> PaceSpline:
    """Give the pace at which a law is passed soonest within all limits.

    Args:
        nodes: where the limits are kept.
        pace: to begin with; it is scaled so far that it is within the limits.
        limits: of the joints.
        rate: how fast the path's length may be passed [its unit per second].
        soft: weight of the barriers at first; less for a pace that is nearly the best.
    """
    barriers = _Barriers(nodes, pace, limits, rate)
    coefficients = pace.coefficients
    weight, rest = soft, 2
    coefficients = coefficients * (_INSIDE / barriers.worst(barriers.at(coefficients)))
    b = barriers.at(coefficients)
    for _ in range(_STEPS):
        try:
            step, gain = barriers.step(b, weight)
        except LinAlgError:
            break
        before, change, part = barriers.value(b, weight), barriers.at(step), 1.0
        while not barriers.value(b + part * change, weight) <= before - 1e-4 * part * gain:
            part *= 0.6
            if part < 1e-6:
                return PaceSpline(pace.end, pace.spans, coefficients)
        coefficients, b = coefficients + part * step, b + part * change
        if weight <= _HARD:
            rest -= 1
            if rest == 0:
                break
        elif part > 0.3:
            weight = max(weight * _STEEPER, _HARD)
    return PaceSpline(pace.end, pace.spans, coefficients)


def _rows(first: Any) -> Any:
    return first[:, None] + np.arange(_BASES)


def _weighed(bases: Points, coefficients: Points) -> Points:
    found: Points = np.matmul(coefficients[:, None, :], bases)[:, 0]
    return found
