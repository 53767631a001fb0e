"""Where the messages of the wire begin and end: strict TBinaryProtocol, without a schema.

The parser takes bytes as they come off a socket, in pieces of any size, and gives whole
messages. It does no I/O and needs no Thrift: what it must know of a body is only how to get
past it, which the types in the body itself tell.
"""

from __future__ import annotations

import enum
import struct
from dataclasses import dataclass
from typing import Final

from aioduco._wire.framing import Malformed, StructScanner

__all__ = ["Kind", "Message", "MessageError", "MessageParser", "application_error"]

_VERSION: Final = 0x80010000
_VERSION_MASK: Final = 0xFFFF0000

#: longest name of a function that is taken for one
_NAME_LIMIT: Final = 256

#: types in the body of an application error
_STRING: Final = 11
_I32: Final = 8


class MessageError(ValueError):
    """The bytes are no message of this wire."""


class Kind(enum.IntEnum):
    """Kind of a message."""

    CALL = 1
    REPLY = 2
    EXCEPTION = 3
    ONEWAY = 4


_KINDS: Final = frozenset(int(kind) for kind in Kind)


@dataclass(frozen=True, slots=True)
class Message:
    """One message of the wire.

    Attributes:
        kind: call, reply, exception or one-way call.
        name: the function on the wire.
        seqid: the sequence id that the caller chose.
        body: the encoded struct of arguments or of the result, its stop byte included.
    """

    kind: Kind
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
    return Message(Kind.EXCEPTION, call.name, call.seqid, body)


class MessageParser:
    """Finds whole messages in a stream of bytes.

    Each byte is looked at once, however the stream is cut. After a `MessageError` the parser is
    of no more use: nothing in the stream says where the next message would begin.
    """

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._head: tuple[Kind, str, int] | None = None
        self._body = 0
        self._scanner = StructScanner({}, 0)
        self._wrong: MessageError | None = None

    @property
    def pending(self) -> bytes:
        """The bytes that were fed and are in no message yet."""
        return bytes(self._bytes)

    def feed(self, data: bytes) -> list[Message]:
        """Take more bytes.

        Args:
            data: the next bytes of the stream, any number of them.

        Returns:
            The messages that these bytes complete, oldest first.

        Raises:
            MessageError: the bytes are no message. Messages that came whole before them in
                the same piece are returned first, and the error is raised by the next call.
        """
        self._bytes += data
        found: list[Message] = []
        while self._wrong is None:
            try:
                message = self._message()
            except MessageError as exc:
                self._wrong = exc
                break
            if message is None:
                return found
            found.append(message)
        if not found:
            raise self._wrong
        return found

    def _message(self) -> Message | None:
        if self._head is None:
            self._head = self._header()
        if self._head is None:
            return None
        try:
            whole = self._scanner.whole(self._bytes)
        except Malformed as exc:
            raise MessageError(str(exc)) from exc
        end = self._scanner.position
        if not whole or end > len(self._bytes):
            return None
        message = Message(*self._head, bytes(self._bytes[self._body : end]))
        del self._bytes[:end]
        self._head = None
        return message

    def _header(self) -> tuple[Kind, str, int] | None:
        if len(self._bytes) < 4:
            return None
        (version,) = struct.unpack_from("!I", self._bytes)
        if version & _VERSION_MASK != _VERSION or version & 0xFF not in _KINDS:
            raise MessageError(f"a message cannot begin with {version:#010x}")
        if len(self._bytes) < 8:
            return None
        (length,) = struct.unpack_from("!I", self._bytes, 4)
        if not 0 < length <= _NAME_LIMIT:
            raise MessageError(f"a function's name cannot have {length} bytes")
        self._body = length + 12
        if len(self._bytes) < self._body:
            return None
        try:
            name = self._bytes[8 : 8 + length].decode()
        except UnicodeDecodeError as exc:
            raise MessageError("a function's name is not UTF-8") from exc
        (seqid,) = struct.unpack_from("!i", self._bytes, 8 + length)
        self._scanner = StructScanner({}, self._body)
        return (Kind(version & 0xFF), name, seqid)
