"""The realtime queue and its follower."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from for_each import for_each

from aioduco.models.pose import Pose
from aioduco.sim.planner.realtime_follower import (
    Follow,
    RealtimeCommand,
    RealtimeFollower,
    RealtimeQueue,
)

from .motions import CYCLE, FIVE, HOME

NONE = np.zeros(6)


def follower(queue: RealtimeQueue, what: Follow, **options: Any) -> RealtimeFollower:
    settings: dict[str, Any] = {
        "bandwidth": 100.0,
        "patience": 0.02,
        "tool": np.eye(4),
        "wobj": np.eye(4),
    }
    return RealtimeFollower(FIVE, HOME, CYCLE, queue, what, **(settings | options))


def filled(points: list[RealtimeCommand]) -> RealtimeQueue:
    queue = RealtimeQueue()
    queue.put(points)
    return queue


def run(realtime: RealtimeFollower, cycles: int) -> np.ndarray:
    points = [realtime.tick(NONE, NONE) for _ in range(cycles)]
    return np.array([(point.q, point.qd, point.qdd) for point in points])


def ramp(count: int, rate: float = 0.2) -> list[RealtimeCommand]:
    return [
        RealtimeCommand(joints=tuple(HOME + 0.5 * rate * (i * CYCLE) ** 2 * 5))
        for i in range(count)
    ]


@for_each("bandwidth", [10.0, 100.0])
def test_a_point_is_taken_in_each_cycle_and_followed_with_the_filters_lag(bandwidth: float) -> None:
    queue = filled(ramp(500))
    rows = run(follower(queue, Follow.JOINTS, bandwidth=bandwidth), 400)
    assert len(queue) == 100
    # A low-pass of first order lags by 1 / (2 pi f) on a ramp.
    speed = rows[-1, 1, 0]
    lag = (ramp(400)[-1].joints[0] - rows[-1, 0, 0]) / speed
    assert lag == pytest.approx(1 / (2 * np.pi * bandwidth), rel=0.4)


def test_speeds_of_joints_are_brought_up_by_the_filter_and_go_on() -> None:
    goal = np.array([0.04, 0.0, -0.02, 0.0, 0.0, 0.01])
    queue = filled([RealtimeCommand(joint_speeds=tuple(goal))] * 300)
    rows = run(follower(queue, Follow.JOINT_SPEEDS), 310)
    assert rows[-1, 1] == pytest.approx(goal, rel=1e-3)
    assert rows[-1, 0] - HOME == pytest.approx(goal * 0.31, rel=0.01)


@pytest.mark.slow
def test_a_pose_and_a_twist_move_the_tool_in_the_work_object() -> None:
    wobj = Pose(0.1, 0.2, 0.0, 0.0, 0.0, np.pi / 2).matrix
    tool = Pose(0.0, 0.0, 0.1, 0.0, 0.0, 0.0).matrix
    start = FIVE.fkine(HOME) @ tool
    queue = RealtimeQueue()
    inside = np.linalg.inv(wobj) @ start
    for i in range(400):
        pose = inside.copy()
        pose[0, 3] += 0.05 * (i * CYCLE) ** 2
        queue.put([RealtimeCommand(pose=pose)])
    realtime = follower(queue, Follow.POSE, wobj=wobj, tool=tool)
    run(realtime, 400)
    moved = (FIVE.fkine(realtime.setpoint.q) @ tool)[:3, 3] - start[:3, 3]
    assert moved == pytest.approx([0.0, 0.05 * 0.398**2, 0.0], abs=2e-4)

    queue.put([RealtimeCommand(twist=(0.04, 0.0, 0.0, 0.0, 0.0, 0.0))] * 500)
    realtime = follower(queue, Follow.TWIST, wobj=wobj, tool=tool)
    run(realtime, 500)
    moved = (FIVE.fkine(realtime.setpoint.q) @ tool)[:3, 3] - start[:3, 3]
    assert moved == pytest.approx([0.0, 0.04 * 0.4985, 0.0], abs=1e-4)


@for_each(
    "what, command",
    [
        (Follow.JOINTS, RealtimeCommand(joints=tuple(HOME + 0.01))),
        (Follow.JOINT_SPEEDS, RealtimeCommand(joint_speeds=(0.2,) * 6)),
        (Follow.POSE, RealtimeCommand(pose=FIVE.fkine(HOME + 0.01))),
        (Follow.TWIST, RealtimeCommand(twist=(0.2,) * 6)),
    ],
)
def test_the_first_point_has_to_be_where_the_arm_is(what: Follow, command: RealtimeCommand) -> None:
    realtime = follower(filled([command]), what)
    run(realtime, 1)
    assert realtime.failure is not None
    assert realtime.failure.kind == "fault"
    assert "first point" in str(realtime.failure)
    assert (realtime.setpoint.q == HOME).all()


def test_a_starved_queue_is_a_fault_and_the_arm_slows_down() -> None:
    queue = filled([RealtimeCommand(joint_speeds=(0.04, 0, 0, 0, 0, 0))] * 100)
    realtime = follower(queue, Follow.JOINT_SPEEDS, patience=0.04)
    rows = run(realtime, 140)
    assert realtime.failure is None
    assert rows[-1, 1, 0] == pytest.approx(0.04, rel=1e-3)  # it went on as told last
    run(realtime, 1)
    assert "no data" in str(realtime.failure)
    run(realtime, 50)
    assert realtime.ended


def test_a_point_that_comes_in_time_puts_the_fault_off() -> None:
    queue = RealtimeQueue()
    realtime = follower(queue, Follow.JOINTS)
    for _ in range(10):
        queue.put([RealtimeCommand(joints=tuple(HOME))])
        run(realtime, 20)
    assert realtime.failure is None


def test_a_jump_of_the_points_is_a_fault() -> None:
    points = [RealtimeCommand(joints=tuple(q)) for q in (HOME, HOME + 0.5)]
    realtime = follower(filled(points), Follow.JOINTS)
    run(realtime, 2)
    assert realtime.failure is not None
    assert "faster" in str(realtime.failure)
    assert (realtime.setpoint.q == HOME).all()
