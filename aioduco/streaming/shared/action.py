"""The tag of each action of a chunk in the ring."""

from __future__ import annotations

import struct
from typing import NamedTuple

__all__ = ["ActionTag"]

_LAYOUT = struct.Struct("<QQII")


class ActionTag(NamedTuple):
    """The chunk to which an action belongs, and its position there.

    Attributes:
        chunk: running number of the chunk, from 1.
        begin: monotonic time at which its first action is due [ns]; 0: when the worker takes it.
        position: number of this action in the chunk, from 0.
        total: actions in the chunk.
    """

    chunk: int
    begin: int
    position: int
    total: int

    @staticmethod
    def size() -> int:
        """Number of bytes of a packed tag."""
        return _LAYOUT.size

    def pack(self) -> bytes:
        """Encode it for the ring."""
        return _LAYOUT.pack(*self)

    @classmethod
    def unpack(cls, data: bytes) -> ActionTag:
        """Decode the result of `pack`."""
        return cls(*_LAYOUT.unpack(data))
