"""Displacements of joints and poses, against scipy's rotations."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from aioduco.streaming.shared.space import JOINT_SPACE, POSE_SPACE, too_far

ANGLE = st.floats(-2 * math.pi, 2 * math.pi)
NEAR_VERTICAL = st.sampled_from([math.pi / 2, -math.pi / 2]).flatmap(
    lambda right: st.sampled_from([0.0, 1e-12, 1e-8, 1e-4]).map(lambda off: right + off)
)
POSE = st.tuples(*[st.floats(-2, 2)] * 3, ANGLE, st.one_of(ANGLE, NEAR_VERTICAL), ANGLE)
JOINTS = st.tuples(*[ANGLE] * 6)


def rotation(pose: tuple[float, ...]) -> scipy.spatial.transform.Rotation:
    rx, ry, rz = pose[3:]
    return scipy.spatial.transform.Rotation.from_euler("ZYX", [rz, ry, rx])


def angle(turn: scipy.spatial.transform.Rotation) -> float:
    return float(np.asarray(turn.magnitude()))


@pytest.mark.slow
@given(POSE)
def test_a_pose_survives_there_and_back(pose: tuple[float, ...]) -> None:
    back = POSE_SPACE.encode(POSE_SPACE.decode(pose))
    assert back[:3] == pose[:3]
    assert angle(rotation(pose).inv() * rotation(back)) < 1e-6


@given(POSE, POSE)
def test_a_displacement_leads_to_its_end(start: tuple[float, ...], end: tuple[float, ...]) -> None:
    a, b = POSE_SPACE.decode(start), POSE_SPACE.decode(end)
    displacement = POSE_SPACE.difference(a, b)
    reached = POSE_SPACE.encode(POSE_SPACE.moved(a, displacement))
    np.testing.assert_allclose(reached[:3], end[:3], atol=1e-12)
    assert angle(rotation(end).inv() * rotation(reached)) < 1e-6


@given(POSE, POSE)
def test_the_turn_is_the_shorter_one_in_the_base_frame(
    start: tuple[float, ...], end: tuple[float, ...]
) -> None:
    displacement = POSE_SPACE.difference(POSE_SPACE.decode(start), POSE_SPACE.decode(end))
    turn = rotation(end) * rotation(start).inv()
    length = math.hypot(*displacement[3:])
    assert length <= math.pi + 1e-9
    assert abs(length - angle(turn)) < 1e-6
    if angle(turn) < math.pi - 1e-3:
        np.testing.assert_allclose(displacement[3:], turn.as_rotvec(), atol=1e-6)


@given(JOINTS, JOINTS)
def test_joints_are_differences_of_angles(start: tuple[float, ...], end: tuple[float, ...]) -> None:
    displacement = JOINT_SPACE.difference(start, end)
    np.testing.assert_allclose(displacement, np.subtract(end, start))
    np.testing.assert_allclose(JOINT_SPACE.moved(start, displacement), end, atol=1e-12)


def test_what_is_too_far_is_named_with_its_distance() -> None:
    far = [0.0, 0.0, 0.3, 0.2, 0.0, 0.0]
    found = too_far(JOINT_SPACE, (0.0,) * 6, tuple(far), (0.1,) * 6)
    assert found == "joint 3: 0.3 rad away, where 0.1 rad are allowed"
    assert too_far(JOINT_SPACE, (0.0,) * 6, tuple(far), (0.3,) * 6) == ""
    here, there = POSE_SPACE.decode((0.0,) * 6), POSE_SPACE.decode((0.3, 0.4, 0, 0, 0, 1.0))
    assert too_far(POSE_SPACE, here, there, (0.1, 2.0)).startswith("position: 0.5 m away")
    assert too_far(POSE_SPACE, here, there, (1.0, 0.5)).startswith("orientation: 1 rad away")
    assert too_far(JOINT_SPACE, (0.0,) * 6, (math.nan,) * 6, (0.1,) * 6)
