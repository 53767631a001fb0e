"""The servo follower: targets that replace one another, limits, stops."""

from __future__ import annotations

import math

import numpy as np
import pytest
from for_each import for_each

from aioduco.sim.planner.servo_follower import ServoFollower, ServoTuning

from .motions import CYCLE, FIVE, ran

Q = np.array([0.0, 0.0, 1.5, 0.0, -1.5, 0.0])
NONE = np.zeros(6)


def tuning(v: float = 1.0, a: float = 5.0, **other: float) -> ServoTuning:
    gains = {"kp": 200.0, "kd": 25.0, "smooth_vel": 10.0, "smooth_acc": 1.0}
    return ServoTuning(v, a, **(gains | other))


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.5, 5.0, 50.0, np.inf])
def test_it_ends_at_the_target_within_its_limits_and_does_not_pass_it(a: float) -> None:
    servo = ServoFollower(FIVE, Q, CYCLE)
    goal = Q + np.array([1.0, -0.5, 0.2, 0.0, 0.3, -1.0])
    servo.aim(goal, tuning(v=1.2, a=a))
    rows = ran(servo)
    assert np.abs(rows[-1, 0] - goal).max() < 1e-4
    assert np.abs(rows[:, 1]).max() <= 1.2 + 1e-12
    assert np.abs(rows[:, 2]).max() <= min(a, 1e4) * (1 + 1e-6)
    assert (np.abs(rows[:, 0] - Q).max(axis=0) < np.abs(goal - Q) + 0.01).all()
    # The set-points are of a piece: each speed is the way of its cycle.
    steps = np.diff(rows[:, 0], axis=0)
    means = 0.5 * CYCLE * (rows[1:, 1] + rows[:-1, 1])
    assert np.abs(steps - means).max() < 1e-6


def sine_error(a: float, *numbers: float) -> float:
    """Farthest that 0.5 Hz, 0.3 rad, sent at 250 Hz, is from what is followed [rad]."""
    kp, kd, smooth_vel, smooth_acc = numbers

    def sine(time: float) -> float:
        return 0.3 * math.sin(math.pi * time)

    servo, worst = ServoFollower(FIVE, Q, CYCLE), 0.0
    for cycle in range(4000):
        if cycle % 4 == 0:
            target = Q + np.array([sine(cycle * CYCLE), 0.0, 0.0, 0.0, 0.0, 0.0])
            servo.aim(target, ServoTuning(3.5, a, kp, kd, smooth_vel, smooth_acc))
        point = servo.tick(NONE, NONE)
        if cycle >= 1000:
            worst = max(worst, abs(point.q[0] - Q[0] - sine((cycle + 1) * CYCLE)))
    return worst


@pytest.mark.slow
@pytest.mark.parametrize(("a", "usual", "stiff"), [(3.5, 0.1205, 0.1132), (100.0, 0.0291, 0.0204)])
def test_higher_gains_follow_better(a: float, usual: float, stiff: float) -> None:
    """As the author of a public driver found, who went from 200 and 25 to 400 and 80."""
    assert sine_error(a, 200.0, 25.0, 10.0, 1.0) == pytest.approx(usual, abs=5e-4)
    assert sine_error(a, 400.0, 80.0, 5.0, 1.0) == pytest.approx(stiff, abs=5e-4)


def test_each_joint_goes_for_itself() -> None:
    servo = ServoFollower(FIVE, Q, CYCLE)
    servo.aim(Q + np.array([1.0, 0.1, 0.0, 0.0, 0.0, 0.0]), tuning())
    rows = ran(servo)
    arrived = [int((np.abs(rows[:, 0, j] - rows[-1, 0, j]) > 0.01).sum()) for j in (0, 1)]
    assert arrived[1] < 0.6 * arrived[0]


def test_a_new_target_is_gone_to_from_the_present_speed() -> None:
    servo = ServoFollower(FIVE, Q, CYCLE)
    servo.aim(Q + 1.0, tuning())
    for _ in range(300):
        before = servo.tick(NONE, NONE)
    servo.aim(Q + 0.1, tuning())
    after = servo.tick(NONE, NONE)
    assert before.qd.min() > 0.5
    assert np.abs(after.qd - before.qd).max() <= 5.0 * CYCLE + 1e-12
    assert np.abs(ran(servo)[-1, 0] - (Q + 0.1)).max() < 1e-4


@pytest.mark.slow
def test_more_smoothing_lags_more() -> None:
    def lag(**smoothing: float) -> float:
        servo = ServoFollower(FIVE, Q, CYCLE)
        for i in range(1000):
            servo.aim(Q + 0.5 * i * CYCLE, tuning(**smoothing))
            point = servo.tick(NONE, NONE)
        return float(Q[0] + 0.5 - point.q[0])

    assert lag(smooth_vel=100.0) > lag(smooth_vel=10.0) + 0.03
    assert lag(smooth_acc=1.0) > lag(smooth_acc=0.0) + 0.002
    assert lag(kp=400.0, kd=25.0) < lag(kp=200.0, kd=25.0)


def test_a_stop_and_a_pause_slow_down_at_once() -> None:
    servo = ServoFollower(FIVE, Q, CYCLE)
    servo.aim(Q + 1.0, tuning())
    for _ in range(300):
        servo.tick(NONE, NONE)
    servo.pause()
    speeds = [np.abs(servo.tick(NONE, NONE).qd).max() for _ in range(200)]
    assert (np.diff(speeds) <= 1e-12).all()
    assert speeds[-1] == 0.0
    assert not servo.moving
    assert not servo.ended
    servo.resume()
    for _ in range(200):
        servo.tick(NONE, NONE)
    assert servo.setpoint.qd.min() > 0.3
    servo.stop()
    rows = ran(servo, 200)
    assert (np.diff(np.abs(rows[:, 1]).max(axis=1)) <= 1e-12).all()
    assert np.abs(rows[-1, 0] - (Q + 1.0)).max() > 0.1


@for_each("sign", [1.0, -1.0])
def test_a_joint_at_its_limit_as_it_is_read_in_32_bits_goes_on(sign: float) -> None:
    read = float(np.float32(sign * 2.0 * np.pi))
    servo = ServoFollower(FIVE, np.array([read, *Q[1:]]), CYCLE)
    servo.aim(np.array([sign * 2.0 * np.pi, *Q[1:]]), tuning(v=1.0, a=1.0))
    ran(servo)
    assert servo.failure is None


def test_a_joint_does_not_pass_its_limit() -> None:
    servo = ServoFollower(FIVE, Q, CYCLE)
    servo.aim(np.array([7.0, *Q[1:]]), tuning(v=3.0, a=np.inf))
    rows = ran(servo)
    assert servo.failure is not None
    assert "limit" in str(servo.failure)
    assert rows[:, 0, 0].max() <= 2 * np.pi + 1e-6
