"""B-splines of the planner, against those of scipy."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from for_each import for_each

from aioduco.planning.band import BandMatrix
from aioduco.planning.spline import BSpline


@pytest.mark.slow
@pytest.mark.parametrize("degree", [3, 5])
@pytest.mark.parametrize("shape", [(), (6,)])
def test_points_and_derivatives_are_those_of_scipy(degree: int, shape: tuple[int, ...]) -> None:
    random = np.random.default_rng(degree)
    inner = np.sort(random.uniform(0.0, 3.0, 9))
    inner[4] = inner[3]  # two knots upon each other
    knots = np.concatenate([[0.0] * (degree + 1), inner, [3.0] * (degree + 1)])
    control = random.normal(size=(len(knots) - degree - 1, *shape))
    ours, theirs = (
        BSpline(knots, control, degree),
        scipy.interpolate.BSpline(knots, control, degree),
    )
    at = np.concatenate([np.linspace(0.0, 3.0, 301), inner, [-0.1, 3.1]])
    for order in range(4):
        expected = theirs(at, order)
        assert np.abs(ours(at, order) - expected).max() <= 1e-14 * np.abs(expected).max()
    assert np.array_equal(ours(np.array([ours.begin, ours.end])), control[[0, -1]])


@for_each("count", [6, 7, 60, 1000])
def test_the_one_through_points_is_that_of_scipy(count: int) -> None:
    random = np.random.default_rng(count)
    at, points = np.cumsum(random.uniform(0.2, 1.8, count)), random.normal(size=(count, 6))
    found, expected = (
        BSpline.through(at, points),
        scipy.interpolate.make_interp_spline(at, points, k=5),
    )
    between = np.linspace(at[0], at[-1], 777)
    assert np.abs(found(at) - points).max() < 1e-12
    assert np.abs(found(between) - expected(between)).max() < 1e-12 * np.abs(expected.c).max()


def test_a_band_is_solved_as_the_whole_matrix_is_or_refused() -> None:
    random = np.random.default_rng(1)
    whole, first = np.zeros((30, 30)), np.arange(27)
    upper = np.triu_indices(4)
    blocks = np.empty((len(upper[0]), len(first)))
    for i in first:
        part = random.normal(size=(4, 4))
        square = 1e-9 * part @ part.T  # small, and still not zero
        whole[i : i + 4, i : i + 4] += square
        blocks[:, i] = square[upper]
    right = random.normal(size=30)
    found = BandMatrix(first, blocks, 30, 4).solve(right)
    assert found == pytest.approx(scipy.linalg.solve(whole, right), rel=1e-6)
    for wrong in (-blocks, blocks * np.nan):
        with pytest.raises(np.linalg.LinAlgError):
            BandMatrix(first, wrong, 30, 4)
