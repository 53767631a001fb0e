"""Forward kinematics and Jacobian against MuJoCo and poses of real arms."""

from __future__ import annotations

import importlib
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.errors import ParameterError
from aioduco.kinematics import Arm, DhCorrections, arm, models
from aioduco.kinematics.forward import singular_values
from aioduco.kinematics.rates import ArmRates
from aioduco.models.pose import Joints, Pose
from aioduco.models.rotation import Array
from aioduco.sim.physics.model import mjcf
from kinematics.bias import bias_acceleration

mujoco: Any = importlib.import_module("mujoco")  # compiled, without types
ANGLE = st.floats(-2 * math.pi, 2 * math.pi).map(lambda angle: round(angle, 12))
JOINTS = st.lists(ANGLE, min_size=6, max_size=6).map(np.array)
ARMS = [arm(model) for model in models()]


#: as a calibration may find it
CALIBRATED = replace(
    ARMS[1],
    name="calibrated",
    geometry=ARMS[1].geometry._replace(
        corrections=DhCorrections(
            *map(tuple, np.random.default_rng(7).normal(0.0, 0.01, (4, 6)).tolist())
        )
    ),
)


@pytest.fixture(params=ARMS, ids=lambda each: each.name)
def any_arm(request: pytest.FixtureRequest) -> Arm:
    assert isinstance(request.param, Arm)
    return request.param


def configurations(count: int = 50) -> Array:
    return np.random.default_rng(1).uniform(-2 * np.pi, 2 * np.pi, (count, 6))


NO_CORRECTIONS: list[Any] = [
    3,
    ((0.0,) * 6,) * 4,
    DhCorrections(a=(0.0,) * 5),
    DhCorrections(theta=(math.nan,) * 6),
]


@for_each(
    "name, wrong",
    [
        ("velocity", [(1.0,) * 5, (math.nan,) * 6, (-1.0,) * 6, "abcdef", 1.0, None]),
        ("effort", [(0.0,) * 6]),
        ("masses", [(1.0,) * 6, (-1.0,) * 7]),
        ("centres", [((0.0,) * 3,) * 6, "centre", 1.0]),
        ("lower", [(7.0,) * 6, (0.0,) * 5]),
        ("upper", [(-7.0,) * 6, (10**400,) * 6]),
        ("geometry", [3, ARMS[0].geometry._replace(d1=math.nan), (1.0,) * 6]),
        ("geometry", [ARMS[0].geometry._replace(a2=0.0), ARMS[0].geometry._replace(a3=-0.4)]),
        ("geometry", [ARMS[0].geometry._replace(corrections=each) for each in NO_CORRECTIONS]),
        ("name", [3, ""]),
    ],
)
def test_numbers_of_ones_own_are_checked(name: str, wrong: list[Any]) -> None:
    for value in wrong:
        with pytest.raises(ParameterError):
            replace(ARMS[0], **{name: value})


def test_numbers_of_ones_own_may_come_in_lists() -> None:
    given: dict[str, Any] = {
        "velocity": [1.0] * 6,
        "upper": np.full(6, 3),
        "centres": np.zeros((7, 3)).tolist(),
    }
    own = replace(ARMS[0], **given)
    columns: Any = [[0.001] * 6] * 4
    lists = DhCorrections(*columns)
    calibrated = replace(own, geometry=own.geometry._replace(corrections=lists))
    assert np.isfinite(calibrated.fkine([0.0] * 6)).all()
    assert (own.velocity, own.upper) == ((1.0,) * 6, (3.0,) * 6)
    assert hash(own) != hash(ARMS[0])
    assert own == replace(own)


def test_there_are_thirteen_models() -> None:
    assert len(models()) == 13
    assert arm("GCR5-910") is arm("gcr5_910")
    with pytest.raises(ParameterError, match="gcr3_618, gcr5_910"):
        arm("ur5e")


def test_lengths_can_be_replaced() -> None:
    longer = arm("gcr5_910", d2=0.1411)
    assert longer.geometry.d2 == 0.1411
    assert longer.geometry.a2 == arm("gcr5_910").geometry.a2
    assert arm("gcr5_910").geometry.d2 == 0.1405
    with pytest.raises(ParameterError, match='"d1", "d2", "a2"'):
        arm("gcr5_910", d4=0.1)


@for_each(
    "joints, position",
    [
        ([15.771, -8.0047, -97.4297, 15.6165, 89.9417, 11.8593], [-555.8729, -10.2684, 333.8967]),
        ([15.771, -8.0054, -97.4297, 15.6158, 89.9417, 8.5264], [-555.8742, -10.2687, 333.8890]),
    ],
)
def test_the_lengths_of_the_gcr5_fit_what_a_real_one_logged(
    joints: list[float], position: list[float]
) -> None:
    # Gorani-ros2/ROS2, duco_named_poses.json [deg, mm]
    flange = arm("GCR5-910").fkine(np.radians(joints))
    assert np.linalg.norm(1000 * flange[:3, 3] - position) < 0.7


def test_at_zero_the_arm_stands_straight_up(any_arm: Arm) -> None:
    g = any_arm.geometry
    expected = np.eye(4)
    expected[:3, 3] = 0.0, g.d2 + g.d6, g.d1 + g.a2 + g.a3 + g.d5
    expected[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]  # the flange looks along base y
    np.testing.assert_allclose(any_arm.fkine(np.zeros(6)), expected, atol=1e-15)


def test_demo_of_the_vendor_for_the_gcr10_1300() -> None:
    reached = arm("gcr10_1300").fkine(Joints(0, 0, math.pi / 2, 0, -math.pi / 2, 0))
    demo = Pose(0.692, 0.164, 0.660, -math.pi, 0, -math.pi / 2)
    assert Pose.from_matrix(reached).almost_equal(demo, position=1e-9, rotation=1e-9)


def test_flange_is_where_mujoco_puts_it(any_arm: Arm) -> None:
    model = mujoco.MjModel.from_xml_string(mjcf(any_arm, 0.001))
    data = mujoco.MjData(model)
    for q in configurations():
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        flange = any_arm.fkine(q)
        np.testing.assert_allclose(flange[:3, 3], data.site("flange").xpos, rtol=0, atol=1e-9)
        np.testing.assert_allclose(
            flange[:3, :3].ravel(), data.site("flange").xmat, rtol=0, atol=1e-9
        )


def test_jacobian_is_that_of_mujoco(any_arm: Arm) -> None:
    model = mujoco.MjModel.from_xml_string(mjcf(any_arm, 0.001))
    data = mujoco.MjData(model)
    linear, angular = np.empty((3, 6)), np.empty((3, 6))
    for q in configurations(20):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_jacSite(model, data, linear, angular, model.site("flange").id)
        ours = any_arm.jacobian(q)
        np.testing.assert_allclose(ours, np.vstack([linear, angular]), rtol=0, atol=1e-9)


def test_many_configurations_at_once_are_as_each_alone(any_arm: Arm) -> None:
    q = configurations(12)
    stacked = q.reshape(3, 4, 6)
    for function, shape in ((any_arm.fkine, (4, 4)), (any_arm.jacobian, (6, 6))):
        together = function(stacked)
        assert together.shape == (3, 4, *shape)
        for one, each in zip(together.reshape(12, *shape), q, strict=True):
            np.testing.assert_array_equal(one, function(each))


@given(JOINTS, st.integers(0, 2**32 - 1))
def test_bias_acceleration_is_how_the_jacobian_changes(q: Array, seed: int) -> None:
    five = arm("gcr5_910")
    qd = np.random.default_rng(seed).normal(size=6)
    step = 1e-5
    change = (five.jacobian(q + step * qd) - five.jacobian(q - step * qd)) / (2 * step)
    bias = bias_acceleration(five.geometry, q, qd)
    np.testing.assert_allclose(bias, change @ qd, rtol=1e-6, atol=1e-7)


@given(JOINTS)
def test_determinant_of_the_jacobian_is_the_product_of_the_singular_values(q: Array) -> None:
    five = arm("gcr5_910")
    g = five.geometry
    expected = -g.a2 * g.a3 * (g.a2 + g.a3 + g.d5) * singular_values(g, q).prod()
    assert np.linalg.det(five.jacobian(q)) == pytest.approx(expected, abs=1e-12)


@for_each(
    "name, q",
    [
        ("elbow", [0.3, 0.5, 0.0, 0.4, 1.0, 0.0]),
        ("elbow", [0.3, 0.5, math.pi, 0.4, 1.0, 0.0]),
        ("wrist", [0.3, 0.5, 1.0, 0.4, 0.0, 0.0]),
        ("wrist", [0.3, 0.5, 1.0, 0.4, math.pi, 0.0]),
        ("shoulder", [0.3, -math.asin(392 / 425 * math.sin(1.5 - 0.7)), 1.5, None, 1.0, 0.0]),
    ],
)
def test_each_singularity_is_named(name: str, q: list[float | None]) -> None:
    five = arm("gcr5_910")
    if name == "shoulder":
        # Joint 4 such that the wrist's centre stands over the axis of joint 1.
        g = five.geometry
        assert q[1] is not None
        assert q[2] is not None
        ahead = g.a2 * math.sin(q[1]) + g.a3 * math.sin(q[1] + q[2])
        q[3] = -math.asin(ahead / g.d5) - q[1] - q[2]
    measure = five.singularity(np.array(q, dtype=float))
    assert measure.nearest == name
    assert getattr(measure, name) == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.matrix_rank(five.jacobian(np.array(q, dtype=float)), tol=1e-9) == 5


@for_each("wrong", [[[0.0] * 6] * 3, [0.0] * 5])
def test_what_is_of_one_configuration_takes_no_other_number(wrong: Any) -> None:
    here = Pose.from_matrix(ARMS[0].fkine([0.0] * 6))
    for question in (ARMS[0].singularity, lambda q: ARMS[0].fits(q, here)):
        with pytest.raises(ParameterError, match=r"of shape .*6,?\) \[rad\]"):
            question(wrong)


def test_joints_of_another_number_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"\(7,\)"):
        arm("gcr5_910").fkine(np.zeros(7))


@for_each("any_arm", [*ARMS, CALIBRATED])
def test_rates_in_plain_floats_are_those_of_the_matrices(any_arm: Arm) -> None:
    speeds = np.random.default_rng(2).uniform(-3, 3, (50, 6))
    for q, qd in zip(configurations(), speeds, strict=True):
        rates, flange = ArmRates(any_arm.geometry, q.tolist()), any_arm.fkine(q)
        twist = any_arm.jacobian(q) @ qd
        np.testing.assert_allclose(rates.position, flange[:3, 3], atol=1e-13)
        np.testing.assert_allclose(rates.rotation, flange[:3, :3], atol=1e-13)
        np.testing.assert_allclose(rates.of_flange(qd.tolist()), twist, atol=1e-12)
        np.testing.assert_allclose(rates.of_joints(twist.tolist()), qd, atol=1e-9)


def test_joint_speeds_at_a_singularity_are_refused(any_arm: Arm) -> None:
    with pytest.raises(ZeroDivisionError):
        ArmRates(any_arm.geometry, [0.0] * 6).of_joints([0.1] * 6)
