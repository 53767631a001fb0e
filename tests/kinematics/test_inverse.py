"""Inverse kinematics: every solution found, to machine precision, by both implementations."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING

import numpy as np
import pytest
from eaik.IK_DH import DhRobot
from hypothesis import given, settings
from hypothesis import strategies as st

from aioduco.errors import ParameterError, Unreachable
from aioduco.kinematics import Arm, arm, eaik, models
from aioduco.kinematics.inverse import BRANCHES, closed_form, residual, wrap, wrap_near
from aioduco.models.pose import Pose

if TYPE_CHECKING:
    from aioduco.models.rotation import Array

FULL_TURNS = st.lists(st.floats(-2 * math.pi, 2 * math.pi), min_size=6, max_size=6).map(np.array)
MODELS = st.sampled_from(models())
FIVE = arm("gcr5_910")


def spread(q: Array, near: Array) -> float:
    """Largest angle between two configurations, whole turns not counted."""
    return float(np.abs(wrap(q - near)).max())


@given(MODELS, FULL_TURNS)
@settings(max_examples=300)
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


@given(MODELS, FULL_TURNS)
@settings(max_examples=300)
def test_nearest_solution_is_where_it_came_from(model: str, q: Array) -> None:
    any_arm = arm(model)
    if min(any_arm.singularity(q)) < 1e-3:
        return
    found = any_arm.ikine(any_arm.fkine(q), q, max_jump=1e-6)
    np.testing.assert_allclose(found, q, rtol=0, atol=1e-9)


@given(MODELS, FULL_TURNS, FULL_TURNS)
@settings(max_examples=200)
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


@given(MODELS, FULL_TURNS)
@settings(max_examples=300)
def test_closed_form_finds_what_eaik_finds(model: str, q: Array) -> None:
    g = arm(model).geometry
    if min(arm(model).singularity(q)) < 1e-3:
        return
    robot = DhRobot(np.array(g.alpha), np.array(g.a), np.array(g.d))
    flange = arm(model).fkine(q)
    answer = robot.IK(flange)
    theirs = np.asarray(answer.Q)[~np.asarray(answer.is_LS)] - np.array(g.theta)
    ours = closed_form(g, flange)
    ours = ours[~np.isnan(ours).any(axis=1)]
    if np.abs(np.sin(ours[:, [2, 4]])).min() < 1e-3:
        return  # another solution is singular, where EAIK counts twice or not at all
    assert len(ours) == len(theirs)
    for each in ours:
        assert min(spread(each, other) for other in theirs) < 1e-9


@given(MODELS, FULL_TURNS)
@settings(max_examples=200)
def test_eaik_is_given_in_the_same_order(model: str, q: Array) -> None:
    any_arm = arm(model)
    flange = any_arm.fkine(q)
    theirs = eaik.solutions(any_arm.geometry, flange)
    if theirs is None:
        return
    ours = closed_form(any_arm.geometry, flange)
    ours = ours[~np.isnan(ours).any(axis=1)]
    assert theirs.shape == ours.shape
    assert np.abs(wrap(theirs - ours)).max() < 1e-9


def test_without_eaik_the_answer_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    q = np.array([0.3, -0.4, 1.2, 0.5, -1.1, 2.0])
    flange = FIVE.fkine(q)
    assert eaik.installed(FIVE.geometry)
    with_eaik = FIVE.ikine_all(flange)
    monkeypatch.setitem(sys.modules, "eaik.IK_DH", None)
    eaik._robot.cache_clear()
    try:
        assert not eaik.installed(FIVE.geometry)
        np.testing.assert_allclose(FIVE.ikine_all(flange), with_eaik, rtol=0, atol=1e-9)
    finally:
        eaik._robot.cache_clear()


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


@pytest.mark.parametrize("joint5", [0.0, math.pi, 1e-12, -1e-8])
def test_at_the_wrist_singularity_joint_6_stays(joint5: float) -> None:
    q = np.array([0.3, 0.4, 1.2, 0.5, joint5, 2.0])
    flange = FIVE.fkine(q)
    found = FIVE.ikine(flange, q)
    assert np.abs(residual(FIVE.geometry, found, flange)).max() < 1e-9
    if abs(math.sin(joint5)) < 1e-9:
        np.testing.assert_allclose(found, q, atol=1e-6)


def test_a_stretched_arm_is_reached() -> None:
    q = np.array([0.3, 0.9, 0.0, 0.5, 1.0, 2.0])
    flange = FIVE.fkine(q)
    found = FIVE.ikine(flange, q)
    assert np.abs(residual(FIVE.geometry, found, flange)).max() < 1e-9
    np.testing.assert_allclose(found, q, atol=1e-6)


def test_turns_are_added_where_limits_allow() -> None:
    lower, upper = np.full(6, -2 * math.pi), np.full(6, 2 * math.pi)
    q = np.array([0.5, -0.5, 3.0, 3.0, -3.0, 0.0])
    near = np.array([6.0, -6.0, -3.0, 9.9, -9.9, 0.1])
    wrapped = wrap_near(q, near, lower, upper)
    expected = [0.5, -0.5, 3.0 - 2 * math.pi, 3.0, -3.0, 0.0]
    np.testing.assert_allclose(wrapped, expected)
    # The nearest turn is outside of ±2π for the first two; for 5 rad it is not.
    assert wrap_near(np.array([-1.0] * 6), np.full(6, 5.0), lower, upper)[0] == pytest.approx(
        2 * math.pi - 1.0
    )
    narrow = wrap_near(q, near, np.full(6, -1.0), np.full(6, 1.0))
    assert np.isnan(narrow).tolist() == [False, False, True, True, True, False]


def test_out_of_reach_says_by_how_much() -> None:
    home = np.radians([0, 0, 90, 0, -90, 0])
    with pytest.raises(Unreachable, match=r"out of the reach of gcr5_910, by at least 1\.\d+ m"):
        FIVE.ikine(Pose(2.0, 0.0, 0.4, math.pi, 0, 0), home)
    # On the axis of joint 1 the offset of the arm's plane is in the way.
    with pytest.raises(Unreachable, match=r"by at least 0\.1445 m"):
        FIVE.ikine(Pose(0.0, 0.0, 0.5, math.pi, 0, 0), home)
    assert FIVE.ikine_all(Pose(2.0, 0.0, 0.4, 0, 0, 0)).shape == (0, 6)


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
    import dataclasses  # noqa: PLC0415  # only here

    stiff = dataclasses.replace(FIVE, lower=(-0.01,) * 6, upper=(0.01,) * 6)
    with pytest.raises(Unreachable, match="only outside its joint limits"):
        stiff.ikine(flange, q)
    assert not stiff.within_limits(q)
    with pytest.raises(Unreachable, match=r"turns joint 4 by 0\.5\d+ rad, more than 0\.2"):
        FIVE.ikine(flange, q + np.array([0, 0, 0, 0.55, 0, 0]), max_jump=0.2)


def test_poses_of_any_kind_are_taken() -> None:
    q = np.array([0.3, 0.4, 1.2, 0.5, -1.1, 2.0])
    pose = Pose.from_matrix(FIVE.fkine(q))
    for given_as in (pose, list(pose), pose.array, pose.matrix):
        np.testing.assert_allclose(FIVE.ikine(given_as, q), q, atol=1e-9)
    with pytest.raises(ParameterError):
        FIVE.ikine([0.1, 0.2], q)


@pytest.mark.parametrize("model", models())
def test_a_grid_of_the_workspace_round_trips(model: str) -> None:
    any_arm: Arm = arm(model)
    g = any_arm.geometry
    steps = np.linspace(0.3, 2.8, 3)
    grid = np.stack(np.meshgrid(*[steps] * 6, indexing="ij"), axis=-1).reshape(-1, 6)
    flange = any_arm.fkine(grid)
    found = closed_form(g, flange)
    kept = ~np.isnan(found).any(axis=-1)
    error = np.abs(residual(g, found, flange[:, None]))[kept]
    assert error.max() < 1e-12
    off = np.abs(wrap(found - grid[:, None])).max(axis=-1)
    assert np.nanmin(off, axis=1).max() < 1e-9
