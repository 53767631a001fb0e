"""Messages of the strict binary protocol written by hand, without any Thrift library.

What an older client sends cannot be made by a library that loads the present IDL, and a mistake
that two libraries share would not show. So this knows nothing but the protocol's own rules.
"""

from __future__ import annotations

import socket
import struct
from dataclasses import dataclass
from typing import Any, Self

VERSION_1 = 0x80010000
CALL, REPLY, EXCEPTION = 1, 2, 3
STOP = 0
KINDS = {"bool": 2, "i8": 3, "double": 4, "i16": 6, "i32": 8, "i64": 10, "string": 11}
STRUCT, LIST = 12, 15

#: the fields of a struct: (id, type, value)
Fields = list[tuple[int, str, Any]]


def kind(of: str) -> int:
    """The number of a type on the wire; a name that is no type is a struct."""
    if of.startswith("list<"):
        return LIST
    return KINDS.get(of, STRUCT)


def value(of: str, given: Any) -> bytes:
    """One value as bytes. A struct is given as its fields."""
    if of.startswith("list<"):
        inner = of[5:-1]
        head = struct.pack("!bi", kind(inner), len(given))
        return head + b"".join(value(inner, item) for item in given)
    if of == "string":
        text: bytes = given.encode()
        return struct.pack("!i", len(text)) + text
    if of in KINDS:
        form = {"bool": "!?", "i8": "!b", "double": "!d", "i16": "!h", "i32": "!i", "i64": "!q"}
        return struct.pack(form[of], given)
    return fields(given)


def fields(given: Fields) -> bytes:
    """The fields of a struct, and its end."""
    body = (struct.pack("!bh", kind(of), fid) + value(of, item) for fid, of, item in given)
    return b"".join(body) + bytes([STOP])


def call(name: str, seqid: int, given: Fields) -> bytes:
    """A whole call."""
    text = name.encode()
    head = struct.pack("!Ii", VERSION_1 | CALL, len(text)) + text + struct.pack("!i", seqid)
    return head + fields(given)


@dataclass(frozen=True)
class Reply:
    """An answer: its head, and the value if it is an i32."""

    name: str
    seqid: int
    kind: int
    value: int | None
    message: str = ""


class RawClient:
    """A socket that sends frames and reads answers with an i32, or with an exception."""

    def __init__(self, host: str, port: int) -> None:
        self._socket = socket.create_connection((host, port), timeout=10)
        self._seqid = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def call(self, name: str, given: Fields) -> Reply:
        """Send one call and return its answer, checked to be the answer of this call."""
        self._seqid += 1
        self._socket.sendall(call(name, self._seqid, given))
        reply = self._reply()
        assert (reply.name, reply.seqid) == (name, self._seqid)
        return reply

    def _reply(self) -> Reply:
        (version,) = self._unpack("!I")
        assert version & 0xFFFF0000 == VERSION_1
        name = self._string()
        (seqid,) = self._unpack("!i")
        number: int | None = None
        message = ""
        while (of := self._read(1)[0]) != STOP:
            self._read(2)  # the field's id
            if of == KINDS["i32"]:
                (number,) = self._unpack("!i")
            elif of == KINDS["string"]:
                message = self._string()
            else:
                raise AssertionError(f"a field of type {of} in the answer of {name}")
        return Reply(name, seqid, version & 0xFF, number, message)

    def _string(self) -> str:
        (length,) = self._unpack("!i")
        return self._read(length).decode()

    def _unpack(self, form: str) -> tuple[Any, ...]:
        return struct.unpack(form, self._read(struct.calcsize(form)))

    def _read(self, size: int) -> bytes:
        parts = b""
        while len(parts) < size:
            part = self._socket.recv(size - len(parts))
            if not part:
                raise ConnectionError("the server closed the connection in mid answer")
            parts += part
        return parts
