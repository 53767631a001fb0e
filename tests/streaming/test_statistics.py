"""Histograms of fixed size."""

from __future__ import annotations

import itertools
import math

from hypothesis import given
from hypothesis import strategies as st

from aioduco.streaming.shared.histogram import Histogram

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
