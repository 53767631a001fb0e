"""What all followers have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from aioduco.models.rotation import Array
from aioduco.sim.planner.realtime_follower import (
    Follow,
    RealtimeCommand,
    RealtimeFollower,
    RealtimeQueue,
)
from aioduco.sim.planner.servo_follower import ServoFollower, ServoTuning
from aioduco.sim.planner.velocity_follower import JointVelocity, ToolVelocity

from .motions import CYCLE, FIVE, HOME

NONE = np.zeros(6)
TURN = np.array([0.5, 0.0, 0.0, 0.0, 0.0, 0.0])


def joint_velocity() -> JointVelocity:
    follower = JointVelocity(FIVE, HOME, CYCLE)
    follower.aim(TURN, 5.0)
    return follower


def tool_velocity() -> ToolVelocity:
    follower = ToolVelocity(FIVE, HOME, CYCLE, np.eye(4))
    follower.aim(0.4 * TURN, 5.0)
    return follower


def servo() -> ServoFollower:
    follower = ServoFollower(FIVE, HOME, CYCLE)
    follower.aim(HOME + TURN, ServoTuning(1.0, 5.0, 200.0, 25.0, 10.0, 1.0))
    return follower


def realtime() -> RealtimeFollower:
    queue = RealtimeQueue()
    # After the pause they begin again as for an arm that stands.
    speeds = [0.04 + 0.002 * i for part in (100, 200) for i in range(part)]
    queue.put(RealtimeCommand(joint_speeds=(speed, 0.0, 0.0, 0.0, 0.0, 0.0)) for speed in speeds)
    options: Any = {"bandwidth": 100.0, "patience": 1.0, "tool": np.eye(4), "wobj": np.eye(4)}
    return RealtimeFollower(FIVE, HOME, CYCLE, queue, Follow.JOINT_SPEEDS, **options)


@pytest.mark.cases(4)
@pytest.mark.parametrize("made", [joint_velocity, tool_velocity, servo, realtime])
def test_what_is_resumed_before_it_stands_keeps_to_its_accelerations(
    made: Callable[[], Any],
) -> None:
    follower = made()

    def run(cycles: int) -> list[np.ndarray]:
        return [follower.tick(NONE, NONE).qd for _ in range(cycles)]

    speeds = run(100)
    follower.pause()
    speeds += run(3)
    assert np.abs(speeds[-1]).max() > 0.1
    follower.resume()
    speeds += run(150)
    assert follower.failure is None
    assert np.abs(speeds[-1]).max() > 0.1
    assert np.abs(np.diff(speeds, axis=0)).max() < CYCLE * max(FIVE.acceleration)


@pytest.mark.parametrize(
    ("follower", "velocity"),
    [
        (JointVelocity(FIVE, HOME, CYCLE), 2.0 * TURN),
        (ToolVelocity(FIVE, HOME, CYCLE, np.eye(4)), np.array([0.2, 0.1, 0.1, 0.5, -0.4, 0.3])),
    ],
)
def test_velocities_change_no_faster_than_the_drives_can(follower: Any, velocity: Array) -> None:
    follower.aim(velocity, 1000.0)
    speeds = [follower.tick(NONE, NONE).qd for _ in range(100)]
    follower.finish()
    while not follower.ended:
        speeds.append(follower.tick(NONE, NONE).qd)
    assert follower.failure is None
    changes = np.abs(np.diff(speeds, axis=0)).max(axis=1)
    assert changes.max() == pytest.approx(CYCLE * max(FIVE.acceleration))
    assert len(speeds) < 160


@pytest.mark.parametrize(
    "follower", [JointVelocity(FIVE, HOME, CYCLE), ToolVelocity(FIVE, HOME, CYCLE, np.eye(4))]
)
def test_a_velocity_goes_as_far_as_its_speed_and_time_say(follower: Any) -> None:
    """The way of the ramp at the end is the way that the ramp at the beginning lacks."""
    turn = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.3])  # of the flange, which is joint 6
    follower.aim(turn, 2.0, 0.5)
    while not follower.ended:
        follower.tick(NONE, NONE)
    np.testing.assert_allclose(follower.setpoint.q - HOME, 0.5 * turn, atol=1e-9)
