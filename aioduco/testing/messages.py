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

__all__ = ["Kind", "Message", "MessageError", "MessageParser", "application_error"]

_VERSION: Final = 0x80010000
_VERSION_MASK: Final = 0xFFFF0000

#: longest name of a function and deepest nesting of a body that are taken for sense
_NAME_LIMIT: Final = 256
_DEPTH_LIMIT: Final = 128

_STOP: Final = 0
_STRING: Final = 11
_STRUCT: Final = 12
_MAP: Final = 13
_SET: Final = 14
_LIST: Final = 15
#: bytes of a bool, byte, double, i16, i32, i64
_FIXED: Final = {2: 1, 3: 1, 4: 8, 6: 2, 8: 4, 10: 8}
_TYPES: Final = frozenset({*_FIXED, _STRING, _STRUCT, _MAP, _SET, _LIST})


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
    body = struct.pack("!bhI", _STRING, 1, len(said)) + said + struct.pack("!bhib", 8, 2, code, 0)
    return Message(Kind.EXCEPTION, call.name, call.seqid, body)


class _Run:
    """Elements of a container that are still to come; a map's keys and values take turns."""

    __slots__ = ("left", "types")

    def __init__(self, types: tuple[int, ...], left: int) -> None:
        self.types = types
        self.left = left


class MessageParser:
    """Finds whole messages in a stream of bytes.

    Each byte is looked at once, however the stream is cut. After a `MessageError` the parser is
    of no more use: nothing in the stream says where the next message would begin.
    """

    def __init__(self, limit: int = 16 << 20) -> None:
        """Make a parser.

        Args:
            limit: most bytes that one message may have.
        """
        self._limit = limit
        self._bytes = bytearray()
        self._at = 0
        self._body = 0
        self._head: tuple[Kind, str, int] | None = None
        #: what is open in the body, innermost last: the type of a value, or a container's rest
        self._open: list[int | _Run] = []
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
        if self._head is None and not self._header():
            return None
        if not self._skip():
            if len(self._bytes) > self._limit:
                raise MessageError(f"a message of more than {self._limit} bytes")
            return None
        assert self._head is not None
        message = Message(*self._head, bytes(self._bytes[self._body : self._at]))
        del self._bytes[: self._at]
        self._at = 0
        self._head = None
        return message

    def _header(self) -> bool:
        if len(self._bytes) < 4:
            return False
        (version,) = struct.unpack_from("!I", self._bytes)
        if version & _VERSION_MASK != _VERSION or version & 0xFF not in _KINDS:
            raise MessageError(f"a message cannot begin with {version:#010x}")
        if len(self._bytes) < 8:
            return False
        (length,) = struct.unpack_from("!I", self._bytes, 4)
        if not 0 < length <= _NAME_LIMIT:
            raise MessageError(f"a function's name cannot have {length} bytes")
        if len(self._bytes) < length + 12:
            return False
        try:
            name = self._bytes[8 : 8 + length].decode()
        except UnicodeDecodeError as exc:
            raise MessageError("a function's name is not UTF-8") from exc
        (seqid,) = struct.unpack_from("!i", self._bytes, 8 + length)
        self._head = (Kind(version & 0xFF), name, seqid)
        self._at = self._body = length + 12
        self._open = [_STRUCT]
        return True

    def _skip(self) -> bool:
        """Go on through the body; whether its end is reached.

        Invariant: `_at` is where the innermost open thing goes on. It may lie beyond the bytes
        that have come, when it was moved over a string or an array.
        """
        while self._open:
            inner = self._open[-1]
            if isinstance(inner, _Run):
                if inner.left == 0:
                    self._open.pop()
                    continue
                inner.left -= 1
                self._open.append(inner.types[inner.left % len(inner.types)])
                continue
            if not self._value(inner):
                return False
        return self._at <= len(self._bytes)

    def _value(self, kind: int) -> bool:
        """Go past a value of this type, or open what is in it; whether there were bytes to."""
        if kind in _FIXED:
            self._leave(_FIXED[kind])
            return True
        if kind == _STRUCT:
            return self._field()
        if kind != _STRING:
            return self._container(head=6 if kind == _MAP else 5)
        if not self._there(4):
            return False
        self._leave(4 + self._count(self._at))
        return True

    def _field(self) -> bool:
        if not self._there(1):
            return False
        kind = self._bytes[self._at]
        if kind == _STOP:
            self._leave(1)
            return True
        if not self._there(3):
            return False
        self._at += 3
        self._enter(kind, (kind,))
        return True

    def _container(self, head: int) -> bool:
        if not self._there(head):
            return False
        types = tuple(self._bytes[self._at : self._at + head - 4])
        left = self._count(self._at + head - 4) * len(types)
        if all(inner in _FIXED for inner in types):
            self._leave(head + left * sum(_FIXED[inner] for inner in types) // len(types))
        else:
            self._leave(head)
            # left counts down, so a map's key comes when it is odd
            self._enter(_Run(types[::-1], left), types if left else ())
        return True

    def _there(self, size: int) -> bool:
        return len(self._bytes) - self._at >= size

    def _leave(self, size: int) -> None:
        self._open.pop()
        self._at += size
        if self._at > self._limit:
            raise MessageError(f"a message of more than {self._limit} bytes")

    def _enter(self, inner: int | _Run, types: tuple[int, ...]) -> None:
        if not _TYPES.issuperset(types):
            raise MessageError(f"no value can be of a type of {types}")
        if len(self._open) >= _DEPTH_LIMIT:
            raise MessageError(f"a body nested more than {_DEPTH_LIMIT} deep")
        self._open.append(inner)

    def _count(self, at: int) -> int:
        (count,) = struct.unpack_from("!i", self._bytes, at)
        if not 0 <= count <= self._limit:
            raise MessageError(f"a length cannot be {count}")
        return int(count)
