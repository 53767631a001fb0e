"""Settings of streams: checked, passed on, and granted or not."""

from __future__ import annotations

import itertools
import math
import os
from typing import Any

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.api.streams.arguments import ServoGains
from aioduco.api.streams.realtime import RealtimeStreams
from aioduco.api.streams.servo import Servo
from aioduco.errors import ParameterError
from aioduco.streaming.shared.config import WorkerConfig
from aioduco.streaming.shared.histogram import Histogram
from aioduco.streaming.shared.options import Feeding, WorkerOptions

from .conftest import HERE, Controller


def test_a_rate_that_upsampling_needs_names_the_other_way() -> None:
    with pytest.raises(ParameterError, match=r"source_rate is None, .*upsample='cubic'.*latest"):
        Servo(Controller.nowhere()).joints(v=1.0, a=5.0, upsample="cubic")


@for_each(
    "changed, name",
    [
        ({"v": 4.0}, "v"),
        ({"v": 0.0}, "v"),
        ({"rate": 0.0}, "rate"),
        ({"rate": 1e6}, "rate"),
        ({"source_rate": 600.0}, "source_rate"),
        ({"upsample": "cubic"}, "source_rate"),
        ({"hold": 0.0}, "hold"),
        ({"ahead": 0}, "ahead"),
        ({"reach": 0.0}, "reach"),
        ({"gains": ServoGains(smooth_vel=0.5)}, "smooth_vel"),
        ({"gains": ServoGains(kp=-1.0)}, "kp"),
    ],
)
def test_what_is_not_allowed_is_refused_before_anything_is_sent(
    changed: dict[str, Any], name: str
) -> None:
    arguments: dict[str, Any] = {"v": 1.0, "a": 5.0, **changed}
    with pytest.raises(ParameterError) as caught:
        Servo(Controller.nowhere()).joints(**arguments)
    assert caught.value.parameter == name


@for_each(
    "options",
    [
        {"run_in": "fiber"},
        {"priority": 100},
        {"spin": -1.0},
        {"timeout": math.inf},
        {"cpus": 3},
        {"cpus": "3"},
        {"cpus": (-1,)},
    ],
)
def test_impossible_options_are_refused(options: dict[str, Any]) -> None:
    with pytest.raises(ParameterError):
        WorkerOptions(**options)


def test_options_of_other_types_reach_the_worker_as_plain_numbers() -> None:
    """They are stored as JSON: what is taken and not stored plainly fails only on entering."""
    ways: Any = {"latest": np.False_, "chunks": np.False_, "ahead": np.int64(20), "rate": 100}
    options: Any = {"cpus": range(2), "priority": np.int64(5), "spin": np.float32(0.5)}
    made = [
        Servo(Controller.nowhere()).joints(
            v=1.0, a=5.0, options=WorkerOptions(**options | {"cpus": cpus}), **ways
        )
        for cpus in (range(2), np.array([0, 1]))
    ]
    streams = RealtimeStreams(Controller.nowhere())
    period: Any = np.float32(0.004)
    made.append(streams.stream("joint_position", v=1.0, a=5.0, period=period))
    for stream in made:
        config = stream._session._config
        assert WorkerConfig.unpack(config.pack()).pack() == config.pack()
    assert made[1]._session._config.options == WorkerOptions(cpus=(0, 1), priority=5, spin=0.5)


def test_a_ring_holds_four_seconds_or_only_the_newest() -> None:
    assert Feeding(rate=500.0).capacity == 2000
    assert Feeding(rate=500.0, latest=True).capacity == 8
    assert Feeding(rate=500.0, source_rate=30.0, upsample="cubic").capacity == 256


@pytest.mark.slow
@pytest.mark.parametrize("run_in", ["thread", "process"])
async def test_what_the_system_does_not_allow_is_said_and_the_stream_runs(
    controller: Controller, run_in: Any
) -> None:
    # No machine has this processor.
    options = WorkerOptions(run_in=run_in, cpus=(4095,), priority=1)
    async with controller.servo.joints(v=1.0, a=5.0, options=options) as stream:
        await stream.send(HERE)
    assert "cpus" in stream.statistics().unmet
    assert controller.points()[-1] == HERE


@pytest.mark.slow
@pytest.mark.linux("keeping a process on a processor")
async def test_a_worker_stays_on_its_processor(controller: Controller) -> None:
    processor = min(os.sched_getaffinity(0))
    options = WorkerOptions(cpus=(processor,))
    async with controller.servo.joints(v=1.0, a=5.0, options=options) as stream:
        assert stream.pid is not None
        assert os.sched_getaffinity(stream.pid) == {processor}
    assert "cpus" not in stream.statistics().unmet


@pytest.mark.cases(1)
@pytest.mark.parametrize("run_in", ["thread", "process"])
async def test_a_worker_that_is_always_late_loses_no_set_point(
    controller: Controller, run_in: Any
) -> None:
    """At a rate that nothing can hold the next set-point is reckoned ahead of its tick."""
    points = [[angle + 1e-6 * n for angle in HERE] for n in range(500)]
    stream = controller.servo.joints(
        v=3.0, a=1e6, rate=50_000.0, ahead=1000, options=WorkerOptions(run_in=run_in)
    )
    async with stream:
        await stream.play(points)
    arrived = controller.points()
    assert [point for point in points if point not in arrived] == []
    assert sorted(arrived) == arrived
    assert stream.statistics().missed > 0


VALUES = st.lists(st.integers(0, 2**41), min_size=1, max_size=300)


def rank(values: list[int], fraction: float) -> int:
    ordered = sorted(values)
    return ordered[max(1, math.ceil(fraction * len(ordered))) - 1]


@given(VALUES)
def test_a_percentile_is_never_flattering_and_at_most_a_32nd_above(values: list[int]) -> None:
    histogram = Histogram()
    for value in values:
        histogram.record(value)
    found = histogram.snapshot(scale=1)
    assert found.samples == len(values)
    assert found.max == max(values)
    assert math.isclose(found.mean, sum(values) / len(values))
    for percentile, fraction in ((found.p50, 0.5), (found.p99, 0.99), (found.p999, 0.999)):
        true = rank(values, fraction)
        assert true <= percentile <= true * (1 + 1 / 32)


@given(VALUES)
def test_each_value_lies_in_one_bucket(values: list[int]) -> None:
    histogram = Histogram()
    for value in values:
        histogram.record(value)
    buckets = histogram.buckets()
    assert sum(count for _, _, count in buckets) == len(values)
    assert all(high <= low2 for (_, high, _), (low2, _, _) in itertools.pairwise(buckets))
    for value in values:
        assert any(low <= value < high for low, high, _ in buckets)


def test_nothing_recorded_is_all_zero() -> None:
    assert set(Histogram().snapshot()) == {0}


def test_negative_counts_as_zero_and_very_long_as_the_longest() -> None:
    histogram = Histogram()
    histogram.record(-5)
    histogram.record(2**60)
    found = histogram.snapshot(scale=1)
    assert found.samples == 2
    assert found.p50 == 0
    assert 2**41 < found.max < 2**42


def test_another_reader_of_the_memory_sees_it_live() -> None:
    memory = memoryview(bytearray(8 * Histogram.WORDS))
    writer, reader = Histogram(memory.cast("Q")), Histogram(memory.cast("Q"))
    writer.record(1000)
    assert reader.snapshot(scale=1).samples == 1
