"""Times of power, updates of readings, precision and the heartbeat's slack."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from for_each import for_each

from aioduco.models.enums import RobotState
from aioduco.sim.calibration.evidence import Motions, Reads, StateRead, TimedCall
from aioduco.sim.calibration.times import (
    estimate_period,
    estimate_slack,
    estimate_times,
    single_precision,
)

from .made import READY, changes, empty


def test_times_of_power_are_within_five_percent_and_their_intervals(thorough: bool) -> None:
    inside = []
    for seed in range(20 if thorough else 4):
        random = np.random.default_rng(seed)
        spans = {"power_on": (0.3, 1.5), "enable": (0.2, 1), "disable": (0.1, 0.4)}
        times = {name: random.uniform(*span) for name, span in spans.items()}
        times["power_off"] = random.uniform(0.1, 0.5)
        calls, states = changes(random, times)
        found = estimate_times([replace(empty(), calls=calls, states=states)])
        for name, estimate in found.values.items():
            assert estimate.value == pytest.approx(times[name], rel=0.05)
            inside.append(estimate.low <= times[name] <= estimate.high)
    assert len(inside) >= (76 if thorough else 12)
    assert np.mean(inside) >= (0.95 if thorough else 0.9)


def test_changes_that_were_not_watched_are_left_out() -> None:
    random = np.random.default_rng(1)
    times = dict.fromkeys(("power_on", "enable", "disable", "power_off"), 0.3)
    calls, states = changes(random, times)
    coarse = states[::40]
    found = estimate_times([replace(empty(), calls=calls, states=coarse)])
    assert found.values == {}
    assert any("more reads of the state" in text for text in found.missing)
    nothing = estimate_times([replace(empty(), calls=calls)])
    assert "times, power_on: no such change was recorded with its states" in nothing.missing


def test_a_change_to_a_state_that_is_there_already_says_nothing() -> None:
    call = TimedCall("enable", 1.0, 1.001)
    states = tuple(StateRead(t, t + 0.001, RobotState.ENABLE) for t in (1.002, 1.005))
    assert estimate_times([replace(empty(), calls=(call,), states=states)]).values == {}


def moving_reads(period: float, interval: float, *, seconds: float = 6.0) -> Reads:
    """Reads of joints that move, updated every `period` [s]."""
    random = np.random.default_rng(2)
    begin = np.cumsum(random.uniform(0.8, 1.2, int(seconds / interval)) * interval)
    end = begin + 0.3 * interval
    answered = begin + 0.15 * interval
    slot = np.floor((answered + 0.0017) / period) * period if period else answered
    values = READY + 0.1 * slot[:, None]
    return Reads(begin, end, values)


@pytest.mark.slow
@pytest.mark.parametrize("period", [0.008, 0.0123, 0.02])
def test_the_period_of_readings_is_found(period: float) -> None:
    found = estimate_period([moving_reads(period, 0.003)])
    assert found.values["period"].value == pytest.approx(period, rel=0.005)
    low, high = found.values["period"][1:]
    assert low <= period <= high


@for_each("period", [0.0, 0.003])
def test_a_period_shorter_than_the_reads_is_not_claimed(period: float) -> None:
    found = estimate_period([moving_reads(period, 0.003)])
    assert found.values == {}
    assert "none above twice the 3.0 ms" in found.missing[0]


def test_reads_of_a_standing_arm_show_no_period() -> None:
    reads = moving_reads(0.01, 0.003)
    found = estimate_period([reads._replace(values=np.tile(READY, (len(reads.begin), 1)))])
    assert found.values == {}
    assert "too few reads" in found.missing[0]


def test_single_precision_is_seen() -> None:
    reads = moving_reads(0.0, 0.003)
    assert single_precision([reads]) is False
    single = reads.values.astype(np.float32).astype(float)
    assert single_precision([reads._replace(values=single)]) is True
    assert single_precision([]) is None


def lapse(slack: float) -> Motions:
    """A motion at 0.2 rad/s that a heartbeat's end stops: beats came up to 5 s, for 1 s each."""
    time = np.arange(0.0, 12.0, 0.008)
    stop = 5.0 + 1.0 + slack
    speed = np.where(time < stop, 0.2, np.maximum(0.2 - 2.0 * (time - stop), 0.0))
    speeds = np.zeros((len(time), 6))
    speeds[:, 5] = np.round(speed * 1024) / 1024
    places = READY + np.cumsum(speeds, axis=0) * 0.008
    return Motions(time, places, speeds, places, speeds)


def beats_until(end: float) -> tuple[tuple[TimedCall, float], ...]:
    times = (*np.arange(0.0, end, 0.3), end)
    return tuple((TimedCall("rpc_heartbeat", t, t + 0.001), 1.0) for t in times)


@for_each("slack", [0.0, 0.5, 1.3])
def test_the_slack_of_a_heartbeat_that_lapsed_is_found(slack: float) -> None:
    found = estimate_slack([replace(empty(), motions=lapse(slack), beats=beats_until(5.0))])
    value, low, high = found.values["slack"]
    assert low <= slack <= high
    assert value == pytest.approx(slack, abs=0.02)


def test_a_heartbeat_that_never_lapsed_shows_no_slack() -> None:
    found = estimate_slack([replace(empty(), motions=lapse(0.5), beats=beats_until(12.0))])
    assert found.values == {}
    assert found.missing == ("heartbeat, slack: no heartbeat lapsed in mid motion",)
