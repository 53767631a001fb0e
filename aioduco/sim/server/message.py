"""Where a Thrift message ends: a scanner of unframed strict binary, without I/O.

The wire has no frames, so the only way to know that a call is complete is to walk through its
fields. That walk is also the guard against hostile bytes: sizes are compared with the limits
before anything is allocated or awaited, and what passes is safe for thriftpy2's decoder, which
allocates what a size field claims and reads on past the end of its buffer.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Generator

#: A call of 1000 track points with their operations takes about 200 kB.
MAX_MESSAGE = 1 << 20
#: Elements of all lists, sets and maps of one message: bounds what a small message unpacks to.
MAX_ELEMENTS = 1 << 16
#: The deepest function of the wire nests four levels.
MAX_DEPTH = 16
MAX_NAME = 128

CALL, REPLY, EXCEPTION, ONEWAY = 1, 2, 3, 4

_VERSION_1 = 0x8001
_STOP, _STRING, _STRUCT, _MAP, _SET, _LIST = 0, 11, 12, 13, 14, 15
#: bytes of each type of a fixed size: bool, byte, double, i16, i32, i64
_FIXED = {2: 1, 3: 1, 4: 8, 6: 2, 8: 4, 10: 8}
_NESTING = frozenset((_STRING, _STRUCT, _MAP, _SET, _LIST))

_head = struct.Struct(">HBBi").unpack_from
_i32 = struct.Struct(">i").unpack_from


class Malformed(Exception):
    """The bytes are no message of this protocol: the connection cannot go on."""


@dataclass(frozen=True, slots=True)
class Message:
    """One whole message.

    Attributes:
        kind: CALL or ONEWAY.
        name: the function called.
        seqid: the caller's number of this call.
        body: the argument struct, encoded; its sizes have been checked.
    """

    kind: int
    name: str
    seqid: int
    body: bytes


class Inbox:
    """Collects received bytes and takes whole messages out of them.

    The walk goes on where the last bytes ended: a peer that sends byte by byte costs no more
    than one that sends at once.
    """

    __slots__ = ("_budget", "_data", "_pos", "_scan")

    def __init__(self) -> None:
        self._data = bytearray()
        self._pos = 0
        self._budget = MAX_ELEMENTS
        self._scan = self._message()

    def feed(self, data: bytes) -> None:
        """Add bytes that were received."""
        self._data += data

    def take(self) -> Message | None:
        """The next whole message, or None when more bytes are needed.

        Raises:
            Malformed: The bytes are no message, or one beyond the limits.
        """
        try:
            next(self._scan)
        except StopIteration as done:
            message: Message = done.value
            del self._data[: self._pos]
            self._scan = self._message()
            return message
        return None

    def _message(self) -> Generator[None, None, Message]:
        data = self._data
        self._budget = MAX_ELEMENTS
        self._pos = 0
        yield from self._need(8)
        version, _, kind, length = _head(data)
        if version != _VERSION_1:
            raise Malformed("no strict binary message")
        if kind not in (CALL, ONEWAY):
            raise Malformed(f"message type {kind} is not a call")
        if not 0 < length <= MAX_NAME:
            raise Malformed(f"a function name of {length} bytes")
        start = 8 + length + 4
        yield from self._need(start)
        try:
            name = str(data[8 : 8 + length], "ascii")
        except UnicodeDecodeError:
            raise Malformed("a function name that is not ASCII") from None
        (seqid,) = _i32(data, 8 + length)
        self._pos = start
        yield from self._struct(MAX_DEPTH)
        yield from self._need(self._pos)
        return Message(kind, name, seqid, bytes(data[start : self._pos]))

    def _need(self, size: int) -> Generator[None, None, None]:
        """Wait until so many bytes of the message are there."""
        if size > MAX_MESSAGE:
            raise Malformed(f"a message of more than {MAX_MESSAGE} bytes")
        while len(self._data) < size:
            yield

    # Below, `_pos` may run ahead of the bytes received: what has a fixed size is passed over
    # without looking, and the next thing that is looked at waits for its bytes.

    def _struct(self, depth: int) -> Generator[None, None, None]:
        if not depth:
            raise Malformed(f"nested deeper than {MAX_DEPTH} levels")
        data = self._data
        while True:
            if len(data) <= self._pos:
                yield from self._need(self._pos + 1)
            kind = data[self._pos]
            if kind == _STOP:
                self._pos += 1
                return
            self._pos += 3
            size = _FIXED.get(kind)
            if size is not None:
                self._pos += size
            else:
                yield from self._nested(kind, depth)

    def _nested(self, kind: int, depth: int) -> Generator[None, None, None]:
        """Pass over one value without a fixed size."""
        if kind == _STRING:
            yield from self._need(self._pos + 4)
            (size,) = _i32(self._data, self._pos)
            if not 0 <= size <= MAX_MESSAGE:
                raise Malformed(f"a string of {size} bytes")
            self._pos += 4 + size
        elif kind == _STRUCT:
            yield from self._struct(depth - 1)
        elif kind in (_LIST, _SET):
            yield from self._need(self._pos + 5)
            element = self._data[self._pos]
            count = self._count(self._pos + 1)
            self._pos += 5
            yield from self._elements((element,), count, depth - 1)
        elif kind == _MAP:
            yield from self._need(self._pos + 6)
            key, value = self._data[self._pos], self._data[self._pos + 1]
            count = self._count(self._pos + 2)
            self._pos += 6
            yield from self._elements((key, value), count, depth - 1)
        else:
            raise Malformed(f"type {kind} is no type of a value")

    def _count(self, at: int) -> int:
        count: int = _i32(self._data, at)[0]
        if not 0 <= count <= self._budget:
            raise Malformed(f"a container of {count} elements")
        self._budget -= count
        return count

    def _elements(
        self, kinds: tuple[int, ...], count: int, depth: int
    ) -> Generator[None, None, None]:
        if not depth:
            raise Malformed(f"nested deeper than {MAX_DEPTH} levels")
        sizes = [_FIXED.get(kind) for kind in kinds]
        if None not in sizes:
            self._pos += count * sum(size for size in sizes if size is not None)
            return
        # An empty container may name no type at all.
        for _ in range(count):
            for kind, size in zip(kinds, sizes, strict=True):
                if size is not None:
                    self._pos += size
                else:
                    yield from self._nested(kind, depth)
