"""Causes of external torques: each, made exactly, is named with its size."""

from __future__ import annotations

import numpy as np
import pytest

from aioduco.sim.twin.patterns import Friction, PatternFit, Patterns
from aioduco.sim.twin.predictor import Deviation

from .arms import ARM

SPEEDS = np.array([0.5, -0.4, 0.3, 0.6, -0.5, 0.2])
NORMAL = Friction(0.03 * np.array(ARM.effort), np.zeros(6), np.zeros(6))
NOISE = 0.003 * np.array(ARM.effort)
DOWN = np.array([0.0, 0.0, -9.81])


#: torques of the joints for a force at the flange
LEVER = ARM.jacobian([0.3, 0.2, 1.2, 0.1, -1.2, 0.4])[:3].T


def fit_of(external: np.ndarray | None, *, force: np.ndarray | None = None) -> Patterns | None:
    """The fit after half a second of these torques beyond the normal friction, while it moves."""
    fit, found = PatternFit(NORMAL, NOISE), None
    for count in range(60):
        torque = None if external is None else external + NORMAL.torque(SPEEDS)
        found = fit.update(
            Deviation(
                count * 0.008, 0.008, SPEEDS, SPEEDS, torque, force, LEVER.T, DOWN,
                np.zeros(6), None, None, None, True,
            )
        )  # fmt: skip
    return None if found is None else found[1]


def fitted(external: np.ndarray | None, *, force: np.ndarray | None = None) -> Patterns:
    found = fit_of(external, force=force)
    assert found is not None
    return found


def test_a_mass_is_a_mass() -> None:
    found = fitted(LEVER @ np.array([0.0, 0.0, -9.81 * 0.5]))
    assert found.mass == pytest.approx(0.5, rel=0.02)
    assert found.is_mass(0.0)
    assert not found.is_friction


def test_a_missing_mass_is_one_that_was_set() -> None:
    found = fitted(LEVER @ np.array([0.0, 0.0, 9.81 * 0.5]))
    assert found.mass == pytest.approx(-0.5, rel=0.02)
    assert found.is_mass(0.5)
    assert found.is_mass(None)
    assert not found.is_mass(0.0), "nothing was carried: something lifts the arm"


def test_a_push_to_the_side_is_a_force() -> None:
    found = fitted(LEVER @ np.array([6.0, -8.0, 0.0]))
    assert found.force == pytest.approx([6.0, -8.0, 0.0], abs=0.3)
    assert not found.is_mass(0.5)
    assert not found.is_friction


def test_more_friction_is_friction() -> None:
    found = fitted(0.3 * NORMAL.torque(SPEEDS))
    assert found.friction == pytest.approx(0.3, rel=0.05)
    assert found.is_friction


def test_a_force_sensor_is_enough() -> None:
    found = fitted(None, force=np.array([0.0, 10.0, 0.0]))
    assert found.force == pytest.approx([0.0, 10.0, 0.0], abs=0.2)
    assert not found.is_mass(0.5)


def test_a_force_sensor_that_was_zeroed_under_a_force_hides_nothing() -> None:
    found = fitted(LEVER @ np.array([0.0, 10.0, 0.0]), force=np.zeros(3))
    assert found.force[1] > 5.0


def test_without_torques_and_forces_there_is_nothing_to_fit() -> None:
    assert fit_of(None) is None


def test_a_joint_that_stands_may_stick() -> None:
    stands = np.zeros(6)
    stuck = NORMAL.residual(NORMAL.dry.copy(), stands)
    assert np.all(stuck == 0.0)
    assert np.all(NORMAL.residual(2.0 * NORMAL.dry, stands) > 0.0)
