"""Histograms of fixed size that one process writes while another process reads them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable


_BITS = 5
_SUB = 1 << _BITS  # buckets per octave: a percentile is at most 1/32 above the true value
_LARGEST = (1 << 42) - 1  # 73 minutes in nanoseconds; longer times count as this
_COUNT = ((42 - _BITS - 1) << _BITS) + 2 * _SUB
_TOTAL, _MAX, _HEAD = 0, 1, 2


class Percentiles(NamedTuple):
    """Percentiles of a histogram at one moment. Times are in seconds, depths in points.

    Attributes:
        samples: number of recorded values.
        mean: their mean.
        p50: the median.
        p99: the value that 99 % of them do not exceed.
        p999: the value that 99.9 % of them do not exceed.
        max: the largest value.
    """

    samples: int
    mean: float
    p50: float
    p99: float
    p999: float
    max: float


class Histogram:
    """A histogram with logarithmic buckets, 3 % wide, over whole numbers (nanoseconds).

    Its words are 64 bits wide and one writer writes them one at a time, so that another process can
    read them at the same time: a word may be one value behind, but is never torn. The count is the
    sum of the buckets and has no word, so a percentile never refers to a value that is not yet
    written.

    Args:
        words: `Histogram.WORDS` words of unsigned 64 bits, all zero at first, for the counts.
    """

    WORDS = _HEAD + _COUNT

    __slots__ = ("_words",)

    def __init__(self, words: memoryview | None = None) -> None:
        self._words = memoryview(bytearray(8 * self.WORDS)).cast("Q") if words is None else words

    def record(self, value: int) -> None:
        """Count one value; a value below zero counts as zero."""
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
        """Release the memory; no other method may be called after that."""
        self._words.release()

    def buckets(self) -> list[tuple[int, int, int]]:
        """All buckets that are not empty: lowest value, lowest value of the next, count."""
        return [(*_edges(i), n) for i, n in enumerate(self._words[_HEAD:].tolist()) if n]

    def snapshot(self, scale: float = 1e-9) -> Percentiles:
        """Read the present percentiles.

        Args:
            scale: factor from the counted unit to the result: 1e-9 for nanoseconds to seconds.

        Returns:
            The percentiles; all zero if nothing was recorded. A percentile is the upper edge of its
            bucket, so it is never too low, and never above the maximum.
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
    """The lowest value of a bucket, and that of the next bucket."""
    shift = max((index >> _BITS) - 1, 0)
    low = (index - (shift << _BITS)) << shift
    return low, low + (1 << shift)


def _percentiles(counts: list[int], count: int, fractions: Iterable[float]) -> list[int]:
    """The largest value of the bucket that contains each fraction; fractions in rising order."""
    found: list[int] = []
    seen, index = 0, -1
    for fraction in fractions:
        rank = max(1, -int(-fraction * count // 1))
        while seen < rank:
            index += 1
            seen += counts[index]
        found.append(_edges(index)[1] - 1)
    return found
