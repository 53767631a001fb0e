"""Paths: polynomials through samples, and their derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from aioduco.models.rotation import Array
from aioduco.sim.planner.path import Path, differentiate


def wave(s: Array) -> Array:
    """Six joints, each a different smooth function."""
    return np.stack([np.sin((1 + 0.3 * i) * s + i) for i in range(6)], axis=-1)


def sampled(count: int, length: float) -> Path:
    q = wave(np.linspace(0, length, count + 1))
    return Path.through(q, *differentiate(q, length / count), length)


@pytest.mark.parametrize("degree", range(7))
def test_differences_are_exact_for_polynomials(degree: int) -> None:
    polynomial = np.polynomial.Polynomial(np.arange(1.0, degree + 2))
    s = np.linspace(0, 1, 12)
    slope, bend = differentiate(polynomial(s)[:, None], s[1])
    np.testing.assert_allclose(slope[:, 0], polynomial.deriv(1)(s), rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(bend[:, 0], polynomial.deriv(2)(s), rtol=1e-7, atol=1e-8)


def test_path_keeps_to_the_function_it_was_sampled_from() -> None:
    path = sampled(40, 3.0)
    s = np.linspace(0, 3, 997)
    q, slope, bend = np.moveaxis(path.sample(s), 1, 0)
    step = 1e-5
    np.testing.assert_allclose(q, wave(s), atol=1e-6)
    np.testing.assert_allclose(slope, (wave(s + step) - wave(s - step)) / (2 * step), atol=1e-4)
    curve = (wave(s + 1e-4) - 2 * wave(s) + wave(s - 1e-4)) / 1e-8
    np.testing.assert_allclose(bend, curve, atol=1e-2)


def test_speeds_and_accelerations_follow_from_the_distance() -> None:
    path = sampled(40, 3.0)
    v, a, step = 0.7, -0.4, 1e-4

    def q(t: float) -> Array:
        s = 1.3 + v * t + 0.5 * a * t * t
        joints: Array = path.state(path.piece(s), s, 0.0, 0.0)[0]
        return joints

    state = path.state(path.piece(1.3), 1.3, v, a)
    np.testing.assert_allclose(state[0], q(0.0), atol=0)
    np.testing.assert_allclose(state[1], (q(step) - q(-step)) / (2 * step), atol=1e-7)
    np.testing.assert_allclose(state[2], (q(step) - 2 * q(0.0) + q(-step)) / step**2, atol=1e-6)


def test_position_slope_and_bend_are_continuous_between_pieces() -> None:
    path = sampled(20, 3.0)
    for s in path.bounds[1:-1]:
        piece = path.piece(s)
        before, after = path.state(piece - 1, s, 1.0, 0.5), path.state(piece, s, 1.0, 0.5)
        np.testing.assert_allclose(before, after, atol=1e-11)


def test_slices_and_joins_keep_the_path() -> None:
    path = sampled(20, 3.0)
    s = np.linspace(0.4, 2.75, 300)
    part = path.slice(0.4, 2.75)
    assert (part.start, part.end) == (0.4, 2.75)
    np.testing.assert_array_equal(part.sample(s), path.sample(s))
    again = path.slice(0.0, 1.15).then(path.slice(1.15, 3.0))
    np.testing.assert_allclose(again.sample(s), path.sample(s), atol=1e-12)
    at_node = path.slice(path.bounds[3], path.bounds[7])
    assert at_node.bounds == path.bounds[3:8]
    moved = path.slice(0.0, 1.0).then(path.slice(2.0, 3.0))
    np.testing.assert_allclose(
        moved.sample(np.array([1.5])), path.sample(np.array([2.5])), atol=1e-12
    )


def test_a_straight_path_is_linear_in_its_length() -> None:
    q0, q1 = np.arange(6.0), np.arange(6.0)[::-1]
    path = Path.straight(q0, q1, 5.0)
    np.testing.assert_allclose(path.sample(np.array([2.0]))[0, 0], q0 + 0.4 * (q1 - q0))
    np.testing.assert_allclose(path.sample(np.array([2.0]))[0, 1], (q1 - q0) / 5.0)


def test_pieces_are_found_forward_from_a_hint() -> None:
    path = sampled(20, 2.0)
    piece = 0
    for s in np.linspace(0.0, 2.0, 777):
        piece = path.piece(s, piece)
        assert piece == path.piece(s)
        assert path.bounds[piece] <= s <= path.bounds[piece + 1]
