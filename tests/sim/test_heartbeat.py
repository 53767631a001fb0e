from __future__ import annotations

import math
import time
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aioduco._wire.rpc import Op
from aioduco.models.enums import TaskState
from aioduco.sim.controller.monitoring import HeartbeatWatchdog
from aioduco.sim.simulator import Simulator
from aioduco.testing import eventually

from .raw import RawClient


def test_nothing_is_lost_before_the_first_beat() -> None:
    heartbeat = HeartbeatWatchdog()
    assert not heartbeat.armed
    assert not heartbeat.lost(1e9)


def test_a_beat_puts_the_loss_off_and_the_loss_is_said_once() -> None:
    heartbeat = HeartbeatWatchdog()
    heartbeat.beat(10.0, 1000)
    assert not heartbeat.lost(10.9)
    heartbeat.beat(10.9, 1000)
    assert not heartbeat.lost(11.8)
    assert heartbeat.lost(12.0)
    assert not heartbeat.lost(13.0)
    assert not heartbeat.armed


@pytest.mark.parametrize("slack", [0.0, 0.5])
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


def overdue(sim: Simulator) -> bool:
    due = sim._running().controller.heartbeat._due
    return due is not None and time.monotonic() > due


@given(st.integers(-(2**31), 2**31 - 1))
def test_any_time_on_the_wire_arms_it_within_what_a_controller_takes(time: int) -> None:
    heartbeat = HeartbeatWatchdog()
    heartbeat.beat(0.0, time)
    assert not heartbeat.lost(0.199)
    assert heartbeat.lost(60.001)
