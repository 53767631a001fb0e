"""What the server takes for a call, and how much of it: the guard against hostile bytes.

Sizes are compared with the bounds before anything is allocated or awaited.
"""

from __future__ import annotations

from aioduco._wire import messages
from aioduco._wire.framing import Bounds, Malformed
from aioduco._wire.messages import Kind, Message

__all__ = [
    "CALL",
    "EXCEPTION",
    "MAX_DEPTH",
    "MAX_ELEMENTS",
    "MAX_MESSAGE",
    "ONEWAY",
    "REPLY",
    "Inbox",
    "Malformed",
    "Message",
]

#: A call of 1000 track points with their operations takes about 200 kB.
MAX_MESSAGE = 1 << 20
#: Elements of all lists, sets and maps of one message: bounds what a small message unpacks to.
MAX_ELEMENTS = 1 << 16
#: The deepest function of the wire nests four levels.
MAX_DEPTH = 16

CALL, REPLY, EXCEPTION, ONEWAY = Kind

_BOUNDS = Bounds(MAX_MESSAGE, MAX_ELEMENTS, MAX_DEPTH)
_CALLS = frozenset((CALL, ONEWAY))


class Inbox(messages.Inbox):
    """Takes whole calls out of what was received."""

    __slots__ = ()

    def __init__(self) -> None:
        super().__init__(_CALLS, _BOUNDS)
