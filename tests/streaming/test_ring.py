"""The ring between two processes: order, and no set-point that is half of two."""

from __future__ import annotations

import mmap
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.streaming.shared.ring import Ring, SetPoint

PRODUCER = """
import mmap, os, sys, time
from aioduco.streaming.shared.ring import Ring

descriptor, capacity, count, latest = map(int, sys.argv[1:])
memory = mmap.mmap(descriptor, os.fstat(descriptor).st_size)
ring = Ring(memoryview(memory), capacity)
for number in range(1, count + 1):
    values = [number * 1.5 + axis for axis in range(6)]
    if latest:
        ring.overwrite(values, number)
    else:
        while not ring.put(values, number):
            os.sched_yield()
"""


def make(capacity: int, extra: int = 0) -> Ring:
    return Ring(memoryview(bytearray(Ring.size(capacity, extra))), capacity, extra)


def whole(stamp: int, values: tuple[float, ...]) -> bool:
    return values == tuple(stamp * 1.5 + axis for axis in range(6))


@given(st.lists(st.booleans(), max_size=200), st.integers(1, 8))
def test_first_in_first_out_and_never_more_than_fit(steps: list[bool], capacity: int) -> None:
    ring = make(capacity)
    model: list[int] = []
    written = read = 0
    for put in steps:
        if put:
            accepted = ring.put([float(written)] * 6, written)
            assert accepted == (len(model) < capacity)
            if accepted:
                model.append(written)
            written += 1
        else:
            point = ring.take()
            read += bool(model)
            assert (point.stamp if point else None) == (model.pop(0) if model else None)
        assert (ring.level, ring.read) == (len(model), read)


@given(st.lists(st.integers(0, 20), max_size=30), st.integers(2, 8))
def test_latest_is_the_last_written_and_counts_the_others(bursts: list[int], capacity: int) -> None:
    ring = make(capacity)
    number = seen = 0
    for burst in bursts:
        for _ in range(burst):
            number += 1
            ring.overwrite([float(number)] * 6, number)
        point = ring.newest()
        assert (point.stamp if point else None) == (number if burst else None)
        seen += point is not None
    assert ring.overwritten == number - seen


def test_what_goes_with_a_point_comes_out_again() -> None:
    ring = make(4, extra=100)
    texts = [b"", b"one", bytes(range(100))]
    for text in texts:
        ring.put([0.0] * 6, 0, text)
    taken = [ring.take() for _ in texts]
    assert [point.extra for point in taken if point] == texts
    with pytest.raises(ValueError, match="101 bytes go with the point; 100 fit"):
        ring.put([0.0] * 6, 0, bytes(101))


@given(st.integers(0, 71), st.integers(1, 255))
def test_a_slot_with_a_wrong_byte_is_not_there(place: int, flip: int) -> None:
    memory = bytearray(Ring.size(1))
    ring = Ring(memoryview(memory), 1)
    ring.put([1.0] * 6, 7)
    memory[16 + place] ^= flip
    assert ring.take() is None
    memory[16 + place] ^= flip
    assert ring.take() is not None


def test_a_counter_ahead_of_its_slot_is_harmless() -> None:
    memory = bytearray(Ring.size(4))
    words = memoryview(memory)[:8].cast("Q")
    ring = Ring(memoryview(memory), 4)
    ring.put([1.0] * 6, 1)
    words[0] = 2  # as if the counter of the second were visible before its bytes
    first, second = ring.take(), ring.take()
    assert first is not None
    assert second is None


def test_a_slot_that_still_has_the_point_of_a_round_before_is_not_the_next_one() -> None:
    memory = bytearray(Ring.size(1))
    ring = Ring(memoryview(memory), 1)
    ring.put([1.0] * 6, 1)
    assert ring.take() is not None
    memoryview(memory)[:8].cast("Q")[0] = 2
    assert ring.take() is None


def test_a_slot_that_has_a_newer_point_already_is_not_the_older_one() -> None:
    memory = bytearray(Ring.size(2))
    ring = Ring(memoryview(memory), 2)
    for number in range(1, 4):
        ring.overwrite([float(number)] * 6, number)
    memoryview(memory)[:8].cast("Q")[0] = 1  # as if the bytes were visible before the counter
    assert ring.newest() is None
    assert ring.level == 1


def test_a_counter_of_reads_ahead_of_that_of_writes_is_an_empty_ring() -> None:
    memory = bytearray(Ring.size(2))
    ring = Ring(memoryview(memory), 2)
    memoryview(memory)[8:16].cast("Q")[0] = 1
    assert ring.level == 0


@for_each("extra", range(17))
def test_a_ring_takes_no_more_room_than_its_points(extra: int) -> None:
    slot = Ring.size(4, extra) - Ring.size(3, extra)
    assert slot % 8 == 0  # the numbers in a slot are aligned
    assert 0 <= slot - (80 + extra) < 8
    assert Ring.size(3, extra) == 16 + 3 * slot


@contextmanager
def hammered(
    capacity: int, count: int, *, latest: bool
) -> Iterator[tuple[Ring, subprocess.Popen[bytes]]]:
    """A ring, and a process that puts so many points into it as fast as it can."""
    descriptor = os.memfd_create("test-ring")
    size = Ring.size(capacity)
    os.ftruncate(descriptor, size)
    ring = Ring(memoryview(mmap.mmap(descriptor, size)), capacity)
    numbers = map(str, (descriptor, capacity, count, int(latest)))
    command = [sys.executable, "-c", PRODUCER, *numbers]
    with subprocess.Popen(command, pass_fds=(descriptor,)) as producer:
        os.close(descriptor)
        try:
            yield ring, producer
        finally:
            producer.kill()


def awaited(take: Callable[[], SetPoint | None]) -> SetPoint:
    """The next point, however long the producer waits for a processor."""
    deadline = time.monotonic() + 60
    while (point := take()) is None:
        assert time.monotonic() < deadline
        os.sched_yield()
    return point


@pytest.mark.cases(1)
@pytest.mark.parametrize(("capacity", "count"), [(1, 3_000), (2, 3_000), (7, 10_000), (64, 30_000)])
def test_a_hammering_producer_loses_nothing_and_tears_nothing(capacity: int, count: int) -> None:
    with hammered(capacity, count, latest=False) as (ring, producer):
        for expected in range(1, count + 1):
            point = awaited(ring.take)
            assert point.stamp == expected
            assert whole(point.stamp, point.values)
        assert producer.wait(60) == 0
    assert ring.take() is None


@pytest.mark.slow
def test_a_hammering_producer_of_latest_never_goes_back_and_tears_nothing() -> None:
    count = 100_000
    last = seen = 0
    with hammered(4, count, latest=True) as (ring, producer):
        while last < count:
            point = awaited(ring.newest)
            assert point.stamp > last
            assert whole(point.stamp, point.values)
            last = point.stamp
            seen += 1
        assert producer.wait(60) == 0
    assert ring.overwritten == count - seen
