"""Find the end of an encoded struct and check its types, before thriftpy2 decodes it.

The wire has no frames: only a walk through the fields shows whether a message is complete. And
thriftpy2 checks nothing that it reads. It allocates as many bytes as a length field says, returns
an empty list if the elements have another type than in the IDL, and leaves out a field of another
type, which is right within a struct of a newer controller. So this module first measures the
received bytes and checks their types, byte by byte as they arrive, without any I/O. Only a struct
that is complete and fits the IDL is decoded.
"""

from __future__ import annotations

import struct
from typing import Any, Final, NamedTuple


class TType:
    """The numbers of Thrift's types, as in thriftpy2, which is not loaded for them.

    `STOP` ends a struct.
    """

    STOP: Final = 0
    BOOL: Final = 2
    BYTE: Final = 3
    DOUBLE: Final = 4
    I16: Final = 6
    I32: Final = 8
    I64: Final = 10
    STRING: Final = 11
    STRUCT: Final = 12
    MAP: Final = 13
    SET: Final = 14
    LIST: Final = 15


#: the longest reply that is accepted; a status has 1 kB, the longest list of files some 100 kB
MAX_REPLY: Final = 4 * 1024 * 1024

_I32 = struct.Struct("!i").unpack_from

#: format of `struct` for each type of fixed width
FORMATS: Final = {
    TType.BOOL: "?",
    TType.BYTE: "b",
    TType.I16: "h",
    TType.I32: "i",
    TType.I64: "q",
    TType.DOUBLE: "d",
}
#: number of bytes of a value of them
FIXED_WIDTHS: Final = {kind: struct.calcsize(f"!{code}") for kind, code in FORMATS.items()}
_STOP: Final[int] = TType.STOP
_STRING: Final[int] = TType.STRING
_STRUCT: Final[int] = TType.STRUCT
_LIST: Final[int] = TType.LIST
_SET: Final[int] = TType.SET
_MAP: Final[int] = TType.MAP

#: bytes before the content of a value that has no fixed width
_HEAD: Final = {_STRING: 4, _LIST: 5, _SET: 5, _MAP: 6}

#: details that thriftpy2 stores for a type: a struct's class, a container's element types
Shape = Any
_ANY: Final = None


class Malformed(Exception):
    """The bytes are not a message, or not one that fits the IDL: the stream is unusable."""


class Bounds(NamedTuple):
    """The limits within which a message is accepted.

    Attributes:
        size: maximum number of bytes of the message.
        elements: maximum number of elements of all its lists, sets and maps together. It limits
            the memory that a short message can need when decoded.
        depth: maximum nesting of structs and containers.
    """

    size: int
    elements: int
    depth: int


#: bounds of replies; the deepest reply has four levels
REPLY: Final = Bounds(size=MAX_REPLY, elements=MAX_REPLY, depth=32)


#: fields of a struct that is being read: thriftpy2's spec; empty if the IDL has no such struct
_Fields = dict[int, tuple[Any, ...]]


class _Items:
    """The remaining elements of a container; in a map, keys and values alternate."""

    __slots__ = ("left", "shapes", "types")

    def __init__(self, types: tuple[int, ...], shapes: tuple[Shape, ...], count: int) -> None:
        self.types = types
        self.shapes = shapes
        self.left = count * len(types)


class StructScanner:
    """Finds the end of one encoded struct in a growing buffer.

    Invariants: each byte is read once, no matter how the stream is split. `position` may lie past
    the end of the buffer, after a value that is announced but has not arrived. It never passes the
    bounds, so a wrong length from a peer never causes a wait or an allocation.
    """

    __slots__ = ("_depth", "_elements", "_open", "_size", "_strict", "position")

    def __init__(
        self,
        fields: _Fields,
        start: int,
        bounds: Bounds = REPLY,
        *,
        strict: bool = False,
    ) -> None:
        """Make a scanner.

        Args:
            fields: thriftpy2's spec of the struct: by field id a tuple of type, name, perhaps
                the shape, and whether it is required; empty to accept any struct.
            start: index of the struct's first byte.
            bounds: the limits within which it is accepted.
            strict: whether a field of another type does not fit in a nested struct either. If
                not, it is passed over there as an unknown one, as the reader does.
        """
        self.position = start
        self._strict = strict
        self._size, self._elements, self._depth = bounds
        self._open: list[_Fields | _Items] = [fields]

    def whole(self, data: bytes | bytearray) -> bool:
        """Continue to read the bytes.

        Args:
            data: all bytes of the message that have arrived.

        Returns:
            Whether the struct has ended; `position` is then the first byte after it.

        Raises:
            Malformed: the bytes do not fit.
        """
        size = len(data)
        stack = self._open
        while stack:
            inner = stack[-1]
            if isinstance(inner, _Items):
                went_on = self._items(inner, data, size)
            else:
                went_on = self._fields(inner, data, size)
            if self.position > self._size:
                raise Malformed(f"a message of more than {self._size} bytes")
            if not went_on:
                return False
        return True

    def _fields(self, fields: _Fields, data: bytes | bytearray, size: int) -> bool:
        """Skip fields until a nested one opens, the struct ends, or the bytes end."""
        fixed = FIXED_WIDTHS
        at = self.position
        while at < size:
            kind = data[at]
            if kind == _STOP:
                self.position = at + 1
                self._open.pop()
                return True
            if at + 3 > size:
                break
            field = fields.get((data[at + 1] << 8) | data[at + 2])
            if field is not None and field[0] != kind:
                if self._strict or len(self._open) == 1:
                    raise Malformed(f"field {field[1]} has the type {kind}, not {field[0]}")
                field = None
            if kind in fixed:
                at += 3 + fixed[kind]
                continue
            shape = field[2] if field is not None and len(field) > 3 else _ANY
            # lists of numbers, the largest part of a status, are skipped right here
            if kind == _LIST and shape in fixed and at + 8 <= size and data[at + 3] == shape:
                count = _I32(data, at + 4)[0]
                if 0 <= count <= self._elements:
                    self._elements -= count
                    at += 8 + count * fixed[shape]
                    continue
            after = self._value(kind, shape, data, at + 3, size)
            if after is None:
                break
            if after < 0:
                return True
            at = after
        self.position = at
        return False

    def _items(self, inner: _Items, data: bytes | bytearray, size: int) -> bool:
        """Skip elements until a nested one opens, the container ends, or the bytes end."""
        types = inner.types
        at = self.position
        while inner.left:
            if at >= size:
                break
            turn = -inner.left % len(types)
            width = FIXED_WIDTHS.get(types[turn])
            if width is not None:
                inner.left -= 1
                at += width
                continue
            inner.left -= 1
            after = self._value(types[turn], inner.shapes[turn], data, at, size)
            if after is None:
                inner.left += 1
                break
            if after < 0:
                return True
            at = after
        else:
            self.position = at
            self._open.pop()
            return True
        self.position = at
        return False

    def _value(
        self, kind: int, shape: Shape, data: bytes | bytearray, at: int, size: int
    ) -> int | None:
        """Skip one value that has no fixed width.

        Returns:
            The index after its end; -1 if it was opened instead; None if more bytes are needed.
        """
        if at + _HEAD.get(kind, 0) > size:
            return None
        if kind == _STRING:
            return at + 4 + self._length(data, at)
        if kind == _STRUCT:
            return self._enter(shape.thrift_spec if shape is not None else {}, at)
        if kind == _MAP:
            return self._map(shape, data, at)
        if kind in (_LIST, _SET):
            return self._list(shape, data, at)
        raise Malformed(f"there is no type {kind}")

    def _list(self, shape: Shape, data: bytes | bytearray, at: int) -> int:
        element = data[at]
        count = self._count(data, at + 1)
        inner, deeper = _parts(shape)
        # the element type of an empty list has no meaning
        if count and inner is not None and inner != element:
            raise Malformed(f"a list has elements of the type {element}, not {inner}")
        width = FIXED_WIDTHS.get(element)
        if width is not None:
            return at + 5 + count * width
        _check_types((element,), count)
        return self._enter(_Items((element,), (deeper,), count), at + 5)

    def _map(self, shape: Shape, data: bytes | bytearray, at: int) -> int:
        types = (data[at], data[at + 1])
        count = self._count(data, at + 2)
        wanted = [_parts(part) for part in shape or (_ANY, _ANY)]
        for kind, (known, _) in zip(types, wanted, strict=True):
            if count and known is not None and known != kind:
                raise Malformed(f"a map has keys or values of the type {kind}, not {known}")
        _check_types(types, count)
        return self._enter(_Items(types, tuple(part[1] for part in wanted), count), at + 6)

    def _enter(self, inner: _Fields | _Items, at: int) -> int:
        if len(self._open) >= self._depth:
            raise Malformed(f"nested deeper than {self._depth} levels")
        self._open.append(inner)
        self.position = at
        return -1

    def _length(self, data: bytes | bytearray, at: int) -> int:
        length: int = _I32(data, at)[0]
        if not 0 <= length <= self._size:
            raise Malformed(f"a string of {length} bytes")
        return length

    def _count(self, data: bytes | bytearray, at: int) -> int:
        count: int = _I32(data, at)[0]
        if not 0 <= count <= self._elements:
            raise Malformed(f"a container of {count} elements")
        self._elements -= count
        return count


def _check_types(types: tuple[int, ...], count: int) -> None:
    """Check that these types exist; an empty container may have any type number."""
    for kind in types:
        if count and kind not in FIXED_WIDTHS and kind not in _HEAD and kind != _STRUCT:
            raise Malformed(f"there is no type {kind}")


def _parts(part: Any) -> tuple[int | None, Shape]:
    """Type and shape of an element; None for an unknown type."""
    return (part[0], part[1]) if isinstance(part, tuple) else (part, _ANY)
