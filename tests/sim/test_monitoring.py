"""The limits that the controller checks each cycle: quick checks agree with complete ones."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco._wire.rpc import Op
from aioduco.kinematics import arm
from aioduco.kinematics.forward import frames
from aioduco.models.enums import OperationMode, TaskState
from aioduco.sim.controller.monitoring import (
    LEVELS,
    CollisionDetector,
    HeartbeatWatchdog,
    Standstill,
)
from aioduco.sim.controller.state_machine import DEVIATION, _deviation
from aioduco.sim.cycle import SensedState
from aioduco.sim.simulator import Simulator
from aioduco.testing import eventually

from .fakes import Bench, leg
from .raw import RawClient

SIX = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6).map(np.array)
SCALE = st.sampled_from([1e-3, 2e-3, 5e-3, 0.05, 0.1, 0.2, 0.3, 1.0, 50.0])
EFFORT = np.array([100.0, 80.0, 60.0, 20.0, 15.0, 10.0])


@given(direction=SIX, scale=SCALE)
def test_whether_the_arm_turns_is_told_by_its_fastest_joint(
    direction: np.ndarray, scale: float
) -> None:
    speeds, none = direction * scale, np.zeros(6)
    watch = Standstill()
    still = watch.tick(SensedState(1.0, 0.0, none, speeds, none, none), commanded=True)
    fastest = np.abs(speeds).max()
    assert watch.turning == (fastest > 0.1)
    assert still == (fastest <= 2e-3)


@given(direction=SIX, scale=SCALE, level=st.sampled_from([1, 2, 3, 4, 5]))
def test_a_collision_is_at_the_joint_with_the_largest_share(
    direction: np.ndarray, scale: float, level: int
) -> None:
    watch = CollisionDetector(EFFORT)
    watch.level = level
    watch.update(0.0, np.zeros(6))
    found = watch.update(1e6, direction * scale)  # so late that nothing of before is left
    shares = np.abs(watch.torque) / EFFORT
    assert found == (int(shares.argmax()) + 1 if shares.max() > LEVELS[level] else 0)


@given(direction=SIX, scale=SCALE)
def test_a_deviation_is_that_of_one_joint(direction: np.ndarray, scale: float) -> None:
    away = direction * scale
    told = _deviation(away, np.zeros(6))
    if np.abs(away).max() > DEVIATION:
        assert told == f"joint {int(np.abs(away).argmax()) + 1}: position deviation"
    else:
        assert told == ""


def test_a_deviation_that_is_no_number_is_one() -> None:
    q = np.zeros(6)
    q[3] = np.nan
    assert _deviation(q, np.zeros(6)) == "joint 4: position deviation"


def test_frames_of_one_configuration_are_those_of_many() -> None:
    geometry = arm("gcr5_910").geometry
    many = np.random.default_rng(1).uniform(-6.0, 6.0, (50, 6))
    each = np.array([frames(geometry, q) for q in many])
    np.testing.assert_allclose(each, frames(geometry, many), atol=1e-15)


def test_a_view_is_the_same_while_nothing_changes_and_a_new_one_when_something_does() -> None:
    bench = Bench().enabled()
    controller = bench.controller
    bench.tick(600)  # until it counts as standing
    before = controller.view()
    bench.tick(5)
    assert controller.view() is before

    controller.set_speed(40.0)
    assert controller.view().speed == 40.0
    controller.note_error("strange")
    assert controller.view().errors == ("strange",)
    controller.switch_mode(OperationMode.MANUAL)
    assert controller.view().mode is OperationMode.MANUAL
    controller.switch_mode(OperationMode.AUTO)
    assert before.speed == 100.0
    assert before.errors == ()

    id_ = controller.move("movej2", leg(0.1))
    moving = controller.view()
    assert moving.moving
    assert not moving.standing
    assert bench.ended(id_) == 4
    bench.tick(600)
    assert controller.view()._replace(speed=100.0, errors=()) == before

    controller.press_emergency_stop()
    pressed = controller.view()
    assert pressed.emergency_stop
    assert pressed.error == 1


@for_each("slack", [0.0, 0.5])
def test_a_beat_may_come_after_its_time_by_the_slack(slack: float) -> None:
    heartbeat = HeartbeatWatchdog()
    heartbeat.slack = slack
    assert heartbeat.beat(0.0, 1000) == 0.0
    assert not heartbeat.lost(1.0 + slack)
    assert heartbeat.beat(1.0 + slack, 1000) == pytest.approx(slack)
    assert not heartbeat.lost(2.0 + 2 * slack)
    assert heartbeat.lost(2.001 + 2 * slack)
    assert heartbeat.beat(4.0, 1000) == 0.0  # it was lost already: this one arms it again


def test_a_beat_without_a_time_agrees_on_a_second() -> None:
    heartbeat = HeartbeatWatchdog()
    heartbeat.beat(0.0, 0)
    assert heartbeat.time == 1000
    assert not heartbeat.lost(0.999)
    assert heartbeat.lost(1.001)


@pytest.mark.parametrize(
    ("options", "slack"),
    [({}, 0.5), ({"strict": True}, 0.0), ({"heartbeat_slack": 2.0, "strict": True}, 2.0)],
)
def test_the_slack_of_a_simulator(options: dict[str, Any], slack: float) -> None:
    with Simulator(**options) as sim:
        assert sim._running().controller.heartbeat.slack == slack


@pytest.mark.slow
def test_a_program_that_beats_once_a_second_keeps_its_arm_moving() -> None:
    """As the vendor's own demo does: rpc_heartbeat(); sleep(1), so each beat is a little late."""
    with Simulator(speed=math.inf, heartbeat_slack=30.0) as sim, RawClient(sim.port) as robot:
        for name in ("power_on", "enable"):
            assert robot.call(name, True) == TaskState.FINISHED
        robot.call("rpc_heartbeat", 200)
        # The wait is what a late beat is made of: the machine's own lateness only adds to it.
        eventually(lambda: overdue(sim))
        assert robot.call("movej2", [0.5] * 6, 1.0, 2.0, 0.0, True, Op(), False) == 4
        robot.call("rpc_heartbeat", 200)
        assert sim.forgiven == {"late heartbeat": 1}


@pytest.mark.slow
def test_a_beat_of_any_connection_counts_for_all() -> None:
    with (
        Simulator(heartbeat_slack=0.0) as sim,
        RawClient(sim.port) as first,
        RawClient(sim.port) as second,
    ):
        for name in ("power_on", "enable"):
            assert first.call(name, True) == TaskState.FINISHED
        first.call("rpc_heartbeat", 200)
        over = time.monotonic() + 0.2
        second.call("rpc_heartbeat", 60_000)
        id_ = first.call("speedj", [0.01, *[0.0] * 5], 1.0, -1, False)
        # The wait is the time of the first connection's beat: after it, only the second's counts.
        eventually(lambda: time.monotonic() > over)
        cycle = sim.time
        eventually(lambda: sim.time > cycle + 0.01)
        assert first.call("get_noneblock_taskstate", id_) == TaskState.RUNNING
        second.call("rpc_heartbeat", 200)  # as short as this for the first connection, too
        eventually(lambda: first.call("get_noneblock_taskstate", id_) == TaskState.STOPPED)
        assert "heartbeat lost" in first.call("get_last_error")[-1]


def overdue(sim: Simulator) -> bool:
    due = sim._running().controller.heartbeat._due
    return due is not None and time.monotonic() > due


@given(st.integers(-(2**31), 2**31 - 1))
def test_any_time_on_the_wire_arms_it_within_what_a_controller_takes(time: int) -> None:
    heartbeat = HeartbeatWatchdog()
    heartbeat.beat(0.0, time)
    assert not heartbeat.lost(0.199)
    assert heartbeat.lost(60.001)
