"""Lag, gain and noise of drives from samples."""

from __future__ import annotations

import numpy as np
import pytest

from aioduco.sim.calibration.drives import estimate_drives, estimate_noise
from aioduco.sim.calibration.evidence import Motions

from .made import turns


def hidden(seed: int) -> tuple[np.random.Generator, np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    lag = random.uniform(0.008, 0.03, 6)
    return random, lag, random.uniform(0.4, 0.95, 6) / lag, random.uniform(3e-5, 5e-5, 6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5, 8))
def test_lag_is_found_within_a_millisecond_and_gain_within_its_interval(seed: int) -> None:
    random, lag, gain, noise = hidden(seed)
    motions = turns(random, lag, gain, noise)
    found, left = estimate_drives([motions]), estimate_noise([motions])
    assert found.missing == ()
    for joint in range(6):
        estimate = found.values[f"lag{joint + 1}"]
        assert abs(estimate.value - lag[joint]) < 1e-3
        assert estimate.low <= lag[joint] <= estimate.high
        _, low, high = found.values[f"gain{joint + 1}"]
        assert low <= gain[joint] <= high
        assert left.values[f"joint{joint + 1}"].value == pytest.approx(noise[joint], rel=0.25)


@pytest.mark.slow
def test_samples_at_any_rate_and_times_will_do() -> None:
    random, lag, gain, noise = hidden(5)
    motions = turns(random, lag, gain, noise, rate=20)
    late = motions._replace(time=motions.time + random.uniform(0.0, 0.01, len(motions.time)))
    found = estimate_drives([late])
    for joint in range(6):
        assert abs(found.values[f"lag{joint + 1}"].value - lag[joint]) < 1e-3


@pytest.mark.slow
def test_a_drive_without_lag_has_no_gain() -> None:
    random = np.random.default_rng(6)
    motions = turns(random, np.zeros(6), np.full(6, 200.0), np.full(6, 3e-5))
    found = estimate_drives([motions])
    assert found.values["lag1"].value == pytest.approx(0.0, abs=1e-4)
    assert "gain1" not in found.values
    assert "gain of joint 1: motions with more acceleration" in found.missing[0]


@pytest.mark.slow
def test_joints_that_hardly_move_are_left_out() -> None:
    random, lag, gain, noise = hidden(5)
    motions = turns(random, lag, gain, noise)
    still = motions.wanted_speed.copy()
    still[:, 2] = 0.0
    found = estimate_drives([motions._replace(wanted_speed=still)])
    assert "lag3" not in found.values
    assert found.missing == ("drives, joint 3: 0 motions are too few, 6 are needed",)


def test_noise_below_the_steps_of_a_recording_is_not_claimed() -> None:
    random, lag, gain, _ = hidden(5)
    found = estimate_noise([turns(random, lag, gain, np.zeros(6))])
    assert found.values == {}
    assert "not above the steps" in found.missing[0]


@pytest.mark.slow
def test_a_drive_that_does_not_trail_by_a_constant_time_is_left_out() -> None:
    random, lag, gain, noise = hidden(5)
    motions = turns(random, lag, gain, noise)
    jumped = motions.joints.copy()
    moving = np.abs(motions.wanted_speed[:, 5]) > 0.02
    groups = np.cumsum(np.diff(np.flatnonzero(moving), prepend=0) > 5) % 2 == 1
    jumped[np.flatnonzero(moving)[groups], 5] += 0.01
    found = estimate_drives([motions._replace(joints=jumped)])
    assert "lag6" not in found.values
    assert "joint 6: motions that were held out differ" in found.missing[-1]


def test_no_samples_are_no_error() -> None:
    none = np.zeros((0, 6))
    found = estimate_drives([Motions(np.zeros(0), none, none, none, none)])
    assert len(found.missing) == 6
