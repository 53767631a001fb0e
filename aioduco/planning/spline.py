"""B-splines: points over a length, with their derivatives, and the one through given points."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.planning.band import BandMatrix

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Points = NDArray[np.float64]


class BSpline:
    """A curve of numbers or points over a length.

    Outside of its ends it goes on as its first and its last span do.

    Args:
        knots: rising. Shape (n + degree + 1,).
        control: control points. Shape (n,) or (n, dimensions).
        degree: degree of each span.

    Attributes:
        knots, control, degree: the same.
    """

    def __init__(self, knots: Any, control: Any, degree: int) -> None:
        self.knots: Points = np.asarray(knots, np.float64)
        self.control: Points = np.asarray(control, np.float64)
        self.degree: int = degree

    @classmethod
    def through(cls, at: Points, points: Points, degree: int = 5) -> BSpline:
        """Give the spline of odd degree through points, as smooth at the ends as inside.

        Args:
            at: lengths, rising. Shape (n,), n above the degree.
            points: shape (n, dimensions).
            degree: odd.
        """
        cut = (degree + 1) // 2
        knots = np.concatenate([[at[0]] * (degree + 1), at[cut:-cut], [at[-1]] * (degree + 1)])
        first, weights = _weights(knots, at, degree)
        low, high = np.triu_indices(degree + 1)
        squares = BandMatrix(first, weights[low] * weights[high], len(at), degree + 1)
        rows = first + np.arange(degree + 1)[:, None]
        found = np.zeros(points.shape)
        # The normal equations lose half of the digits; each repetition gains them again.
        for _ in range(3):
            for axis, left in enumerate((points - _blended(weights, found[rows])).T):
                found[:, axis] += squares.solve(
                    np.bincount(rows.ravel(), (weights * left).ravel(), len(at))
                )
        return cls(knots, found, degree)

    @property
    def begin(self) -> float:
        """Where it begins."""
        return float(self.knots[self.degree])

    @property
    def end(self) -> float:
        """Where it ends."""
        return float(self.knots[-1 - self.degree])

    def __call__(self, at: Points, order: int = 0) -> Points:
        """Give the points, or a derivative of them.

        Args:
            at: lengths. Shape (m,).
            order: order of the derivative; 0 for the points.

        Returns:
            Shape (m,) or (m, dimensions).
        """
        if order:
            return self._slope(at, order - 1)
        first, weights = _weights(self.knots, at, self.degree)
        return _blended(weights, self.control[first + np.arange(self.degree + 1)[:, None]])

    @cached_property
    def _slope(self) -> BSpline:
        """The first derivative."""
        if not self.degree:
            return BSpline(self.knots, np.zeros_like(self.control), 0)
        inner = self.knots[1:-1]
        widths = (inner[self.degree :] - inner[: -self.degree]) / self.degree
        # Where knots lie upon each other, the control point has no effect.
        shares = np.divide(1.0, widths, out=np.zeros_like(widths), where=widths > 0.0)
        steps = np.diff(self.control, axis=0)
        return BSpline(
            inner, steps * (shares[:, None] if steps.ndim > 1 else shares), self.degree - 1
        )


def _weights(knots: Points, at: Points, degree: int) -> tuple[NDArray[np.intp], Points]:
    """The first control point with an effect at each length, and the effects of it and the next.

    Returns:
        Shapes (m,) and (degree + 1, m).
    """
    first = np.searchsorted(knots[degree + 1 : -degree - 1], at, side="right")
    found = np.zeros((degree + 1, len(at)))
    found[degree] = 1.0
    near = knots[first + np.arange(1, 2 * degree + 1)[:, None]]
    for order in range(1, degree + 1):
        low, high = near[degree - order : degree], near[degree : degree + order]
        before, share = found[degree - order + 1 :].copy(), (at - low) / (high - low)
        found[degree - order : degree] = (1.0 - share) * before
        found[degree] = 0.0
        found[degree - order + 1 :] += share * before
    return first, found


def _blended(weights: Points, control: Points) -> Points:
    found: Points = np.einsum("jm,jm...->m...", weights, control)
    return found
