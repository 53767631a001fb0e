"""A ring buffer of set-points in memory that two processes share, without locks.

One side only writes, the other only reads: for set-points the program and the worker, for the
report the worker and the program. Why this is correct on CPython, on any processor:

- Every shared word is written by one side only, 64 bits wide and aligned, in one store.
- The reader does not rely on a counter to decide that a slot is complete: each slot has a running
  number and a CRC over all of its bytes. The reader copies the slot first and checks the copy. A
  slot that is half written, or written but not yet visible to the other processor, fails the check
  and counts as "not there yet"; the reader tries again at its next tick. So the order in which
  stores become visible does not matter, and no memory barrier is needed; Python has none.
- The reader frees a slot only after the check of its copy has passed. A processor must not move a
  store ahead of the branch that it depends on, so the writer cannot get the slot too early.
"""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence


_CRC = struct.Struct("<Q")
_BODY = struct.Struct("<QQ6dQ")
_OVERHEAD = _CRC.size + _BODY.size
_HEAD, _TAIL = 0, 1


class SetPoint(NamedTuple):
    """One set-point as the program sent it.

    Attributes:
        number: running number of the set-point, from 1.
        stamp: monotonic time at which it was sent [ns].
        values: six numbers; the stream defines their meaning.
        extra: encoded data of the point (its operation, or the tag of an action), usually empty.
    """

    number: int
    stamp: int
    values: tuple[float, ...]
    extra: bytes


class Ring:
    """A ring that is first in, first out with `put`, or latest only with `overwrite`.

    Args:
        buffer: `Ring.size(capacity, extra)` bytes, all zero at first.
        capacity: number of set-points that fit.
        extra: size of the encoded data of a point [bytes].
    """

    __slots__ = ("_buffer", "_extra", "_slot", "_words", "capacity", "overwritten")

    def __init__(self, buffer: memoryview, capacity: int, extra: int = 0) -> None:
        self._words = buffer[:16].cast("Q")
        self._buffer = buffer[16:]
        self.capacity: int = capacity
        self._extra = extra
        self._slot = _slot_size(extra)
        #: set-points that the reader skipped because newer ones were there
        self.overwritten: int = 0

    @staticmethod
    def size(capacity: int, extra: int = 0) -> int:
        """Number of bytes that a ring needs."""
        return 16 + capacity * _slot_size(extra)

    @property
    def level(self) -> int:
        """Set-points written and not yet read."""
        return max(0, min(self._words[_HEAD] - self._words[_TAIL], self.capacity))

    @property
    def read(self) -> int:
        """Number of the last set-point read."""
        return self._words[_TAIL]

    def put(self, values: Sequence[float], stamp: int, extra: bytes = b"") -> bool:
        """Write one set-point, unless the ring is full.

        Returns:
            Whether it was written.
        """
        # The tail read here may be old. It only grows, so the writer can only overestimate how full
        # the ring is.
        if self._words[_HEAD] - self._words[_TAIL] >= self.capacity:
            return False
        self.overwrite(values, stamp, extra)
        return True

    def overwrite(self, values: Sequence[float], stamp: int, extra: bytes = b"") -> None:
        """Write one set-point, over the oldest one if the ring is full. Read it with `newest`."""
        if len(extra) > self._extra:
            raise ValueError(f"{len(extra)} bytes go with the point; {self._extra} fit")
        number = self._words[_HEAD] + 1
        body = _BODY.pack(number, stamp, *values, len(extra)) + extra
        start = (number % self.capacity) * self._slot
        self._buffer[start : start + 8 + len(body)] = _CRC.pack(zlib.crc32(body)) + body
        self._words[_HEAD] = number

    def take(self) -> SetPoint | None:
        """Read the next set-point in order; None if there is none yet."""
        number = self._words[_TAIL] + 1
        if number > self._words[_HEAD]:
            return None
        point = self._slot_at(number)
        if point is not None:
            self._words[_TAIL] = number
        return point

    def newest(self) -> SetPoint | None:
        """Read the newest set-point and skip all older ones; None if there is no new one.

        If the writer overwrites a slot during the read, the slot before it is read instead.
        """
        seen, head = self._words[_TAIL], self._words[_HEAD]
        for number in range(head, max(seen, head - self.capacity), -1):
            point = self._slot_at(number)
            if point is not None:
                self.overwritten += number - seen - 1
                self._words[_TAIL] = number
                return point
        return None

    def close(self) -> None:
        """Release the memory; no other method may be called after that."""
        self._words.release()
        self._buffer.release()

    def _slot_at(self, number: int) -> SetPoint | None:
        start = (number % self.capacity) * self._slot
        copy = bytes(self._buffer[start : start + self._slot])
        found, stamp, *values, length = _BODY.unpack_from(copy, 8)
        if found != number or length > self._extra:
            return None
        if zlib.crc32(copy[8 : _OVERHEAD + length]) != _CRC.unpack_from(copy)[0]:
            return None
        return SetPoint(number, stamp, tuple(values), copy[_OVERHEAD : _OVERHEAD + length])


def _slot_size(extra: int) -> int:
    return -(-(_OVERHEAD + extra) // 8) * 8
