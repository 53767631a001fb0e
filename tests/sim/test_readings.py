"""Readings as a controller gives them: single precision, a force sensor with noise and offset."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aioduco.sim.force.sensor import SensorNoise
from aioduco.sim.simulator import Simulator

from .conftest import Connect, Program, Started


def of_32_bits(numbers: list[float]) -> bool:
    return bool(np.array(numbers, np.float32).tolist() == numbers)


@pytest.mark.parametrize("real", [True, False])
def test_readings_are_of_single_precision_on_request(started: Started, real: bool) -> None:
    sim, robot = started(real_readings=real)
    assert robot.to(0.1, 0.2, 1.3, 0.1, -1.4, 0.3) == 4
    sim.wait_until(lambda: sim.view.standing)
    status = robot.getRobotStatus()
    joints, pose = robot.get_actual_joints_position(), robot.get_tcp_pose()
    readings = [joints, pose, status.jointActualPosition, status.cartActualPosition]
    assert [of_32_bits(each) for each in readings] == [real] * 4
    # it goes on to settle by some micrometres
    assert joints == pytest.approx(tuple(sim.joints), abs=1e-4)


@pytest.mark.slow
def test_a_force_sensor_at_rest_shows_an_offset_and_noise_until_it_is_tared(
    connect: Connect,
) -> None:
    with Simulator(speed=math.inf, real_readings=True, seed=3) as sim:
        robot = connect(sim)
        offset = SensorNoise(3).offset
        untared = forces(sim, robot)
        assert all(map(of_32_bits, untared))
        noise = np.abs(np.array(untared) - offset)[:, :3]
        # A draw of twice what three standard deviations are comes once in a hundred million.
        assert 0.05 < noise.max() < 1.0
        assert np.abs(offset[:3]).max() > 1.0
        robot.bring_up()  # which tares it, by what it shows at that instant
        assert np.abs(np.array(forces(sim, robot)))[:, :3].max() < 2.0


def forces(sim: Simulator, robot: Program) -> list[list[float]]:
    """Fifty different readings of the force sensor."""
    shown: list[list[float]] = []

    def enough() -> bool:
        force = robot.fc_get_ft()
        if force not in shown:
            shown.append(force)
        return len(shown) >= 50

    sim.wait_until(enough, 1e6)
    return shown


def test_the_same_seed_gives_the_same_noise() -> None:
    rows = [[SensorNoise(seed)(np.zeros(6)).tolist() for _ in range(3)] for seed in (1, 1, 2)]
    assert rows[0] == rows[1] != rows[2]
