"""Friction and load from torques."""

from __future__ import annotations

import numpy as np
import pytest

from aioduco.kinematics import arm
from aioduco.sim.calibration.torques import (
    estimate_friction,
    estimate_load,
    fit_by_motion,
    link_torques,
)
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint

from .made import MODEL, configurations, empty, torqued

CENTRE = np.array([0.02, -0.03, 0.06])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_friction_is_found_without_any_mass(seed: int) -> None:
    random = np.random.default_rng(seed)
    dry, viscous = random.uniform(0.5, 6.0, 6), random.uniform(1.0, 8.0, 6)
    found = estimate_friction([torqued(random, (dry, viscous), (1.5, CENTRE))])
    for joint in range(6):
        for kind, truth in (("dry", dry), ("viscous", viscous)):
            estimate = found.values[f"{kind}{joint + 1}"]
            assert estimate.value == pytest.approx(truth[joint], rel=0.03)
            assert estimate.low <= truth[joint] <= estimate.high


@pytest.mark.slow
@pytest.mark.parametrize("own", [0.0, 0.01, 0.05])
@pytest.mark.parametrize("rounds", [1, 2])
def test_intervals_hold_whether_errors_are_of_motions_or_of_reads(rounds: int, own: float) -> None:
    random = np.random.default_rng(5)
    kinds = [(side * v, round(18 / v)) for v in (0.15, 0.45, 0.8) for side in (1, -1)] * rounds
    motions = np.repeat(np.arange(len(kinds)), [reads for _, reads in kinds])
    speed = np.array([v for v, _ in kinds])[motions]
    q = np.concatenate([np.linspace(-0.1, 0.5, reads) for _, reads in kinds])
    between = np.stack([np.sign(speed), speed, np.ones_like(q)], axis=1)
    within = np.stack([np.cos(q), np.sin(q)], axis=1)
    inside = []
    for _ in range(400):
        error = own * random.standard_normal(len(kinds))[motions]
        error += 0.02 * random.standard_normal(len(q))
        fit = fit_by_motion(between, within, within @ (4.0, 1.0) + error, motions)
        assert fit is not None
        inside.append(np.abs(fit[0][:2]) <= fit[1][:2])  # the true ones are zero
    # three standard deviations of a share of 95 % of 400
    assert np.mean(inside, axis=0).min() > 0.917, np.mean(inside, axis=0)


def test_friction_needs_more_motions_than_values() -> None:
    columns = np.repeat([[1.0, 0.2, 1.0], [-1.0, -0.2, 1.0], [1.0, 0.8, 1.0]], 9, axis=0)
    q = np.tile(np.linspace(0.0, 0.5, 9), 3)
    within = np.stack([np.cos(q), np.sin(q)], axis=1)
    torque = np.random.default_rng(1).standard_normal(27)
    assert fit_by_motion(columns, within, torque, np.repeat([0, 1, 2], 9)) is None


@pytest.mark.slow
def test_the_load_is_found_with_its_centre() -> None:
    random = np.random.default_rng(3)
    run = torqued(random, (np.zeros(6), np.zeros(6)), (2.0, CENTRE))
    found = estimate_load(arm(MODEL), [run])
    assert found.values["mass"].value == pytest.approx(2.0, rel=0.02)
    for name, truth in zip("xyz", CENTRE, strict=True):
        assert found.values[name].value == pytest.approx(truth, abs=1e-3)


def test_a_bare_flange_is_said_to_carry_nothing() -> None:
    random = np.random.default_rng(4)
    run = torqued(random, (np.zeros(6), np.zeros(6)), (0.0, CENTRE))
    found = estimate_load(arm(MODEL), [run])
    assert found.values == {}
    assert "no load" in found.missing[0]


@pytest.mark.slow
def test_links_of_other_masses_leave_the_load_out() -> None:
    random = np.random.default_rng(5)
    run = torqued(random, (np.zeros(6), np.zeros(6)), (2.0, CENTRE))
    found = estimate_load(arm("gcr20_1400"), [run])
    assert found.values == {}
    assert "the masses of the links are others" in found.missing[0]


def test_no_torques_are_said() -> None:
    assert "0 torques at rest" in estimate_load(arm(MODEL), [empty()]).missing[0]
    assert len(estimate_friction([empty()]).missing) == 6


def test_weights_are_those_of_the_physics() -> None:
    random = np.random.default_rng(6)
    model = arm(MODEL)
    for q in configurations(random, 5):
        world = World(model, q=q)
        for _ in range(400):
            world.step(JointSetPoint.at_rest(q))
        assert world.reading().torque == pytest.approx(link_torques(model, q[None])[0], abs=1e-4)
