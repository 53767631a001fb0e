"""Known layouts of replies, which need not be measured or read field by field.

Most replies to a function differ only in their values. The bytes between the values (types, field
ids, counts and lengths) are always the same. `Layouts` stores them from a reply that `framing` has
measured. A reply of the same length, with the same bytes in the same places, has the same layout.
If all its values are numbers, one format of `struct` reads them at once.
"""

from __future__ import annotations

import contextlib
import struct
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from aioduco._wire.framing import FIXED_WIDTHS, FORMATS, TType

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


#: maximum length of a reply whose layout is stored; a status has 1 kB
_LONGEST: Final = 4096

#: maximum number of layouts per function: lists and texts of varying length are not worth storing
_MOST: Final = 4

_I32 = struct.Struct("!i").unpack_from

#: function that reads the value of a reply from all its bytes and the index where its struct begins
Reader: TypeAlias = "Callable[[bytes | bytearray, int], Any]"


class Layouts:
    """The layouts of the replies to one function, by length.

    Args:
        spec: thriftpy2's spec of the result struct.
    """

    __slots__ = ("_kept", "_spec")

    def __init__(self, spec: Mapping[int, Any]) -> None:
        self._spec = spec
        #: by length: 1 where the bytes of the struct belong to no value, the content of these bits,
        #: and what reads the value; None if there is anything but numbers, or not every field
        self._kept: dict[int, tuple[int, int, Reader | None]] = {}

    def find(self, structs: bytes | bytearray) -> tuple[Reader | None, int] | None:
        """Return the reader and the length of the first of these structs, if its layout is stored.

        The bytes that belong to no value determine where a struct ends, so only one length can fit.
        """
        for size, (mask, fixed_bits, read) in self._kept.items():
            if len(structs) >= size and int.from_bytes(structs[:size]) & mask == fixed_bits:
                return read, size
        return None

    def store(self, struct: bytes | bytearray) -> Reader | None:
        """Store the layout of a struct that was measured: it is complete and fits the IDL.

        Without memory it is not stored: a layout saves time, and an answer must not be lost for it.

        Returns:
            The function that reads it, if it was stored, and contains nothing but numbers.
        """
        if len(struct) <= _LONGEST and len(struct) not in self._kept and len(self._kept) < _MOST:
            with contextlib.suppress(MemoryError):
                self._kept[len(struct)] = layout = self._layout(struct)
                return layout[2]
        return None

    def _layout(self, struct: bytes | bytearray) -> tuple[int, int, Reader | None]:
        size = len(struct)
        mask = bytearray(b"\xff" * size)
        _clear_values(struct, 0, mask)
        number = int.from_bytes(mask, "big")
        fixed_bits = int.from_bytes(struct, "big") & number
        return number, fixed_bits, _reader(self._spec, struct)


def packer(spec: Mapping[int, Any]) -> Callable[[tuple[Any, ...]], bytes] | None:
    """Make the function that encodes the arguments of a call.

    Args:
        spec: thriftpy2's spec of the argument struct.

    Returns:
        A function of the tuple of arguments; None if some of them have no fixed width.
    """
    kinds = [entry[0] for entry in spec.values()]
    if not all(kind in FORMATS for kind in kinds):
        return None
    pack = struct.Struct("!" + "".join("3s" + FORMATS[kind] for kind in kinds) + "x").pack
    heads = [struct.pack("!bh", kind, number) for number, kind in zip(spec, kinds, strict=True)]

    def packed(args: tuple[Any, ...]) -> bytes:
        return pack(*[part for pair in zip(heads, args, strict=True) for part in pair])

    return packed


def _reader(spec: Mapping[int, Any], data: bytes | bytearray) -> Reader | None:
    """Make the function that reads the value of results with the layout of this one."""
    if list(spec) != [0] or data[:3] != bytes((spec[0][0], 0, 0)):
        return None
    kind: int = spec[0][0]
    formats: list[str] = []
    build: Callable[[tuple[Any, ...]], Any]
    if kind == TType.STRUCT:
        shape = spec[0][2]
        fields = shape.thrift_spec
        places = _fields(fields, data, formats)
        if places is None or shape.__match_args__ != tuple(entry[1] for entry in fields.values()):
            return None
        build = _builder(shape, places)
    else:
        place = _place(kind, data, 3, formats, 0)
        if place is None:
            return None
        build = itemgetter(0) if isinstance(place[0], int) else list
    unpack = struct.Struct("!3x" + "".join(formats)).unpack_from
    return lambda reply, start: build(unpack(reply, start))


#: index of a value among the numbers that were read, or the slice of a list
_Where = int | slice


def _fields(
    spec: Mapping[int, Any], data: bytes | bytearray, formats: list[str]
) -> list[_Where] | None:
    """Places of a struct's fields; None if `struct` cannot read them, or some are missing."""
    places: list[_Where] = []
    at, count = 3, 0
    for number, (kind, *_) in spec.items():
        if data[at : at + 3] != bytes((kind, number >> 8, number & 0xFF)):
            return None
        formats.append("3x")
        place = _place(kind, data, at + 3, formats, count)
        if place is None:
            return None
        where, at, count = place
        places.append(where)
    return places if data[at] == TType.STOP else None


def _place(
    kind: int, data: bytes | bytearray, at: int, formats: list[str], count: int
) -> tuple[_Where, int, int] | None:
    """Place of a value after `count` numbers, index of its end, number of numbers up to there."""
    if kind in FORMATS:
        formats.append(FORMATS[kind])
        return count, at + FIXED_WIDTHS[kind], count + 1
    if kind != TType.LIST or data[at] not in FORMATS:
        return None
    size = _I32(data, at + 1)[0]
    formats.append(f"5x{size}{FORMATS[data[at]]}")
    end = at + 5 + size * FIXED_WIDTHS[data[at]]
    return slice(count, count + size), end, count + size


def _builder(shape: Any, places: list[_Where]) -> Callable[[tuple[Any, ...]], Any]:
    """Make the function that builds a struct from its numbers.

    The fields of the struct are the parameters of its class.
    """

    def build(numbers: tuple[Any, ...]) -> Any:
        return shape(
            *[
                numbers[where] if isinstance(where, int) else list(numbers[where])
                for where in places
            ]
        )

    return build


def _clear_values(data: bytes | bytearray, at: int, mask: bytearray) -> int:
    """Clear the values of a struct in the mask; return where the struct ends."""
    while (kind := data[at]) != TType.STOP:
        at = _clear_value(kind, data, at + 3, mask)
    return at + 1


def _clear_value(kind: int, data: bytes | bytearray, at: int, mask: bytearray) -> int:
    """Clear a value in the mask, but not its counts, lengths and types; return where it ends."""
    width = FIXED_WIDTHS.get(kind)
    if width is not None:
        return _clear(mask, at, width)
    if kind == TType.STRING:
        return _clear(mask, at + 4, _I32(data, at)[0])
    if kind == TType.STRUCT:
        return _clear_values(data, at, mask)
    kinds = (data[at], data[at + 1]) if kind == TType.MAP else (data[at],)
    at += len(kinds)
    count = _I32(data, at)[0]
    at += 4
    if len(kinds) == 1 and (width := FIXED_WIDTHS.get(kinds[0])) is not None:
        return _clear(mask, at, count * width)
    for _ in range(count):
        for each in kinds:
            at = _clear_value(each, data, at, mask)
    return at


def _clear(mask: bytearray, at: int, size: int) -> int:
    mask[at : at + size] = bytes(size)
    return at + size
