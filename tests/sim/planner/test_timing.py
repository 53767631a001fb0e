"""Time laws against closed forms, and against a brute-force integration of the same limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given, settings
from hypothesis import strategies as st
from quick import examples

from aioduco.models.rotation import Array
from aioduco.sim.planner.timing import PathLimits, TimeLaw, allowed, backward, fastest

from .motions import trapezoid


def plain(length: float, v: float, a: float) -> PathLimits:
    return PathLimits([0.0, length], [v * v] * 2, [a], [math.inf], [0.0], [10 * a])


def law_of(limits: PathLimits, exit_: float = 0.0) -> TimeLaw:
    return fastest(limits, backward(limits, exit_), 0.0, 0.0)


@st.composite
def limits_along_a_path(draw: st.DrawFn) -> PathLimits:
    pieces = draw(st.integers(1, 12))
    lengths = draw(st.lists(st.floats(0.01, 1.0), min_size=pieces, max_size=pieces))

    def each(low: float, high: float, count: int) -> list[float]:
        return draw(st.lists(st.floats(low, high), min_size=count, max_size=count))

    curvature = [max(c, 0.0) for c in each(-2.0, 3.0, pieces)]
    total = each(0.5, 5.0, pieces)
    ceiling = each(0.01, 4.0, pieces + 1)
    for i in range(pieces):
        # As `cartesian_limits` does: a bend is not taken faster than it can be.
        for end in (i, i + 1):
            if curvature[i]:
                ceiling[end] = min(ceiling[end], 0.98 * total[i] / curvature[i])
    nodes = [0.0, *np.cumsum(lengths).tolist()]
    return PathLimits(nodes, ceiling, each(0.3, 5.0, pieces), total, curvature, [9.0] * pieces)


@for_each(
    "length, v, a",
    [(1.0, 0.25, 1.0), (0.01, 1.0, 2.0), (2.0, 5.0, 0.1), (1e-6, 1.0, 1.0), (100.0, 0.01, 50.0)],
)
def test_a_plain_motion_takes_the_time_of_a_trapezoid(length: float, v: float, a: float) -> None:
    law = law_of(plain(length, v, a))
    assert law.duration == pytest.approx(trapezoid(length, v, a), rel=1e-9)
    assert (law.end, law.end_speed) == (length, 0.0)


def test_plain_limits_cut_into_pieces_change_nothing() -> None:
    nodes = np.linspace(0, 1, 51).tolist()
    pieces = PathLimits(nodes, [0.25**2] * 51, [1.0] * 50, [math.inf] * 50, [0.0] * 50, [1.0] * 50)
    assert law_of(pieces).duration == pytest.approx(1 / 0.25 + 0.25, rel=1e-9)


@pytest.mark.slow
@given(limits_along_a_path())
def test_no_limit_is_exceeded_and_the_law_hangs_together(limits: PathLimits) -> None:
    law = law_of(limits)
    times = np.linspace(0, law.duration, 400)
    _, s, v, a = np.array([law.at(t) for t in times]).T
    assert s[0] == 0.0
    assert s[-1] == pytest.approx(limits.nodes[-1], abs=1e-9)
    assert v[-1] == pytest.approx(0.0, abs=1e-6)
    assert (np.diff(s) >= -1e-12).all()
    ceiling = np.interp(s, limits.nodes, limits.ceiling)
    assert (v**2 <= ceiling * (1 + 1e-6) + 1e-9).all()
    # Distance is the integral of speed, speed that of acceleration, exact for each piece
    step = np.diff(times)
    # but for the corners between them.
    corner = 2.5 * step[0] ** 2
    np.testing.assert_allclose(np.diff(s), (v[1:] + v[:-1]) / 2 * step, rtol=0, atol=corner)
    for at, speed, rate in zip(s[:-1], v, a, strict=False):
        piece = min(np.searchsorted(limits.nodes, at, side="right"), len(limits.nodes) - 1) - 1
        room = [limits.along(i, speed**2) for i in (piece, max(piece - 1, 0))]
        assert abs(rate) <= max(room) * (1 + 1e-6) + 1e-9
        assert law.speed(at) == pytest.approx(speed, abs=1e-6)
        assert law.at(law.time(at))[1] == pytest.approx(at, abs=1e-9)


def brute_force(limits: PathLimits, steps: int) -> float:
    """Duration by stepping through a fine grid with the limits of each point, from both ends.

    Each piece has as many steps, so that the ceiling of each node is met.
    """
    pieces = len(limits.nodes) - 1
    s = np.interp(np.arange(pieces * steps + 1) / steps, np.arange(pieces + 1), limits.nodes)
    ceiling = np.interp(s, limits.nodes, limits.ceiling)
    piece = np.clip(np.searchsorted(limits.nodes, s[:-1], "right") - 1, 0, len(limits.push) - 1)
    ds = np.diff(s)

    def sweep(x: Array, order: range, direction: int) -> None:
        for i in order:
            step = i if direction > 0 else i - 1
            reached = x[i] + 2 * limits.along(int(piece[step]), float(x[i])) * ds[step]
            x[i + direction] = min(x[i + direction], reached)

    x = ceiling.copy()
    x[0] = x[-1] = 0.0
    sweep(x, range(len(ds)), 1)
    sweep(x, range(len(ds), 0, -1), -1)
    v = np.sqrt(x)
    return float((2 * ds / (v[1:] + v[:-1])).sum())


@given(limits_along_a_path())
@settings(max_examples=examples(15))
def test_duration_is_near_the_least_that_the_limits_allow(limits: PathLimits) -> None:
    # The pieces are the law's resolution: cut as finely as those of a real path.
    fine = limits
    for _ in range(5):
        fine = halved(fine)
    least = brute_force(fine, 16)
    assert 0.98 * least <= law_of(fine).duration <= 1.02 * least


def halved(limits: PathLimits) -> PathLimits:
    nodes = np.array(limits.nodes)
    ceiling = np.array(limits.ceiling)
    between = (nodes[1:] + nodes[:-1]) / 2
    every = np.sort(np.concatenate([nodes, between])).tolist()
    heights = np.interp(every, nodes, ceiling).tolist()
    push, total, curvature, brake = (np.repeat(part, 2).tolist() for part in limits[2:6])
    return PathLimits(every, heights, push, total, curvature, brake)


@given(limits_along_a_path(), st.floats(0.01, 0.99))
def test_a_law_from_the_middle_is_the_rest_of_the_whole(limits: PathLimits, part: float) -> None:
    # A bend's limit is that of the fastest point of a piece, so that it changes with its beginning.
    limits = limits._replace(curvature=[0.0] * len(limits.push))
    back = backward(limits, 0.0)
    whole = fastest(limits, back, 0.0, 0.0)
    s = part * limits.nodes[-1]
    speed = whole.speed(s)
    assert speed**2 <= allowed(limits, back, s)
    rest = fastest(limits, back, s, speed)
    assert rest.duration == pytest.approx(whole.duration - whole.time(s), rel=1e-6, abs=1e-7)


@given(limits_along_a_path(), st.floats(0.05, 0.95))
def test_slices_and_joins_keep_the_limits(limits: PathLimits, part: float) -> None:
    cut = part * limits.nodes[-1]
    first, second = limits.slice(0.0, cut), limits.slice(cut, limits.nodes[-1])
    assert first.nodes[-1] == second.nodes[0] == cut
    joined = first.then(second)
    for s in np.linspace(0, limits.nodes[-1], 57):
        before = np.interp(s, limits.nodes, limits.ceiling)
        assert np.interp(s, joined.nodes, joined.ceiling) == pytest.approx(before)
    for one in (first, second, joined):
        assert {len(one.push), len(one.total), len(one.curvature), len(one.brake)} == {
            len(one.nodes) - 1
        }
    assert joined.at(0.37 * limits.nodes[-1], 0.1) == limits.at(0.37 * limits.nodes[-1], 0.1)


def test_slices_at_nodes_have_no_empty_pieces() -> None:
    limits = halved(halved(plain(1.0, 1.0, 1.0)))
    assert list(limits.slice(0.25, 0.75).nodes) == [0.25, 0.5, 0.75]
    assert list(limits.slice(0.0, 1.0).nodes) == list(limits.nodes)
    assert list(limits.slice(0.1, 0.2).nodes) == [0.1, 0.2]


def test_a_law_may_end_at_speed() -> None:
    limits = plain(1.0, 1.0, 1.0)
    law = law_of(limits, 0.25)
    assert law.end_speed == pytest.approx(0.5)
    # Up to 1 m/s and down to 0.5 m/s, with what is left of the metre in between.
    assert law.duration == pytest.approx(1.0 + 0.125 + 0.5)


def test_a_bend_leaves_less_acceleration_along_the_path() -> None:
    limits = PathLimits([0.0, 1.0], [1.0, 1.0], [9.0], [1.0], [0.5], [9.0])
    assert limits.along(0, 0.0) == 1.0
    assert limits.along(0, 1.2) == pytest.approx(0.8)
    assert limits.along(0, 2.0) == 0.0
    gentle, hard = limits.at(0.5, 1.0)
    assert gentle == pytest.approx(math.sqrt(0.75))
    assert hard == 9.0


def test_a_wait_lengthens_the_law_and_nothing_else() -> None:
    plain = PathLimits([0.0, 1.0, 2.0], [1.0] * 3, [2.0] * 2, [math.inf] * 2, [0.0] * 2, [4.0] * 2)
    waiting = plain.waiting([(1.1, 0.5)])
    assert waiting.waits == ((1.0, 0.5),)
    assert waiting.slice(0.5, 1.5).then(plain).waits == ((1.0, 0.5),)
    assert plain.then(waiting).waits == ((3.0, 0.5),)
    law = law_of(waiting)
    standing = law_of(plain._replace(ceiling=[1.0, 0.0, 1.0]))
    assert law.duration == pytest.approx(standing.duration + 0.5)
    begun = law.time(1.0 - 1e-12)
    for after in (0.01, 0.25, 0.49):
        _, s, v, a = law.at(begun + after)
        assert (s, v, a) == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)
    assert law.at(begun + 0.6)[1] > 1.0
