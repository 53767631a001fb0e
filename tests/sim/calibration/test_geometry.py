"""The table of an arm from its poses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aioduco.errors import CalibrationError
from aioduco.kinematics import DhCorrections, Geometry, arm
from aioduco.models.rotation import Array
from aioduco.sim.calibration.evidence import Poses
from aioduco.sim.calibration.geometry import estimate_geometry
from aioduco.sim.profile import GEOMETRY, ArmProfile

from .made import MODEL, READY, configurations, exact, hidden_geometry, poses_of


@pytest.mark.slow
@pytest.mark.parametrize("model", [MODEL, "gcr10_1300", "gcr20_1400", "gcr3_618"])
def test_the_table_of_a_hidden_arm_is_found(model: str) -> None:
    inside = []
    for seed in range(2):
        random = np.random.default_rng(seed)
        truth = hidden_geometry(random, model)
        found = estimate_geometry(model, [poses_of(truth, configurations(random, 40))])
        assert found.missing == ()
        assert set(found.values) == set(GEOMETRY)
        for name, estimate in found.values.items():
            value = truth.values["geometry"][name].value
            most = 1e-4 if name[:-1] in ("a", "d") else math.radians(0.01)
            assert abs(estimate.value - value) < most, name
            inside.append(estimate.low <= value <= estimate.high)
    assert np.mean(inside) >= 0.95


@pytest.mark.slow
def test_its_intervals_hold_with_noise() -> None:
    inside = []
    for seed in range(4):
        random = np.random.default_rng(100 + seed)
        truth = hidden_geometry(random)
        poses = poses_of(truth, configurations(random, 40))
        noisy = poses.joints + 3e-5 * random.standard_normal(poses.joints.shape)
        found = estimate_geometry(MODEL, [Poses(noisy, poses.poses)])
        for name, estimate in found.values.items():
            value = truth.values["geometry"][name].value
            inside.append(estimate.low <= value <= estimate.high)
    assert len(inside) == 88
    assert np.mean(inside) >= 0.9  # by chance fewer of 88 in 1 of 50 cases


@pytest.mark.slow
def test_how_d2_is_divided_among_parallel_joints_does_not_mislead() -> None:
    random = np.random.default_rng(3)
    truth = hidden_geometry(random).arm
    table = truth.geometry.corrections
    assert table is not None
    divided = table._replace(d=(0.0, 0.0008, -0.0006, 0.0005, 0.0, 0.0))
    joints = configurations(random, 40)
    flange = truth.geometry._replace(corrections=DhCorrections(*divided))
    poses = Poses(joints, _fkine(flange, joints))
    found = estimate_geometry(MODEL, [poses])
    low, high = found.values["d2"][1:]
    assert low <= 0.1405 + 0.0007 <= high
    assert "d3" not in found.values


@pytest.mark.slow
def test_what_poses_do_not_show_is_left_out_and_said() -> None:
    random = np.random.default_rng(4)
    joints = configurations(random, 40)
    joints[:, 4] = READY[4]
    found = estimate_geometry(MODEL, [poses_of(hidden_geometry(random), joints)])
    assert found.values.keys() < set(GEOMETRY)
    assert {"alpha5", "theta5"} & (set(GEOMETRY) - found.values.keys())
    assert "joint 5 by 0° turned too little" in found.missing[0]


def test_too_few_poses_are_said() -> None:
    random = np.random.default_rng(5)
    found = estimate_geometry(MODEL, [poses_of(hidden_geometry(random), configurations(random, 7))])
    assert not found.values
    assert "7 poses at rest" in found.missing[0]
    assert "check --motions" in found.missing[0]


@pytest.mark.slow
def test_another_model_is_refused() -> None:
    random = np.random.default_rng(6)
    poses = poses_of(ArmProfile("gcr10_1300"), configurations(random, 40))
    with pytest.raises(CalibrationError, match=r"do not fit|another\s+model"):
        estimate_geometry(MODEL, [poses])


@pytest.mark.slow
def test_poses_of_a_moving_arm_are_refused() -> None:
    random = np.random.default_rng(7)
    joints = configurations(random, 40)
    poses = poses_of(hidden_geometry(random), joints)
    late = joints + random.uniform(-0.02, 0.02, joints.shape)
    with pytest.raises(CalibrationError, match="while the arm moved"):
        estimate_geometry(MODEL, [Poses(late, poses.poses)])


@pytest.mark.slow
def test_a_few_poses_that_stand_out_do_not_count() -> None:
    random = np.random.default_rng(8)
    truth = hidden_geometry(random)
    poses = poses_of(truth, configurations(random, 60))
    poses.poses[[5, 30], 0, 3] += 0.02
    found = estimate_geometry(MODEL, [poses])
    assert "58 of 60 poses" in found.notes[0]
    assert found.values["a2"].value == pytest.approx(truth.values["geometry"]["a2"].value, abs=1e-5)


@pytest.mark.slow
def test_poses_of_a_tip_without_its_offset_leave_out_what_the_tool_hides() -> None:
    random = np.random.default_rng(9)
    truth = hidden_geometry(random)
    poses = poses_of(truth, configurations(random, 60))
    tool = np.eye(4)
    tool[:3, 3] = 0.01, -0.02, 0.12
    found = estimate_geometry(MODEL, [Poses(poses.joints, poses.poses @ tool, tip=True)])
    assert not {"a6", "d6", "alpha6", "theta6"} & found.values.keys()
    assert "no offset of the tool" in found.missing[0]
    for name in ("a2", "a3", "d5", "theta3"):
        low, high = found.values[name][1:]
        assert low <= truth.values["geometry"][name].value <= high


@pytest.mark.slow
def test_the_models_own_table_is_found_as_it_is() -> None:
    random = np.random.default_rng(10)
    found = estimate_geometry(MODEL, [poses_of(ArmProfile(MODEL), configurations(random, 40))])
    nominal = arm(MODEL).geometry
    assert found.values["d2"].value == pytest.approx(nominal.d2, abs=2e-6)
    assert exact(0.0).value == pytest.approx(found.values["a1"].value, abs=2e-6)


def _fkine(geometry: Geometry, joints: Array) -> Array:
    return replace(arm(MODEL), geometry=geometry).fkine(joints)
