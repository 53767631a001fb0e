"""Times along a path: as short as the limits allow, and never shorter."""

from __future__ import annotations

import importlib
import logging

import numpy as np
import pytest

from aioduco.kinematics import arm as arm_of
from aioduco.models.ranges import JOINT_SPEED
from aioduco.planning import MotionLimits, Plan
from aioduco.planning.spline import BSpline
from aioduco.planning.timing import TimedPath, timed
from aioduco.streaming.joint_trajectory import JointTrajectory

ARM = arm_of("gcr5_910")
V, A, JERK = 1.5, 3.0, 30.0


def wavy(seed: int) -> BSpline:
    """A path of six joints with bends, over a length of 3."""
    control = np.random.default_rng(seed).uniform(-1.0, 1.0, (6, 6))
    knots = np.concatenate([[0.0] * 3, np.linspace(0.0, 3.0, 4), [3.0] * 3])
    return BSpline(knots, control, 3)


def excess(found: TimedPath, limits: MotionLimits, step: float = 0.0005, orders: int = 3) -> float:
    """The largest share of a limit, by differences of what will be sent."""
    trajectory = JointTrajectory(
        found.positions, found.times, found.velocities, found.accelerations
    )
    times = np.arange(0.0, found.times[-1], step)
    q = trajectory.curve(found.positions[0].tolist()).at(times)
    return max(
        float((np.abs(np.diff(q, order, axis=0)) / step**order / limit).max())
        for order, limit in enumerate(limits.arrays[:orders], start=1)
    )


@pytest.mark.parametrize(
    ("way", "least", "within"),
    [
        # The speed is reached, and the acceleration on the way to it.
        (2.0, 2.0 / V + V / A + A / JERK, 1.02),
        # Neither is: the jerk alone is at its limit, four times.
        (0.02, 4.0 * (0.02 / (2.0 * JERK)) ** (1.0 / 3.0), 1.04),
    ],
)
def test_a_straight_way_takes_the_time_of_the_closed_form(
    way: float, least: float, within: float
) -> None:
    limits = MotionLimits.of(ARM, V, A, JERK)
    control = np.outer(np.linspace(0.0, way, 4), [1.0, 0.5, -0.3, 0.0, 0.2, -1.0])
    found = timed(BSpline([0.0] * 4 + [1.0] * 4, control, 3), limits)
    assert least * 0.999 <= found.times[-1] <= least * within
    assert excess(found, limits) <= 1.0


def test_no_limit_is_exceeded_between_the_places_that_are_looked_at() -> None:
    """A stream takes no plan that is faster than a joint may be, by a millionth."""
    for way, a, jerk in ((6.0, 60.0, 2e4), (6.0, 20.0, 2e4)):
        limits = MotionLimits.of(ARM, JOINT_SPEED.high, a, jerk)
        control = np.outer(np.linspace(0.0, way, 4), [1.0, 0.5, -0.3, 0.0, 0.2, -1.0])
        found = timed(BSpline([0.0] * 4 + [1.0] * 4, control, 3), limits)
        assert excess(found, limits, step=1e-4, orders=2) <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.filterwarnings("ignore:.*invalid escape sequence")  # of its source
def test_without_a_limit_of_jerk_it_is_as_fast_as_toppra(seed: int) -> None:
    # Loading it takes longer than all else in this file.
    toppra = importlib.import_module("toppra")
    importlib.import_module("toppra.constraint")
    logging.getLogger("toppra").setLevel(logging.ERROR)
    curve = wavy(seed)
    law = toppra.algorithm.TOPPRA(
        [
            toppra.constraint.JointVelocityConstraint(np.array([[-V, V]] * 6)),
            toppra.constraint.JointAccelerationConstraint(np.array([[-A, A]] * 6)),
        ],
        toppra.SplineInterpolator(at := np.linspace(0.0, 3.0, 400), curve(at)),
        np.linspace(0.0, 3.0, 400),
        solver_wrapper="seidel",
    )
    fastest = float(law.compute_trajectory().duration)
    limits = MotionLimits.of(ARM, V, A, 1000.0 * A)
    found = timed(curve, limits)
    assert found.times[-1] <= 1.05 * fastest
    assert excess(found, limits) <= 1.0
    # The jerk costs the time of a few ramps of the acceleration, of 0.1 s each.
    smooth = timed(curve, MotionLimits.of(ARM, V, A, JERK))
    assert smooth.times[-1] <= 1.15 * fastest
    assert excess(smooth, MotionLimits.of(ARM, V, A, JERK)) <= 1.0


@pytest.mark.parametrize(
    ("v", "a", "jerk"),
    [(2e-4, 2.0, 20.0), (1.0, 2.0, 1e-3), (3.0, 1.75e-4, 30.0), (2e-4, 1.75e-4, 1e-6)],
)
def test_a_slow_limit_makes_a_plan_long_and_not_large(v: float, a: float, jerk: float) -> None:
    way = 0.5
    control = np.outer(np.linspace(0.0, way, 4), [1.0, 0.5, -0.3, 0.0, 0.2, -1.0])
    limits = MotionLimits.of(ARM, v, a, jerk)
    found = timed(BSpline([0.0] * 4 + [1.0] * 4, control, 3), limits)
    assert len(found.times) < 5000
    least = max(way / v, 2.0 * np.sqrt(way / a), (32.0 * way / jerk) ** (1.0 / 3.0))
    assert 0.999 * least <= found.times[-1] <= 1.06 * least
    speed, acceleration = np.abs(found.velocities).max(), np.abs(found.accelerations).max()
    assert speed <= v
    assert acceleration <= a


@pytest.mark.slow
def test_a_long_plan_is_checked_by_no_more_looks_than_a_short_one() -> None:
    control = np.outer(np.linspace(0.0, 0.5, 4), [1.0, 0.5, -0.3, 0.0, 0.2, -1.0])
    curve = BSpline([0.0] * 4 + [1.0] * 4, control, 3)
    looks = []
    for v in (1.0, 2e-4):
        limits = MotionLimits.of(ARM, v, 2.0, None)
        found = timed(curve, limits)
        plan = Plan(
            ARM,
            JointTrajectory(found.positions, found.times, found.velocities, found.accelerations),
            limits,
            np.eye(4),
            *(np.zeros((1, 6)), np.zeros(1), np.ones(1), np.ones(6)),
        )
        times, q = plan._samples(0.0)
        assert np.abs(np.diff(q, axis=0)).max() <= np.deg2rad(0.21)
        looks.append(len(times))
    assert looks[1] <= 1.1 * looks[0]
