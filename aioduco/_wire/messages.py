"""Messages of the wire, and where they begin and end: strict TBinaryProtocol, without a schema.

What stands at the other end of a client, a server or a proxy, takes whole messages out of a
stream here. Of a body it needs only the length, which follows from the types in the body. No I/O
is done.
"""

from __future__ import annotations

import enum
import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from aioduco._wire.framing import REPLY, Bounds, Malformed, StructScanner

if TYPE_CHECKING:
    from collections.abc import Set

_VERSION: Final = 0x80010000
_VERSION_MASK: Final = 0xFFFF0000

#: longest name of a function that is taken for one; the longest on the wire has 33 bytes
_NAME_LIMIT: Final = 128

#: types in the body of an application error
_STRING: Final = 11
_I32: Final = 8


class MessageType(enum.IntEnum):
    """Type of a message."""

    CALL = 1
    REPLY = 2
    EXCEPTION = 3
    ONEWAY = 4


_KINDS: Final = {int(kind): kind for kind in MessageType}


@dataclass(frozen=True, slots=True)
class Message:
    """One message of the wire.

    Attributes:
        kind: call, reply, exception or one-way call.
        name: the function on the wire.
        seqid: the sequence id that the caller chose.
        body: the encoded struct of arguments or of the result, its stop byte included.
    """

    kind: MessageType
    name: str
    seqid: int
    body: bytes

    def encode(self) -> bytes:
        """The bytes of the message, as they stand on the wire."""
        name = self.name.encode()
        head = struct.pack("!II", _VERSION | self.kind, len(name))
        return head + name + struct.pack("!i", self.seqid) + self.body


def application_error(call: Message, code: int, text: str) -> Message:
    """The answer by which a server says that it could not carry a call out.

    Args:
        call: the call that is answered.
        code: type of the application error; 1 is an unknown method, 6 an internal error.
        text: what went wrong.

    Returns:
        The message of kind EXCEPTION.
    """
    said = text.encode()
    body = (
        struct.pack("!bhI", _STRING, 1, len(said)) + said + struct.pack("!bhib", _I32, 2, code, 0)
    )
    return Message(MessageType.EXCEPTION, call.name, call.seqid, body)


class Inbox:
    """Collects received bytes and takes whole messages out of them.

    Each byte is looked at once, however the stream is cut. What passes is safe for thriftpy2's
    decoder. After a `Malformed` it is of no more use: nothing in the stream says where the next
    message would begin.

    Args:
        kinds: the kinds of messages that are taken.
        bounds: the limits within which a message is accepted.
    """

    __slots__ = ("_body", "_bounds", "_data", "_head", "_kinds", "_scanner")

    def __init__(
        self, kinds: Set[MessageType] = frozenset(MessageType), bounds: Bounds = REPLY
    ) -> None:
        self._kinds = kinds
        self._bounds = bounds
        self._data = bytearray()
        self._head: tuple[MessageType, str, int] | None = None
        self._body = 0
        self._scanner = StructScanner({}, 0)

    @property
    def pending(self) -> bytes:
        """The bytes that were fed and are in no message yet."""
        return bytes(self._data)

    def feed(self, data: bytes) -> None:
        """Add bytes that were received."""
        self._data += data

    def take(self) -> Message | None:
        """The next whole message, or None when more bytes are needed.

        Raises:
            Malformed: the bytes are no message, or one beyond the bounds.
        """
        if self._head is None:
            self._head = self._header()
            if self._head is None:
                return None
        if not self._scanner.whole(self._data):
            return None
        end = self._scanner.position
        message = Message(*self._head, bytes(self._data[self._body : end]))
        del self._data[:end]
        self._head = None
        return message

    def _header(self) -> tuple[MessageType, str, int] | None:
        data = self._data
        size = len(data)
        if size < 4:
            return None
        (first,) = struct.unpack_from("!I", data)
        if first & _VERSION_MASK != _VERSION:
            raise Malformed(f"{bytes(data[:16])!r} begins no message of the strict binary protocol")
        kind = _KINDS.get(first & 0xFF)
        if kind is None or kind not in self._kinds:
            raise Malformed(f"a message of type {first & 0xFF} is not taken here")
        if size < 8:
            return None
        (length,) = struct.unpack_from("!i", data, 4)
        if not 0 < length <= _NAME_LIMIT:
            raise Malformed(f"a function cannot have a name of {length} bytes")
        start = 12 + length
        if size < start:
            return None
        try:
            name = str(data[8 : 8 + length], "ascii")
        except UnicodeDecodeError:
            raise Malformed("a function has a name that is not ASCII") from None
        (seqid,) = struct.unpack_from("!i", data, 8 + length)
        self._body = start
        self._scanner = StructScanner({}, start, self._bounds)
        return (kind, name, seqid)
