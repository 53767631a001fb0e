from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from aioduco.sim.controller.monitoring import HeartbeatWatchdog


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


@given(st.integers(-(2**31), 2**31 - 1))
def test_any_time_on_the_wire_arms_it_within_what_a_controller_takes(time: int) -> None:
    heartbeat = HeartbeatWatchdog()
    heartbeat.beat(0.0, time)
    assert not heartbeat.lost(0.199)
    assert heartbeat.lost(60.001)
