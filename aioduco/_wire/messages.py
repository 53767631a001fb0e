"""Split a stream into messages of the wire: strict TBinaryProtocol, without a schema.

The peer of a client, that is a server or a proxy, extracts whole messages from a stream by this
module. It needs only the length of a body, which follows from the types in the body. No I/O is
done.
"""

from __future__ import annotations

import enum
import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from aioduco._wire.framing import REPLY, Bounds, Malformed, StructScanner, TType

if TYPE_CHECKING:
    from collections.abc import Iterator, Set

_VERSION: Final = 0x80010000
_VERSION_MASK: Final = 0xFFFF0000

#: maximum length of a function's name [bytes]; the longest on the wire has 33
_NAME_LIMIT: Final = 128


class MessageType(enum.IntEnum):
    """Type of a message."""

    CALL = 1
    REPLY = 2
    EXCEPTION = 3
    ONEWAY = 4


@dataclass(frozen=True, slots=True)
class Message:
    """One message of the wire.

    Attributes:
        kind: call, reply, exception or one-way call.
        name: name of the function on the wire.
        seqid: the sequence id that the caller chose.
        body: the encoded struct of arguments or of the result, its stop byte included.
    """

    kind: MessageType
    name: str
    seqid: int
    body: bytes

    def encode(self) -> bytes:
        """Return the bytes of the message on the wire."""
        name = self.name.encode()
        head = struct.pack("!II", _VERSION | self.kind, len(name))
        return head + name + struct.pack("!i", self.seqid) + self.body


def application_error(call: Message, code: int, text: str) -> Message:
    """Make the answer of a server that could not execute a call.

    Args:
        call: the call that is answered.
        code: type of the application error; 1 is an unknown method, 6 an internal error.
        text: description of the error.

    Returns:
        The message of kind EXCEPTION.
    """
    said = text.encode()
    body = (
        struct.pack("!bhI", TType.STRING, 1, len(said))
        + said
        + struct.pack("!bhib", TType.I32, 2, code, TType.STOP)
    )
    return Message(MessageType.EXCEPTION, call.name, call.seqid, body)


class Inbox:
    """Buffer that collects received bytes and returns whole messages.

    Each byte is read once, no matter how the stream is split. The returned messages are safe for
    thriftpy2's decoder. After a `Malformed` the inbox must not be used any more: the stream does
    not show where the next message begins.

    Args:
        kinds: the kinds of messages that are accepted.
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
        """The received bytes that are not part of a returned message."""
        return bytes(self._data)

    def feed(self, data: bytes) -> None:
        """Add bytes that were received."""
        self._data += data

    def messages(self, data: bytes) -> Iterator[Message]:
        """Add bytes that were received; iterate over the messages that they complete.

        Raises:
            Malformed: as `take`.
        """
        self.feed(data)
        while (message := self.take()) is not None:
            yield message

    def take(self) -> Message | None:
        """Remove and return the next whole message; None if more bytes are needed.

        Raises:
            Malformed: the bytes are not a message, or exceed the bounds.
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
        kind = first & 0xFF
        if kind not in self._kinds:
            raise Malformed(f"a message of type {kind} is not taken here")
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
        return (MessageType(kind), name, seqid)
