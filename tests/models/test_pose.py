"""Poses and joint vectors, against SciPy's rotations."""

from __future__ import annotations

import inspect
import math
import pickle
from typing import Any

import numpy as np
import pytest
import scipy
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.errors import ParameterError
from aioduco.models.pose import Joints, Pose
from aioduco.models.rotation import (
    Array,
    matrix_from_rotvec,
    matrix_from_rpy,
    quaternion_from_matrix,
    rotvec_from_matrix,
    rpy_from_matrix,
    slerp,
)
from aioduco.models.units import deg, mm

ANGLE = st.floats(-2 * math.pi, 2 * math.pi)
LENGTH = st.floats(-3.0, 3.0)
POSES = st.builds(Pose, LENGTH, LENGTH, LENGTH, ANGLE, ANGLE, ANGLE)
# Close to the singularity of roll-pitch-yaw, where a naive conversion loses digits.
GIMBAL = st.builds(
    lambda rx, off, sign, rz: np.array([rx, sign * (math.pi / 2 - off), rz]),
    ANGLE,
    st.sampled_from([0.0, 1e-16, 1e-13, 1e-12, 1e-10, 1e-8, 1e-6, 1e-3]),
    st.sampled_from([-1, 1]),
    ANGLE,
)


def scipy_rotation(pose: Pose) -> Any:
    # Capitals turn about moving axes: z, then the new y, then the new x.
    return scipy.spatial.transform.Rotation.from_euler("ZYX", [pose.rz, pose.ry, pose.rx])


@pytest.mark.slow
@given(POSES)
def test_rotation_is_that_of_scipy(pose: Pose) -> None:
    expected = scipy_rotation(pose)
    np.testing.assert_allclose(pose.rotation, expected.as_matrix(), rtol=0, atol=1e-12)
    xyzw = expected.as_quat(canonical=True)
    ours = pose.quaternion("xyzw")
    # Half a turn has two quaternions, and rounding decides which is canonical.
    if abs(xyzw[3]) < 1e-12 and ours @ xyzw < 0:
        xyzw = -xyzw
    np.testing.assert_allclose(ours, xyzw, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(np.roll(pose.quaternion("wxyz"), -1), ours)
    np.testing.assert_allclose(
        scipy.spatial.transform.Rotation.from_rotvec(pose.rotvec).as_matrix(),
        expected.as_matrix(),
        rtol=0,
        atol=1e-12,
    )


@given(POSES)
def test_every_representation_gives_the_pose_back(pose: Pose) -> None:
    limits = {"position": 1e-12, "rotation": 1e-12}
    assert Pose.of(pose.array).almost_equal(pose, position=0.0, rotation=1e-12)
    assert Pose.of(list(pose)) == pose
    assert Pose.from_matrix(pose.matrix).almost_equal(pose, **limits)
    assert Pose.from_rotvec(pose.position, pose.rotvec).almost_equal(pose, **limits)
    for order in ("wxyz", "xyzw"):
        quaternion = 3.0 * pose.quaternion(order)  # any length
        assert Pose.from_quaternion(pose.position, quaternion, order).almost_equal(pose, **limits)


@given(GIMBAL)
def test_roll_pitch_yaw_keep_their_digits_at_the_singularity(rpy: Array) -> None:
    matrix = matrix_from_rpy(rpy)
    np.testing.assert_allclose(matrix_from_rpy(rpy_from_matrix(matrix)), matrix, rtol=0, atol=1e-12)


def test_at_the_singularity_rz_is_zero() -> None:
    for ry in (math.pi / 2, -math.pi / 2):
        rpy = rpy_from_matrix(matrix_from_rpy(np.array([0.3, ry, 0.2])))
        assert rpy[2] == 0.0
        assert rpy[1] == pytest.approx(ry)
        assert rpy[0] == pytest.approx(0.3 - math.copysign(0.2, ry))


@given(POSES, POSES)
def test_composition_is_that_of_matrices(a: Pose, b: Pose) -> None:
    np.testing.assert_allclose((a @ b).matrix, a.matrix @ b.matrix, rtol=0, atol=1e-12)
    np.testing.assert_allclose(a.inverse().matrix, np.linalg.inv(a.matrix), rtol=0, atol=1e-12)
    identity = Pose(0, 0, 0, 0, 0, 0)
    assert (a @ a.inverse()).almost_equal(identity, position=1e-12, rotation=1e-12)


@pytest.mark.slow
@given(POSES, POSES, st.floats(0.0, 1.0))
def test_interpolation_goes_straight_and_turns_at_a_constant_rate(
    a: Pose, b: Pose, t: float
) -> None:
    between = a.interpolate(b, t)
    np.testing.assert_allclose(
        between.position, a.position + t * (b.position - a.position), atol=1e-12
    )
    turn = (scipy_rotation(a).inv() * scipy_rotation(b)).magnitude()
    assert a.distance(between)[1] == pytest.approx(t * turn, abs=1e-7)
    assert between.distance(b)[1] == pytest.approx((1 - t) * turn, abs=1e-7)


def test_interpolation_ends_at_its_ends() -> None:
    a, b = Pose(0, 0, 0, 0.1, 0.2, 0.3), Pose(1, 2, 3, -1, 0.5, 2)
    assert a.interpolate(b, 0.0).almost_equal(a, position=0.0, rotation=1e-12)
    assert a.interpolate(b, 1.0).almost_equal(b, position=0.0, rotation=1e-12)
    with pytest.raises(ParameterError, match=r"t is 1\.1"):
        a.interpolate(b, 1.1)


@pytest.mark.slow
@given(st.integers(0, 40), st.integers(0, 2**32 - 1))
def test_arrays_of_rotations_convert_as_each_alone(count: int, seed: int) -> None:
    rotvec = np.random.default_rng(seed).uniform(-4, 4, (count, 3))
    matrices = matrix_from_rotvec(rotvec)
    assert matrices.shape == (count, 3, 3)
    expected = scipy.spatial.transform.Rotation.from_rotvec(rotvec)
    np.testing.assert_allclose(matrices, expected.as_matrix().reshape(-1, 3, 3), atol=1e-12)
    for convert in (rpy_from_matrix, quaternion_from_matrix, rotvec_from_matrix):
        for one, matrix in zip(convert(matrices), matrices, strict=True):
            np.testing.assert_allclose(one, convert(matrix), atol=1e-12)


def test_slerp_of_half_a_turn_keeps_its_rate() -> None:
    end = matrix_from_rpy(np.array([math.pi, 0.0, 0.0]))
    path = slerp(np.eye(3), end, np.linspace(0, 1, 11))
    angles = np.linalg.norm(rotvec_from_matrix(path), axis=1)
    np.testing.assert_allclose(angles, np.linspace(0, math.pi, 11), atol=1e-12)


@given(POSES, POSES)
def test_distance_is_that_of_scipy(a: Pose, b: Pose) -> None:
    turn = (scipy_rotation(a).inv() * scipy_rotation(b)).magnitude()
    assert a.distance(b) == pytest.approx((math.dist(a[:3], b[:3]), turn), abs=1e-9)
    assert a.distance(a) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_almost_equal_compares_orientations_and_not_angles() -> None:
    a, b = Pose(0, 0, 0, math.pi, 0, 0), Pose(0, 0, 0, -math.pi, 0, 0)
    assert a != b
    assert a.almost_equal(b)
    assert not a.almost_equal(Pose(0, 0, 2e-6, math.pi, 0, 0))
    assert not a.almost_equal(Pose(0, 0, 0, math.pi - 2e-6, 0, 0))


def test_a_pose_is_a_frozen_sequence_of_six_floats() -> None:
    pose = Pose(1, np.float32(2), 3, 4, 5, 6)  # type: ignore[arg-type]  # numpy scalars are taken
    assert list(pose) == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert all(type(value) is float for value in pose)
    assert (len(pose), pose[0], pose[-1], pose[:3]) == (6, 1.0, 6.0, (1.0, 2.0, 3.0))
    x, y, z, *angles = pose
    assert (x, y, z, angles) == (1.0, 2.0, 3.0, [4.0, 5.0, 6.0])
    assert np.asarray(pose).tolist() == pose.array.tolist() == list(pose)
    assert np.asarray(pose, dtype=np.float32).dtype == np.float32
    assert Pose.of(pose) is pose
    assert pickle.loads(pickle.dumps(pose)) == pose
    assert len({pose, Pose(1, 2, 3, 4, 5, 6)}) == 1
    with pytest.raises(AttributeError):
        pose.x = 2.0  # type: ignore[misc]  # that it is refused is the test
    with pytest.raises(ValueError, match="only be copied"):
        np.asarray(pose, copy=False)


@pytest.mark.parametrize("kind", [Pose, Joints])
@for_each(
    "values",
    [
        [],
        [0.0] * 5,
        [0.0] * 7,
        [0.0] * 5 + [math.nan],
        [0.0] * 5 + [math.inf],
        [0.0] * 5 + [-math.inf],
        [0.0] * 5 + ["1"],
        [0.0] * 5 + [None],
        [0.0] * 5 + [True],
        [0.0] * 5 + [1j],
        "123456",
        None,
        1.0,
        {1.0, 2.0, 3.0, 4.0, 5.0, 6.0},
        np.zeros((6, 1)),
        np.zeros(5),
        np.full(6, np.nan),
        np.zeros(6, dtype=complex),
        np.zeros(6, dtype=bool),
        np.array(["1"] * 6),
    ],
)
def test_what_is_not_six_finite_numbers_is_refused(kind: type[Pose | Joints], values: Any) -> None:
    with pytest.raises(ParameterError):
        kind.of(values)


@pytest.mark.parametrize("kind", [Pose, Joints])
@for_each("values", [([0.0] * 6,), (np.zeros(6),), ("here",), (), (1, 2, 3), (1, 2, 3, 4, 5, 6, 7)])
def test_a_class_of_six_numbers_tells_that_there_are_not_six(
    kind: type[Pose | Joints], values: tuple[Any, ...]
) -> None:
    with pytest.raises(ParameterError, match="must be six finite numbers") as told:
        kind(*values)
    assert (f"{kind.__name__}.of takes a list" in str(told.value)) == (len(values) == 1)
    assert isinstance(kind.of(range(6)), kind)
    assert list(inspect.signature(kind).parameters) == list(kind.__slots__)


def test_a_pose_is_not_taken_for_joints_nor_joints_for_a_pose() -> None:
    with pytest.raises(ParameterError, match=r"the joint angles \[rad\]"):
        Joints.of(Pose(0, 0, 0, 0, 0, 0))
    with pytest.raises(ParameterError, match=r"x, y, z \[m\]"):
        Pose.of(Joints(0, 0, 0, 0, 0, 0))
    with pytest.raises(TypeError, match="composes with a Pose"):
        _ = Pose(0, 0, 0, 0, 0, 0) @ np.eye(4)


@for_each(
    "with_another",
    [
        lambda pose, other: pose.distance(other),
        lambda pose, other: pose.almost_equal(other),
        lambda pose, other: pose.interpolate(other, 0.5),
    ],
)
def test_a_pose_goes_with_six_numbers_but_not_with_joints(with_another: Any) -> None:
    pose, other = Pose(1.0, 2.0, 3.0, 0.1, 0.2, 0.3), Pose(1.0, 2.0, 3.5, 0.1, 0.2, 0.3)
    for same in (list(other), other.array):
        assert with_another(pose, same) == with_another(pose, other)
    for wrong in (Joints(*other), "123456", [1.0]):
        with pytest.raises(ParameterError, match="must be"):
            with_another(pose, wrong)


@for_each("t", [-0.1, 50, math.nan, "0.5", None, True])
def test_a_fraction_between_two_is_a_number_from_0_to_1(t: Any) -> None:
    pose, joints = Pose(1.0, 2.0, 3.0, 0.1, 0.2, 0.3), Joints(1.0, 2.0, 3.0, 0.1, 0.2, 0.3)
    for one in (pose, joints):
        with pytest.raises(ParameterError, match=r"t is .*, but must be a number from 0 to 1"):
            one.interpolate(one, t)
        assert one.interpolate(one, np.float32(0.5)) == one.interpolate(one, 0.5)  # type: ignore[arg-type]


def test_an_array_is_described_without_quotation_marks() -> None:
    with pytest.raises(ParameterError, match=r"pose is an array of shape \(4, 4\) and type"):
        Pose.of(np.eye(4))


def test_the_error_names_the_parameter_the_value_and_the_units() -> None:
    with pytest.raises(ParameterError, match=r"ry is nan.*x, y, z \[m\], rx, ry, rz \[rad\]"):
        Pose(0, 0, 0, 0, math.nan, 0)
    with pytest.raises(ParameterError, match=r"j3 is inf.*\[rad\]"):
        Joints(0, 0, math.inf, 0, 0, 0)


@for_each(
    "matrix",
    [
        np.eye(3),
        np.diag([1.0, 1.0, 1.0, 2.0]),
        np.diag([1.0, 1.0, -1.0, 1.0]),
        np.diag([1.0, 1.0, 1.001, 1.0]),
        np.full((4, 4), np.nan),
        [[1.0, 0.0], [0.0]],
        "matrix",
    ],
)
def test_what_is_no_homogeneous_matrix_is_refused(matrix: Any) -> None:
    with pytest.raises(ParameterError):
        Pose.from_matrix(matrix)


def test_what_is_no_quaternion_is_refused() -> None:
    for quaternion in ([0, 0, 0, 0], [1, 0, 0], [1, 0, 0, math.nan], [1e308] * 4):
        with pytest.raises(ParameterError, match="quaternion"):
            Pose.from_quaternion((0, 0, 0), quaternion, "wxyz")
    with pytest.raises(ParameterError, match='"wxyz" or "xyzw"'):
        Pose.from_quaternion((0, 0, 0), (1, 0, 0, 0), "wzyx")  # type: ignore[arg-type]  # refused
    with pytest.raises(ParameterError, match='"wxyz" or "xyzw"'):
        Pose(0, 0, 0, 0, 0, 0).quaternion("wzyx")  # type: ignore[arg-type]  # refused


def test_repr_tells_the_units() -> None:
    assert repr(Pose(*mm(692, 164, 660), *deg(-180, 0, -90))) == (
        "Pose(x=0.692, y=0.164, z=0.66 [m], rx=-3.141593, ry=0, rz=-1.570796 [rad])"
    )
    assert (
        repr(Joints.deg(0, 0, 90, 0, -90, -1e-9)) == "Joints(0, 0, 1.570796, 0, -1.570796, 0 [rad])"
    )


def test_degrees_and_millimetres_at_the_edge() -> None:
    assert deg(180) == math.pi
    assert deg(90, -90) == (math.pi / 2, -math.pi / 2)
    assert mm(250) == 0.25
    assert mm(1, 2, 3) == (0.001, 0.002, 0.003)
    values: list[Any] = [
        "90",
        [90, 90],
        None,
        10**400,
        True,
        1j,
        np.ones(2),
        np.timedelta64(1, "s"),
    ]
    for convert in (deg, mm):
        for wrong in values:
            with pytest.raises(ParameterError, match=r"value is .* several are given one by one"):
                convert(wrong)
            with pytest.raises(ParameterError, match="value is"):
                convert(1, wrong)
    joints = Joints.deg(10, 20, 30, 40, 50, 60)
    assert joints.degrees == pytest.approx((10, 20, 30, 40, 50, 60))
    assert joints == Joints(*deg(10, 20, 30, 40, 50, 60))
    with pytest.raises(ParameterError, match=r"angles is \(1, 2, 3\), but must be .* in degrees"):
        Joints.deg(1, 2, 3)
    for wrong in ("6", True, 10**400, [6]):
        with pytest.raises(ParameterError, match="six joint angles in degrees"):
            Joints.deg(1, 2, 3, 4, 5, wrong)  # type: ignore[arg-type]  # refused


def test_shifted_moves_along_the_axes_of_the_frame() -> None:
    pose = Pose(0.1, 0.2, 0.3, 1, 2, 3)
    assert pose.shifted(z=0.1) == Pose(0.1, 0.2, 0.4, 1, 2, 3)
    assert pose.shifted(1, 2).position.tolist() == [1.1, 2.2, 0.3]
    for wrong in ("1", math.nan, 10**400):
        with pytest.raises(ParameterError, match="y is"):
            pose.shifted(0, wrong)  # type: ignore[arg-type]  # refused


def test_joints_know_how_far_apart_they_are() -> None:
    a = Joints(0, 0, 0, 0, 0, 0)
    assert a.distance([0, 0.1, 0, 0, -0.3, 0]) == 0.3
    assert a.almost_equal(np.full(6, 1e-7))
    assert not a.almost_equal([0, 0, 0, 0, 0, 2 * math.pi])
    assert a.interpolate([1, 2, 3, 4, 5, 6], 0.5) == Joints(0.5, 1, 1.5, 2, 2.5, 3)
    with pytest.raises(ParameterError, match="from 0 to 1"):
        a.interpolate(a, -0.1)
