"""Known layouts of replies of numbers, which need not be measured or read field by field.

Most replies to a function differ only in their values. The bytes between the values (types, field
ids and counts) are always the same. `Layouts` stores them from a reply that `framing` has measured.
A reply of the same length, with the same bytes in the same places, has the same layout: one format
of `struct` reads all its numbers at once.
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

#: maximum number of layouts per function: lists of varying length are not worth storing
_MOST: Final = 4

_I32 = struct.Struct("!i").unpack_from

#: function that reads the value of a reply from all its bytes and the index where its struct begins
Reader: TypeAlias = "Callable[[bytes | bytearray, int], Any]"
#: a layout: 1 where the bytes belong to no value, the content of these bits, what reads the values
_Layout: TypeAlias = "tuple[int, int, Reader]"


class Layouts:
    """The layouts of the replies to one function, by length."""

    __slots__ = ("_kept",)

    def __init__(self) -> None:
        self._kept: dict[int, _Layout] = {}

    def find(self, structs: bytes | bytearray) -> tuple[Reader, int] | None:
        """Return the reader and the length of the first of these structs, if its layout is stored.

        The bytes that belong to no value determine where a struct ends, so only one length can fit.
        """
        for size, (mask, fixed_bits, read) in self._kept.items():
            if len(structs) >= size and int.from_bytes(structs[:size]) & mask == fixed_bits:
                return read, size
        return None

    def store(self, data: bytes | bytearray, *results: Any) -> Reader | None:
        """Store the layout of a struct that was measured: it is complete and fits the IDL.

        Without memory it is not stored: a layout saves time, and an answer must not be lost for it.

        Args:
            data: the struct.
            results: classes of the result struct, of which the first that has these fields is read.

        Returns:
            The function that reads it; None if it has anything but numbers, or was not stored.
        """
        if len(data) <= _LONGEST and len(data) not in self._kept and len(self._kept) < _MOST:
            with contextlib.suppress(MemoryError):
                for result in results:
                    if (layout := _layout(result.thrift_spec, data)) is not None:
                        self._kept[len(data)] = layout
                        return layout[2]
        return None


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


def _layout(spec: Mapping[int, Any], data: bytes | bytearray) -> _Layout | None:
    """The layout of a result; None if it has anything but numbers, or not every field."""
    if list(spec) != [0] or data[:3] != bytes((spec[0][0], 0, 0)):
        return None
    kind: int = spec[0][0]
    formats = ["3x"]
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
    unpack = struct.Struct("!" + "".join(formats)).unpack_from
    # what is skipped belongs to no value; neither do the ends of the structs behind the last one
    skipped = [(each[-1] == "x", struct.calcsize(f"!{each}")) for each in formats]
    bits = b"".join((b"\xff" if skip else b"\0") * size for skip, size in skipped)
    mask = int.from_bytes(bits.ljust(len(data), b"\xff"))
    fixed_bits = int.from_bytes(data) & mask
    return mask, fixed_bits, lambda reply, start: build(unpack(reply, start))


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
    formats += ["5x", f"{size}{FORMATS[data[at]]}"]
    end = at + 5 + size * FIXED_WIDTHS[data[at]]
    return slice(count, count + size), end, count + size


def _builder(shape: Any, places: list[_Where]) -> Callable[[tuple[Any, ...]], Any]:
    """Make the function that builds a struct from its numbers.

    The fields of the struct are the parameters of its class.
    """

    def build(numbers: tuple[Any, ...]) -> Any:
        values = list(numbers)  # its slices are lists already
        return shape(*[values[where] for where in places])

    return build
