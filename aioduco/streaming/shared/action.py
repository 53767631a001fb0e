"""What goes through the ring with each action of a chunk."""

from __future__ import annotations

import struct
from typing import NamedTuple

__all__ = ["MOST_ACTIONS", "ActionTag"]

#: most actions in a chunk
MOST_ACTIONS = 1000

_LAYOUT = struct.Struct("<QQII")


class ActionTag(NamedTuple):
    """To which chunk an action belongs.

    Attributes:
        chunk: running number of the chunk, from 1.
        begin: monotonic time at which its first action is due [ns]; 0: when it is taken.
        position: number of this action in the chunk, from 0.
        total: actions in the chunk.
    """

    chunk: int
    begin: int
    position: int
    total: int

    @staticmethod
    def size() -> int:
        """How many bytes it takes."""
        return _LAYOUT.size

    def pack(self) -> bytes:
        """As it stands in the ring."""
        return _LAYOUT.pack(*self)

    @classmethod
    def unpack(cls, data: bytes) -> ActionTag:
        """What `pack` made."""
        return cls(*_LAYOUT.unpack(data))
