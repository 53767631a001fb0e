"""Histograms of fixed size that one process writes and another one reads while it does."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["Histogram", "Percentiles"]

_BITS = 5
_SUB = 1 << _BITS  # buckets per octave: a percentile is at most 1/32 above the true value
_LARGEST = (1 << 42) - 1  # 73 minutes in nanoseconds; anything longer counts as this
_COUNT = ((42 - _BITS - 1) << _BITS) + 2 * _SUB
_TOTAL, _MAX, _HEAD = 0, 1, 2


class Percentiles(NamedTuple):
    """What a histogram says at one moment. Times are in seconds, depths in points.

    Attributes:
        samples: how many values were recorded.
        mean: their mean.
        p50: the median.
        p99: the value that 99 % do not exceed.
        p999: the value that 99.9 % do not exceed.
        max: the largest.
    """

    samples: int
    mean: float
    p50: float
    p99: float
    p999: float
    max: float


class Histogram:
    """A histogram with logarithmic buckets, 3 % wide, over whole numbers (nanoseconds).

    Its words are 64 bits wide and written one at a time by one writer, so that another process
    can read them meanwhile: what it sees may be one value behind, never torn. The count is the
    sum of the buckets and not a word of its own, so a percentile never refers to a value that
    is not there yet.

    Args:
        words: where to count: `Histogram.WORDS` words of unsigned 64 bits, all zero at first.
    """

    WORDS = _HEAD + _COUNT

    __slots__ = ("_words",)

    def __init__(self, words: memoryview | None = None) -> None:
        self._words = memoryview(bytearray(8 * self.WORDS)).cast("Q") if words is None else words

    def record(self, value: int) -> None:
        """Count one value; below zero counts as zero."""
        words = self._words
        if value < 0:
            value = 0
        elif value > _LARGEST:
            value = _LARGEST
        shift = value.bit_length() - _BITS - 1
        if shift > 0:
            words[_HEAD + (shift << _BITS) + (value >> shift)] += 1
        else:
            words[_HEAD + value] += 1
        words[_TOTAL] += value
        words[_MAX] = max(words[_MAX], value)

    def close(self) -> None:
        """Let go of the memory; nothing else may be called after that."""
        self._words.release()

    def buckets(self) -> list[tuple[int, int, int]]:
        """Every bucket that is not empty: its lowest value, the next one's, and its count."""
        return [(*_edges(i), n) for i, n in enumerate(self._words[_HEAD:].tolist()) if n]

    def snapshot(self, scale: float = 1e-9) -> Percentiles:
        """Read the percentiles as they are now.

        Args:
            scale: what one counted unit is worth: 1e-9 for nanoseconds read as seconds.

        Returns:
            The percentiles; all zero when nothing was recorded. A percentile is the upper edge
            of its bucket, so it is never flattering, and never above the maximum.
        """
        counts = self._words[_HEAD:].tolist()
        total, largest = self._words[_TOTAL], self._words[_MAX]
        count = sum(counts)
        if not count:
            return Percentiles(0, 0.0, 0.0, 0.0, 0.0, 0.0)
        edges = _percentiles(counts, count, (0.5, 0.99, 0.999))
        p50, p99, p999 = (min(edge, largest) * scale for edge in edges)
        return Percentiles(count, total / count * scale, p50, p99, p999, largest * scale)


def _edges(index: int) -> tuple[int, int]:
    """The lowest value of a bucket, and of the next."""
    shift = max((index >> _BITS) - 1, 0)
    low = (index - (shift << _BITS)) << shift
    return low, low + (1 << shift)


def _percentiles(counts: list[int], count: int, fractions: Iterable[float]) -> list[int]:
    """The largest value of the bucket that holds each fraction, fractions rising."""
    found: list[int] = []
    seen, index = 0, -1
    for fraction in fractions:
        rank = max(1, -int(-fraction * count // 1))
        while seen < rank:
            index += 1
            seen += counts[index]
        found.append(_edges(index)[1] - 1)
    return found
