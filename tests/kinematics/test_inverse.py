"""Inverse kinematics: every solution found, to machine precision, one by one and many at once.

`eaik.json` holds solutions made by EAIK; `eaik_reference.py` writes it.
"""

from __future__ import annotations

import dataclasses
import json
import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given, settings
from hypothesis import strategies as st
from quick import examples

from aioduco.errors import ParameterError, Unreachable
from aioduco.kinematics import Arm, DhCorrections, arm, models
from aioduco.kinematics.forward import singular_values
from aioduco.kinematics.inverse import (
    BRANCHES,
    closed_form,
    refine,
    residual,
    shortfall,
    wrap,
)
from aioduco.kinematics.single import nearest_turns, pose_error, solutions
from aioduco.models.pose import Pose
from aioduco.models.rotation import Array

FULL_TURNS = st.lists(st.floats(-2 * math.pi, 2 * math.pi), min_size=6, max_size=6).map(np.array)
MODELS = st.sampled_from(models())
FIVE = arm("gcr5_910")
JOINT_6 = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
REFERENCE: dict[str, Any] = json.loads(
    (Path(__file__).parent / "eaik.json").read_text(encoding="utf-8")
)


def singular(any_arm: Arm, q: Array) -> Array:
    return singular_values(any_arm.geometry, q)


def spread(q: Array, near: Array) -> float:
    """Largest angle between two configurations, whole turns not counted."""
    return float(np.abs(wrap(q - near)).max())


@given(MODELS, FULL_TURNS)
@settings(max_examples=examples(300))
def test_every_solution_reaches_the_pose_and_the_given_one_is_among_them(
    model: str, q: Array
) -> None:
    any_arm = arm(model)
    flange = any_arm.fkine(q)
    found = any_arm.ikine_all(flange)
    assert 1 <= len(found) <= BRANCHES
    assert (np.abs(found) <= math.pi).all()
    error = np.abs(residual(any_arm.geometry, found, flange)).max(axis=1)
    regular = min(any_arm.singularity(q)) > 1e-3
    if regular:
        assert error.max() < 1e-12
        assert min(spread(each, q) for each in found) < 1e-9
    else:
        assert error.max() < 1e-9


@given(MODELS, FULL_TURNS, FULL_TURNS)
@settings(max_examples=examples(200))
def test_no_other_solution_or_turn_is_nearer(model: str, q: Array, near: Array) -> None:
    any_arm = arm(model)
    if min(any_arm.singularity(q)) < 1e-3:
        return
    flange = any_arm.fkine(q)
    best = any_arm.ikine(flange, near)
    assert any_arm.within_limits(best)
    turns = 2 * math.pi * np.arange(-1, 2)
    for each in any_arm.ikine_all(flange):
        options = each[:, None] + turns
        options[np.abs(options) > 2 * math.pi] = np.nan
        nearest = np.nanmin((options - near[:, None]) ** 2, axis=1).sum()
        assert ((best - near) ** 2).sum() <= nearest + 1e-9


@pytest.mark.parametrize("model", models())
def test_all_solutions_are_those_of_eaik(model: str) -> None:
    any_arm, counts = arm(model), set()
    for pose in REFERENCE["arms"][model]:
        flange = any_arm.fkine(pose["q"])
        theirs, ours = np.array(pose["solutions"]), any_arm.ikine_all(flange)
        assert len(ours) == len(theirs)
        counts.add(len(ours))
        for q in theirs:
            assert min(spread(each, q) for each in ours) < 1e-9
            assert spread(any_arm.ikine(flange, q), q) < 1e-9
        np.testing.assert_allclose(any_arm.fkine(ours) - flange, 0.0, atol=1e-12)
    assert max(counts) == BRANCHES
    assert REFERENCE["EAIK"] == "1.2.2"


ANGLES = st.sampled_from([0.0, math.pi, -math.pi, 1e-12, -1e-10, 7e-10, 1e-8, math.pi / 2])


@given(MODELS, FULL_TURNS, st.lists(ANGLES, min_size=6, max_size=6), st.integers(0, 63))
@settings(max_examples=examples(300))
def test_one_pose_is_solved_as_many_are_singular_ones_too(
    model: str, q: Array, special: list[float], which: int
) -> None:
    any_arm = arm(model)
    chosen = np.array([which >> joint & 1 for joint in range(6)], dtype=bool)
    q = np.where(chosen, special, q)
    flange = any_arm.fkine(q)
    together = closed_form(any_arm.geometry, flange, q[5])
    together = together[~np.isnan(together).any(axis=1)]
    alone = solutions(any_arm.geometry, flange.tolist(), q[5])
    # Where solutions meet, the angles of one are known to the root of the rounding error only, and
    # where several joints are singular at once, so is how many there are.
    assert bool(alone) == bool(together.size)
    regular = np.abs(singular(any_arm, together)).min(initial=1.0) > 1e-3
    if regular:
        assert len(alone) == len(together)
        np.testing.assert_allclose(wrap(np.reshape(alone, (-1, 6)) - together), 0.0, atol=1e-9)
    for each in alone:
        assert pose_error(any_arm.geometry, each, flange.tolist()) < 2e-9


@pytest.mark.parametrize("model", models())
def test_an_arm_straight_up_has_eight_solutions_to_both(model: str) -> None:
    """Shoulder, elbow and wrist are singular; rounding gave one of the two half of them."""
    any_arm = arm(model)
    for first in np.linspace(-3.0, 3.0, 61):
        flange = any_arm.fkine([first, 0.0, 0.0, 0.0, 0.0, 0.0])
        together = closed_form(any_arm.geometry, flange)
        assert not np.isnan(together).any()
        alone = solutions(any_arm.geometry, flange.tolist())
        assert len(alone) == BRANCHES
        for each in (*alone, *together.tolist()):
            assert pose_error(any_arm.geometry, tuple(each), flange.tolist()) < 2e-9


SMALL = st.floats(-10.0, -4.0).map(lambda power: 10.0**power)


@given(MODELS, FULL_TURNS, st.sampled_from([0.0, 1e-9, -1e-8, 1e-6]), SMALL)
@settings(max_examples=examples(300))
def test_a_stretched_arm_is_found_however_close_to_the_wrists_singularity(
    model: str, q: Array, bend: float, wrist: float
) -> None:
    """Joint 6 is known to the rounding error by the sine of joint 5 only."""
    any_arm = arm(model)
    q[2], q[4] = bend, wrist
    flange = any_arm.fkine(q)
    together = closed_form(any_arm.geometry, flange, q[5])
    alone = solutions(any_arm.geometry, flange.tolist(), q[5])
    together = together[~np.isnan(together).any(axis=1)]
    reached = [*together, *alone]
    # A joint that rounding turns past its limit is at the limit.
    if min(np.abs(q - any_arm.lower).min(), np.abs(q - any_arm.upper).min()) > 1e-6:
        reached.append(any_arm.ikine(flange, q))
    for each in reached:
        assert pose_error(any_arm.geometry, tuple(each), flange.tolist()) < 2e-9
    assert alone
    assert together.size
    # Both find the arm as it is, to the root of what joint 6 is known to. The other branches may be
    # at the edge of what counts as in reach, where rounding decides; so may this one, where the
    # shoulder is singular, too.
    if any_arm.singularity(q).shoulder > 1e-3:
        for found in (together, np.reshape(alone, (-1, 6))):
            assert np.abs(wrap(found - q)).max(axis=1).min() < 2e-3


@given(MODELS, FULL_TURNS, FULL_TURNS)
def test_what_misses_a_pose_is_the_difference_of_the_forward_kinematics(
    model: str, q: Array, other: Array
) -> None:
    any_arm = arm(model)
    flange = any_arm.fkine(other)
    expected = np.abs(any_arm.fkine(q) - flange).max()
    a, b, c, d, e, f = q.tolist()
    assert pose_error(any_arm.geometry, (a, b, c, d, e, f), flange.tolist()) == pytest.approx(
        expected, abs=1e-13
    )


def test_a_pose_in_the_middle_of_the_workspace_has_eight_solutions() -> None:
    found = FIVE.ikine_all(FIVE.fkine([0.3, 0.4, 1.2, 0.5, -1.1, 2.0]))
    assert len(found) == 8
    distances = [spread(a, b) for i, a in enumerate(found) for b in found[:i]]
    assert min(distances) > 0.1
    # Pairs of a branch share what the branch decides.
    np.testing.assert_allclose(found[:4, 0], found[0, 0])
    np.testing.assert_allclose(np.sign(found[:, 2]), [1, 1, -1, -1] * 2)
    np.testing.assert_allclose(np.sign(found[:, 4]), [1, -1] * 4)


def test_a_whole_path_is_solved_at_once() -> None:
    q = np.random.default_rng(2).uniform(-3, 3, (5, 7, 6))
    flange = FIVE.fkine(q)
    together = closed_form(FIVE.geometry, flange)
    assert together.shape == (5, 7, 8, 6)
    for i in range(5):
        for j in range(7):
            np.testing.assert_allclose(
                together[i, j], closed_form(FIVE.geometry, flange[i, j]), atol=1e-12
            )


@for_each(
    "joint5, turned",
    product(
        [0.0, math.pi, -math.pi, 1e-12, 9e-10, math.pi - 9e-10],
        [0.0, 1.0, -math.pi / 2, math.pi, 0.5],
    ),
)
def test_at_the_wrist_singularity_joint_6_is_that_of_the_near_configuration(
    joint5: float, turned: float
) -> None:
    q = np.array([0.3, 0.4, 1.2, 0.5, joint5, 2.0])
    near = q + turned * JOINT_6
    flange = FIVE.fkine(q)
    found = FIVE.ikine(flange, near)
    assert found[5] == pytest.approx(near[5], abs=1e-6)
    # Off the pose by what joint 5 was off the singularity, and not at all if joint 6 fits.
    error = np.abs(residual(FIVE.geometry, found, flange)).max()
    assert error < (1e-12 if turned == 0.0 else 1e-9)
    if turned == 0.0:
        np.testing.assert_allclose(found, q, atol=1e-9)


def test_beside_the_wrist_singularity_the_pose_says_where_joint_6_is() -> None:
    q = np.array([0.3, 0.4, 1.2, 0.5, -1e-8, 2.0])
    flange = FIVE.fkine(q)
    for turned in (0.0, 1.0):
        found = FIVE.ikine(flange, q + turned * JOINT_6)
        np.testing.assert_allclose(found, q, atol=1e-6)
        assert np.abs(residual(FIVE.geometry, found, flange)).max() < 1e-12


def test_at_the_wrist_singularity_joint_6_gives_way_where_the_arm_is_too_short_for_it() -> None:
    # Stretched towards joint 4, so that joints 2 to 4 cannot turn about joint 5's place freely.
    q = np.array([0.3, 0.9, 0.05, 0.1, 0.0, 0.4])
    flange = FIVE.fkine(q)
    near = q + 1.5 * JOINT_6
    found = FIVE.ikine(flange, near)
    assert np.abs(residual(FIVE.geometry, found, flange)).max() < 1e-9
    assert 0.1 < near[5] - found[5] < 1.5
    assert abs(found[2]) < 1e-3  # as far as the stretched arm allows


def test_all_solutions_of_a_wrist_singularity_take_joint_6_as_zero_and_come_in_pairs() -> None:
    flange = FIVE.fkine([0.3, 0.4, 1.2, 0.5, 0.0, 0.2])
    found = FIVE.ikine_all(flange)
    with_free_wrist = found[np.abs(np.sin(found[:, 4])) < 1e-9]
    assert len(with_free_wrist) == 4
    np.testing.assert_allclose(with_free_wrist[:, 5], 0.0, atol=1e-9)
    np.testing.assert_array_equal(with_free_wrist[0], with_free_wrist[1])
    assert np.abs(residual(FIVE.geometry, found, flange)).max() < 1e-12


@for_each("joint3", [0.0, 1e-9, -1e-7])
def test_a_stretched_arm_is_reached(joint3: float) -> None:
    q = np.array([0.3, 0.9, joint3, 0.5, 1.0, 2.0])
    flange = FIVE.fkine(q)
    found = FIVE.ikine(flange, q)
    assert np.abs(residual(FIVE.geometry, found, flange)).max() < 1e-9
    np.testing.assert_allclose(found, q, atol=1e-6)
    # The two elbows meet: both are given, and hardly differ.
    pairs = FIVE.ikine_all(flange)
    pairs = pairs[np.abs(pairs[:, 2]) < 1e-6]
    assert len(pairs) % 2 == 0
    assert len(pairs) >= 2


def test_a_pose_too_far_by_rounding_is_reached_by_the_stretched_arm() -> None:
    q = np.array([0.3, 0.9, 0.0, 0.5, 1.0, 2.0])
    flange, towards = FIVE.fkine(q), np.array([math.cos(0.3), math.sin(0.3), 0.0]) * math.sin(0.9)
    towards += [0.0, 0.0, math.cos(0.9)]
    near, far = flange.copy(), flange.copy()
    near[:3, 3] += 5e-11 * towards
    far[:3, 3] += 1e-8 * towards
    found = FIVE.ikine(near, q)
    assert np.abs(residual(FIVE.geometry, found, near)).max() < 1e-9
    assert found[2] == pytest.approx(0.0, abs=1e-6)
    # The wrist can no longer be reached by this elbow and wrist, whatever the other branches do.
    others = FIVE.ikine_all(far)
    assert not (np.abs(others[:, 2]) < 1e-3).any()


def test_at_the_shoulder_singularity_both_shoulders_are_the_same() -> None:
    geometry = FIVE.geometry
    # The wrist's centre over the cylinder of radius d2 about joint 1: nothing is ahead.
    q2, q3 = 0.4, 1.2
    ahead = geometry.a2 * math.sin(q2) + geometry.a3 * math.sin(q2 + q3)
    q4 = math.pi + math.asin(ahead / geometry.d5) - q2 - q3 if ahead < geometry.d5 else None
    if q4 is None:
        q3 = -2 * q2 - 0.3
        ahead = geometry.a2 * math.sin(q2) + geometry.a3 * math.sin(q2 + q3)
        q4 = math.asin(-ahead / geometry.d5) - q2 - q3
    q = np.array([0.3, q2, q3, q4, 1.0, 2.0])
    assert FIVE.singularity(q).shoulder < 1e-12
    flange = FIVE.fkine(q)
    found = FIVE.ikine(flange, q)
    assert np.abs(residual(geometry, found, flange)).max() < 1e-9
    np.testing.assert_allclose(found, q, atol=1e-5)
    assert np.abs(wrap(FIVE.ikine_all(flange)[:, 0] - 0.3)).max() < 1e-5


def test_turns_are_added_where_limits_allow() -> None:
    lower, upper = [-2 * math.pi] * 6, [2 * math.pi] * 6
    q = [0.5, -0.5, 3.0, 3.0, -3.0, 0.0]
    near = [6.0, -6.0, -3.0, 9.9, -9.9, 0.1]
    wrapped = nearest_turns(q, near, lower, upper)
    assert wrapped == pytest.approx([0.5, -0.5, 3.0 - 2 * math.pi, 3.0, -3.0, 0.0])
    # The nearest turn is outside of ±2π for the first two; for 5 rad it is not.
    assert nearest_turns([-1.0] * 6, [5.0] * 6, lower, upper) == pytest.approx(
        [2 * math.pi - 1.0] * 6
    )
    assert nearest_turns(q, near, [-1.0] * 6, [1.0] * 6) is None
    # At a limit, but for rounding: it stays there.
    assert nearest_turns([math.pi + 1e-12] * 6, near, [-math.pi] * 6, [math.pi] * 6) is not None
    beyond = nearest_turns([2 * math.pi + 1e-12] * 6, [9.0] * 6, lower, upper)
    assert beyond == upper


def test_out_of_reach_says_by_how_much() -> None:
    home = np.radians([0, 0, 90, 0, -90, 0])
    with pytest.raises(Unreachable, match=r"out of the reach of gcr5_910, by at least 1\.\d+ m"):
        FIVE.ikine(Pose(2.0, 0.0, 0.4, math.pi, 0, 0), home)
    # On the axis of joint 1 the offset of the arm's plane is in the way.
    with pytest.raises(Unreachable, match=r"by at least 0\.1405 m"):
        FIVE.ikine(Pose(0.0, 0.0, 0.5, math.pi, 0, 0), home)
    assert FIVE.ikine_all(Pose(2.0, 0.0, 0.4, 0, 0, 0)).shape == (0, 6)


@for_each("up", [-1.2, 0.0, 0.4, 1.3])
def test_a_wrist_beyond_the_stretched_arm_is_out_of_reach_by_the_way_to_it(up: float) -> None:
    g = FIVE.geometry
    reach = g.a2 + g.a3 + g.d5
    ahead, high = (reach + 0.1) * math.cos(up), (reach + 0.1) * math.sin(up)
    flange = np.eye(4)
    flange[:3, 3] = math.hypot(ahead, g.d2), 0.0, g.d1 + high + g.d6
    assert shortfall(g, flange) == pytest.approx(0.1, abs=1e-12)


@for_each("folded", [-2.6, 2.6])
def test_a_wrist_that_a_folded_arm_reaches_is_not_out_of_reach(folded: float) -> None:
    assert shortfall(FIVE.geometry, FIVE.fkine([0.3, -0.4, folded, 0.2, -1.0, 0.5])) == 0.0


def calibrated(size: float) -> list[Arm]:
    """Arms whose lengths and angles are off by some `size` [m, rad]."""
    random = np.random.default_rng(5)
    sets = [random.normal(0.0, size, (4, 6)).tolist() for _ in range(8)]
    known = [DhCorrections(*map(tuple, columns)) for columns in sets]
    lengths = [FIVE.geometry._replace(corrections=each) for each in known]
    return [dataclasses.replace(FIVE, geometry=each) for each in lengths]


@for_each("joint3", [-0.1, 0.06, 1.2])
def test_a_stretched_calibrated_arm_is_reached_where_its_lengths_alone_are_too_short(
    joint3: float,
) -> None:
    for known in calibrated(1e-3):
        q = np.array([0.4, 0.3, joint3, 0.5, 0.8, 0.9])
        np.testing.assert_allclose(known.ikine(known.fkine(q), q), q, atol=1e-9)


@for_each("joint3, joint5", [(1.2, 0.0), (1.2, 1e-7), (0.0, 0.7), (0.0, 0.0)])
def test_a_calibrated_arm_at_a_singularity_stays_where_it_is(joint3: float, joint5: float) -> None:
    """Steps led to another configuration, radians away, or to none: out of reach, it said."""
    for known in calibrated(5e-4):
        q = np.array([0.4, 0.3, joint3, 0.5, joint5, 0.9])
        np.testing.assert_allclose(known.ikine(known.fkine(q), q), q, atol=1e-6)


def test_a_solution_that_is_a_little_off_is_improved_alone_and_with_others() -> None:
    q = np.array([[0.3, -0.4, 1.2, 0.2, -1.0, 0.5], [1.0, 0.2, -1.5, -0.3, 0.8, -2.0]])
    flanges = np.stack([FIVE.fkine(each) for each in q])
    near = q + 1e-3 * np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0])
    assert refine(FIVE.geometry, near, flanges) == pytest.approx(q, abs=1e-9)
    assert refine(FIVE.geometry, near[0], flanges[0]) == pytest.approx(q[0], abs=1e-9)


def test_how_far_out_of_reach_is_never_exaggerated() -> None:
    rng = np.random.default_rng(3)
    home = np.zeros(6)
    for _ in range(200):
        flange = Pose(*rng.uniform(-1.5, 1.5, 3), *rng.uniform(-3, 3, 3))
        try:
            FIVE.ikine(flange, home)
        except Unreachable as exc:
            text = str(exc)
        else:
            continue
        if "at least" not in text:
            continue
        missing = float(text.split("at least ")[1].split(" m", maxsplit=1)[0])
        # Poses that are nearer by less than what is missing are out of reach, too.
        for direction in np.eye(3):
            for sign in (-1, 1):
                nearer = flange.shifted(*(0.99 * (missing - 5e-5) * sign * direction))
                assert len(FIVE.ikine_all(nearer)) == 0


def test_joint_limits_and_jumps_are_refused() -> None:
    q = np.array([0.3, 0.4, 1.2, 0.5, -1.1, 2.0])
    flange = FIVE.fkine(q)
    stiff = dataclasses.replace(FIVE, lower=(-0.01,) * 6, upper=(0.01,) * 6)
    with pytest.raises(Unreachable, match="only outside its joint limits"):
        stiff.ikine(flange, q)
    assert not stiff.within_limits(q)
    with pytest.raises(Unreachable, match=r"turns joint 4 by 0\.5\d+ rad, more than 0\.2"):
        FIVE.ikine(flange, q + np.array([0, 0, 0, 0.55, 0, 0]), max_jump=0.2)


def test_a_configuration_within_the_jump_is_found_beside_a_nearer_one_that_is_not() -> None:
    """Near a stretched arm two configurations are close to each other."""
    q = np.array([0.2216, -0.2343, 0.0346, 0.9715, 1.2, 0.6860])
    near = np.array([0.3717, -0.0576, -0.0606, 0.7764, 1.1932, 0.5591])
    flange = FIVE.fkine(q)
    assert np.abs(FIVE.ikine(flange, near) - near).max() > 0.22
    assert np.abs(FIVE.ikine(flange, near, max_jump=0.2) - near).max() < 0.2


def test_poses_of_any_kind_are_taken() -> None:
    q = np.array([0.3, 0.4, 1.2, 0.5, -1.1, 2.0])
    pose = Pose.from_matrix(FIVE.fkine(q))
    for given_as in (pose, list(pose), pose.array, pose.matrix):
        np.testing.assert_allclose(FIVE.ikine(given_as, q), q, atol=1e-9)
    with pytest.raises(ParameterError):
        FIVE.ikine([0.1, 0.2], q)


@for_each("near", [[0.0] * 5, [[0.0] * 6] * 2, [0.0] * 5 + [math.nan]])
def test_what_is_no_configuration_is_refused(near: Any) -> None:
    with pytest.raises(ParameterError, match=r"q_near|\[rad\]"):
        FIVE.ikine(FIVE.fkine([0.3, 0.4, 1.2, 0.5, -1.1, 2.0]), near)


@for_each("place, value", product(product(range(3), range(4)), (math.nan, math.inf, -math.inf)))
def test_a_matrix_that_is_not_finite_is_refused(place: tuple[int, int], value: float) -> None:
    flange = FIVE.fkine([0.3, 0.4, 1.2, 0.5, 0.0, 2.0])
    flange[place] = value
    for solve in (FIVE.ikine_all, lambda pose: FIVE.ikine(pose, np.zeros(6))):
        with pytest.raises(ParameterError, match="flange"):
            solve(flange)


def test_a_matrix_that_lost_digits_is_reached_as_well_as_it_can_be() -> None:
    q = np.array([0.3, 0.4, 1.2, 0.5, -1.1, 2.0])
    flange = FIVE.fkine(q).round(7)
    found = FIVE.ikine(flange, q)
    assert np.abs(residual(FIVE.geometry, found, flange)).max() < 1e-9
    np.testing.assert_allclose(found, q, atol=1e-6)
