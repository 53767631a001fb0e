"""Friction and load from torques."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import t as student

from aioduco.kinematics import arm
from aioduco.sim.calibration.torques import (
    deviations,
    estimate_friction,
    estimate_load,
    link_torques,
)
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint

from .made import MODEL, configurations, empty, torqued

CENTRE = np.array([0.02, -0.03, 0.06])


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


@pytest.mark.parametrize("rounds", [1, 2])
def test_intervals_hold_with_few_motions_each_of_which_has_an_error_of_its_own(rounds: int) -> None:
    random = np.random.default_rng(5)
    motions = [(side * v, np.linspace(-0.1, 0.5, 8)) for v in (0.15, 0.45, 0.8) for side in (1, -1)]
    motions *= rounds
    turns = np.repeat(np.arange(len(motions)), 8)
    speed = np.repeat([v for v, _ in motions], 8)
    q = np.concatenate([places for _, places in motions])
    matrix = np.stack([np.sign(speed), speed, np.ones_like(q), np.cos(q), np.sin(q)], axis=1)
    factor, inside = float(student.ppf(0.975, len(motions) - 3)), []
    for _ in range(400):
        error = 0.05 * random.standard_normal(len(motions))[turns]
        error += 0.02 * random.standard_normal(len(q))
        found, *_ = np.linalg.lstsq(matrix, error, rcond=None)  # the true ones are zero
        half = factor * deviations(matrix, error - matrix @ found, turns)
        inside.append(np.abs(found[:2]) <= half[:2])
    # three standard deviations of a share of 95 % of 400
    assert np.mean(inside, axis=0).min() > 0.917, np.mean(inside, axis=0)


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
        assert world.torque == pytest.approx(link_torques(model, q[None])[0], abs=1e-4)
