"""Replies of a layout that was met before, and so need not be measured field by field.

Most replies to a function differ in their values alone: the bytes between these, which are types,
field ids, counts and lengths, are always the same. They are kept from a reply that `framing` has
measured. A reply that is as long, and has the same bytes in the same places, would be measured with
the same outcome.
"""

from __future__ import annotations

import struct
from typing import Final

from thriftpy2.thrift import TType

from aioduco._wire.framing import FIXED_WIDTHS

__all__ = ["Layouts"]

#: the longest reply whose layout is kept; a status has 1 kB
_LONGEST: Final = 4096

#: most layouts of one function: those of lists and texts of any length are not worth keeping
_MOST: Final = 4

_I32 = struct.Struct("!i").unpack_from


class Layouts:
    """The layouts of the replies to one function, by length."""

    __slots__ = ("_kept",)

    def __init__(self) -> None:
        #: which bits are no value's, and how they are
        self._kept: dict[int, tuple[int, int]] = {}

    def known(self, struct: bytes | bytearray) -> bool:
        """Whether this is the struct of a whole reply, laid out as one that was kept."""
        kept = self._kept.get(len(struct))
        if kept is None:
            return False
        mask, heads = kept
        return int.from_bytes(struct, "big") & mask == heads

    def keep(self, struct: bytes | bytearray) -> None:
        """Keep the layout of a struct that was measured: it is whole, and fits."""
        size = len(struct)
        if size > _LONGEST or size in self._kept or len(self._kept) >= _MOST:
            return
        mask = bytearray(b"\xff" * size)
        _clear_values(struct, 0, mask)
        number = int.from_bytes(mask, "big")
        self._kept[size] = number, int.from_bytes(struct, "big") & number


def _clear_values(data: bytes | bytearray, at: int, mask: bytearray) -> int:
    """Clear the values of a struct in the mask; where the struct ends."""
    while (kind := data[at]) != TType.STOP:
        at = _clear_value(kind, data, at + 3, mask)
    return at + 1


def _clear_value(kind: int, data: bytes | bytearray, at: int, mask: bytearray) -> int:
    """Clear a value in the mask, but not its counts, lengths and types; where it ends."""
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
