"""Curves of the tool centre point against their closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.models.pose import Pose
from aioduco.models.rotation import Array, matrix_from_rotvec, rotvec_from_matrix
from aioduco.sim.planner.curves import StraightLine, arc_through
from aioduco.sim.planner.path import PlanError

LENGTH = st.floats(-1.0, 1.0)
ANGLE = st.floats(-3.0, 3.0)
POSES = st.builds(Pose, LENGTH, LENGTH, LENGTH, ANGLE, ANGLE, ANGLE)


def along(length: float, count: int = 41) -> Array:
    return np.linspace(0.0, length, count)


def turned(a: Array, b: Array) -> Array:
    """Angles between orientations [rad]."""
    angles: Array = np.linalg.norm(rotvec_from_matrix(np.swapaxes(a, -1, -2) @ b), axis=-1)
    return angles


def on_circle(angle: float) -> Array:
    """A pose on a circle of 0.2 m about (0.5, 0.1, 0.3), in the plane of x and z."""
    x, z = 0.5 + 0.2 * math.cos(angle), 0.3 + 0.2 * math.sin(angle)
    return Pose(x, 0.1, z, 0.3, -0.2, 0.1).matrix


def test_a_line_between_two_orientations_of_one_point_is_as_long_as_its_angle() -> None:
    a = Pose(0.4, 0.1, 0.3, 0.0, 0.0, 0.0)
    line = StraightLine.between(a.matrix, (a @ Pose(0, 0, 0, 0, 0, 1.2)).matrix)
    assert line.length == pytest.approx(1.2)
    assert line.turning == pytest.approx(1.2)
    np.testing.assert_allclose(line.poses(along(1.2))[:, :3, 3], [a.position] * 41)
    np.testing.assert_allclose(turned(line.poses(along(1.2))[:, :3, :3], a.rotation), along(1.2))


@given(st.floats(0.05, 6.1), st.floats(0.05, 0.95), POSES)
def test_an_arc_runs_on_its_circle_through_its_points(end: float, part: float, at: Pose) -> None:
    via, target = at.matrix @ on_circle(part * end), at.matrix @ on_circle(end)
    arc = arc_through(at.matrix @ on_circle(0.0), via, target, 1)
    assert arc.length == pytest.approx(0.2 * end, rel=1e-6)
    s = along(arc.length, 201)
    points = arc.poses(s)[:, :3, 3]
    centre = (at @ Pose(0.5, 0.1, 0.3, 0, 0, 0)).position
    np.testing.assert_allclose(np.linalg.norm(points - centre, axis=1), 0.2, atol=1e-7)
    expected = np.array([(at.matrix @ on_circle(angle))[:3, 3] for angle in s / 0.2])
    np.testing.assert_allclose(points, expected, atol=1e-7)
    passed = arc.poses(np.array([part * arc.length]))[0, :3, 3]
    np.testing.assert_allclose(passed, via[:3, 3], atol=1e-7)


def test_mode_0_turns_to_the_orientation_of_the_target() -> None:
    start, via, target = on_circle(0.0), on_circle(1.0), on_circle(2.0)
    turn = np.array([0.1, 0.5, -0.3])
    target[:3, :3] = matrix_from_rotvec(turn) @ start[:3, :3]
    via[:3, :3] = np.eye(3)  # plays no part
    arc = arc_through(start, via, target, 0)
    s = along(arc.length)
    rotations = arc.poses(s)[:, :3, :3]
    np.testing.assert_allclose(rotations[-1], target[:3, :3], atol=1e-12)
    expected = s / arc.length * np.linalg.norm(turn)
    np.testing.assert_allclose(turned(start[:3, :3], rotations), expected, atol=1e-9)
    assert arc.turning == pytest.approx(np.linalg.norm(turn))


def test_mode_1_keeps_the_orientation_of_the_start() -> None:
    start, target = on_circle(0.0), on_circle(2.0)
    target[:3, :3] = np.eye(3)
    arc = arc_through(start, on_circle(1.0), target, 1)
    for pose in arc.poses(along(arc.length)):
        np.testing.assert_allclose(pose[:3, :3], start[:3, :3], atol=1e-12)


def test_mode_2_keeps_the_orientation_to_the_tangent() -> None:
    arc = arc_through(on_circle(0.0), on_circle(1.0), on_circle(3.5), 2)
    s = along(arc.length, 400)
    poses = arc.poses(s)
    tangent = np.gradient(poses[:, :3, 3], s, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    seen_from_tool = np.einsum("nji,nj->ni", poses[:, :3, :3], tangent)[1:-1]
    np.testing.assert_allclose(seen_from_tool, [seen_from_tool[0]] * 398, atol=1e-9)
    assert arc.turning == pytest.approx(3.5)


@for_each("mode", [1, 2])
def test_a_full_circle_comes_back_the_way_it_set_out(mode: int) -> None:
    start = on_circle(0.0)
    arc = arc_through(start, on_circle(1.0), on_circle(1.5), mode, full=True)
    assert arc.length == pytest.approx(0.2 * 2 * math.pi)
    np.testing.assert_allclose(arc.poses(np.array([arc.length]))[0], start, atol=1e-9)
    np.testing.assert_allclose(
        arc.poses(np.array([0.2]))[0, :3, 3], on_circle(1.0)[:3, 3], atol=1e-9
    )
    other_way = arc_through(start, on_circle(1.5), on_circle(1.0), mode, full=True)
    np.testing.assert_allclose(
        other_way.poses(np.array([0.2]))[0, :3, 3], on_circle(-1.0)[:3, 3], atol=1e-9
    )


def test_points_on_one_line_make_no_arc() -> None:
    a = Pose(0.1, 0.2, 0.3, 0, 0, 0)
    for first, second in ((0.1, 0.2), (0.1, 0.1), (0.0, 0.1), (0.1, 0.0), (0.2, 0.1)):
        with pytest.raises(PlanError, match="on one line") as caught:
            arc_through(a.matrix, a.shifted(x=first).matrix, a.shifted(x=second).matrix, 1)
        assert caught.value.code == "parameter"
    with pytest.raises(PlanError, match="mode 3"):
        arc_through(on_circle(0), on_circle(1), on_circle(2), 3)
