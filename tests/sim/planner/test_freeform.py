"""Spirals against their formula, splines against SciPy's."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy

from aioduco.models.pose import Pose
from aioduco.models.rotation import Array, rotvec_from_matrix
from aioduco.sim.planner.curves import Curve, spiral, spline
from aioduco.sim.planner.path import PlanError

CENTRE = Pose(0.3, 0.2, 0.4, 0.4, -0.3, 0.7).matrix
START = CENTRE @ Pose(0.0, -0.1, 0.05, 1.0, 0.2, 0.3).matrix


def sampled(curve: Curve, count: int = 500) -> Array:
    return curve.poses(np.linspace(0.0, curve.length, count))


def evenly(points: Array) -> None:
    """Points follow each other at one distance, but for the chord of a bend."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert np.ptp(step) < 1e-3 * step.mean()


def test_a_spiral_winds_about_its_axis() -> None:
    curve = spiral(START, CENTRE, 2.25, 0.3, 0.04)
    poses = sampled(curve, 2000)
    inside = np.linalg.inv(CENTRE) @ poses
    radius = np.hypot(inside[:, 0, 3], inside[:, 1, 3])
    azimuth = np.unwrap(np.arctan2(inside[:, 1, 3], inside[:, 0, 3]))
    assert azimuth[0] == pytest.approx(-math.pi / 2)
    assert azimuth[-1] - azimuth[0] == pytest.approx(2.25 * 2 * math.pi)
    part = (azimuth - azimuth[0]) / (azimuth[-1] - azimuth[0])
    np.testing.assert_allclose(radius, 0.1 + (0.04 - 0.1) * part, atol=1e-9)
    np.testing.assert_allclose(inside[:, 2, 3], 0.05 + 0.3 * part, atol=1e-9)
    turned = np.linalg.norm(rotvec_from_matrix(START[:3, :3].T @ poses[:, :3, :3]), axis=1)
    assert turned.max() < 1e-7
    evenly(poses[:, :3, 3])


def test_a_spiral_of_one_radius_and_height_is_a_circle() -> None:
    curve = spiral(START, CENTRE, -1.0, 0.0, 0.1)
    assert curve.length == pytest.approx(2 * math.pi * 0.1, rel=1e-6)
    np.testing.assert_allclose(sampled(curve)[-1], START, atol=1e-9)
    quarter = np.linalg.inv(CENTRE) @ curve.poses(np.array([0.25 * curve.length]))[0]
    np.testing.assert_allclose(quarter[:3, 3], [-0.1, 0.0, 0.05], atol=1e-6)


def test_a_spiral_may_end_at_a_pose() -> None:
    end = CENTRE @ Pose(0.03, 0.04, 0.2, 0.5, 0.1, 0.0).matrix
    curve = spiral(START, CENTRE, 3.0, 9.0, 9.0, end)
    poses = sampled(curve, 2000)
    np.testing.assert_allclose(poses[-1], end, atol=1e-9)
    inside = np.linalg.inv(CENTRE) @ poses
    azimuth = np.unwrap(np.arctan2(inside[:, 1, 3], inside[:, 0, 3]))
    assert abs(azimuth[-1] - azimuth[0] - 3.0 * 2 * math.pi) <= math.pi


@pytest.mark.parametrize(
    ("start", "turns", "radius"), [(CENTRE, 1.0, 0.1), (START, 0.0, 0.1), (START, 1.0, -0.1)]
)
def test_spirals_that_go_nowhere_are_refused(start: Array, turns: float, radius: float) -> None:
    with pytest.raises(PlanError) as caught:
        spiral(start, CENTRE, turns, 0.0, radius)
    assert caught.value.code == "parameter"


@pytest.mark.slow
def test_a_spline_is_the_natural_one_through_its_poses() -> None:
    poses = [
        START,
        *[
            (Pose.from_matrix(START) @ Pose(*way)).matrix
            for way in (
                (0.1, 0.0, 0.05, 0.2, 0, 0),
                (0.2, 0.15, 0.0, 0.2, 0.5, 0),
                (0.1, 0.3, -0.1, -0.3, 0.2, 0.4),
            )
        ],
    ]
    curve = spline(poses[0], poses[1:])
    found = sampled(curve, 4000)
    points = np.array([pose[:3, 3] for pose in poses])
    knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    expected = scipy.interpolate.CubicSpline(knots, points, bc_type="natural")(
        np.linspace(0, knots[-1], 4000)
    )
    nearest = np.linalg.norm(found[::40, None, :3, 3] - expected[None], axis=2).min(axis=1)
    assert nearest.max() < 2e-4
    evenly(found[:, :3, 3])
    for pose in poses:
        i = int(np.linalg.norm(found[:, :3, 3] - pose[:3, 3], axis=1).argmin())
        assert np.linalg.norm(found[i, :3, 3] - pose[:3, 3]) < 2e-4
        assert np.linalg.norm(rotvec_from_matrix(found[i, :3, :3].T @ pose[:3, :3])) < 2e-3
    np.testing.assert_allclose(found[[0, -1]], [poses[0], poses[-1]], atol=1e-9)


def test_a_spline_through_one_pose_is_a_straight_line() -> None:
    end = (Pose.from_matrix(START) @ Pose(0.1, 0.2, 0.2, 0, 0, 0)).matrix
    curve = spline(START, [end])
    assert curve.length == pytest.approx(0.3)
    points = sampled(curve, 20)[:, :3, 3]
    np.testing.assert_allclose(points, np.linspace(START[:3, 3], end[:3, 3], 20), atol=1e-9)


def test_splines_that_stand_still_are_refused() -> None:
    for targets in ([], [START], [CENTRE, CENTRE]):
        with pytest.raises(PlanError, match="apart from each other"):
            spline(START, targets)
