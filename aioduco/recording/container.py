"""Reads the records of an MCAP file from its beginning, up to the first damaged one.

A file that was cut off, because its program was killed or the disk was full, ends in the middle of
a record and has no index. The records before that are read, and `McapFile.complete` is false; so it
is with a file that is damaged elsewhere. A chunk is used only if its checksum is right.

A file may come from a stranger. Guarantee: what it claims allocates nothing, and what it unpacks to
is bounded by its own size, and by 4 GiB: a file that wants more is refused before it is read on.
The file itself is read record by record, so a large one takes no memory by itself.
"""

from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, BinaryIO, Final, NamedTuple

from aioduco.errors import MissingExtra, RecordingError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path


MAGIC: Final = b"\x89MCAP0\r\n"
HEADER, SCHEMA, CHANNEL, MESSAGE, CHUNK, METADATA, DATA_END = 1, 3, 4, 5, 6, 0x0C, 0x0F
#: kinds of records that are read outside of chunks
_USED: Final = (SCHEMA, CHANNEL, MESSAGE, CHUNK, METADATA, DATA_END)

_RECORD: Final = struct.Struct("<BQ")
_MESSAGE: Final = struct.Struct("<HIQQ")
_CHUNK: Final = struct.Struct("<QQQI")
_NUMBER: Final = struct.Struct("<H")
_NUMBERS: Final = struct.Struct("<HH")
_LENGTH: Final = struct.Struct("<I")
#: maximum bytes of an unpacked chunk; a chunk that claims more is damaged
_LARGEST: Final = 1 << 28
#: bytes of memory that any file may take, those for each byte of the file, and most of all
_ALWAYS, _PER_BYTE, _MOST = 1 << 28, 100, 1 << 32
#: bytes of memory that a message takes beside its content
_MESSAGE_COST: Final = 512
#: times above are no nanoseconds since 1970, and fit into no array
_LATEST: Final = 1 << 63


@dataclass(frozen=True, slots=True)
class McapSchema:
    """The format of a channel's messages."""

    name: str
    encoding: str
    data: bytes


@dataclass(frozen=True, slots=True)
class McapChannel:
    """A channel: its topic, and how its messages are encoded."""

    topic: str
    encoding: str
    schema: McapSchema | None


class McapMessage(NamedTuple):
    """A message as it is in the file.

    Attributes:
        channel: its channel.
        time_ns: its time, nanoseconds since 1970.
        data: its bytes.
    """

    channel: McapChannel
    time_ns: int
    data: memoryview

    def __reduce__(self) -> tuple[object, ...]:
        return _message, (self.channel, self.time_ns, bytes(self.data))


def _message(channel: McapChannel, time_ns: int, data: bytes) -> McapMessage:
    return McapMessage(channel, time_ns, memoryview(data))


class _Damaged(Exception):
    """A record is incomplete, or is not as the format requires."""


class McapFile:
    """The records of one file.

    Attributes:
        metadata: texts by the name of their record, as far as they were read.
        complete: whether the file was read to its proper end.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._schemas: dict[int, McapSchema] = {}
        self._channels: dict[int, McapChannel] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.complete: bool = False
        self._left = 0

    def messages(self) -> Iterator[McapMessage]:
        """Iterate over the messages, in the order of the file.

        Raises:
            RecordingError: the file cannot be opened, or is not an MCAP file.
        """
        try:
            with self._path.open("rb") as file:
                if file.read(len(MAGIC)) != MAGIC:
                    raise RecordingError(
                        f"{self._path} is no recording: it does not begin as MCAP files do"
                    )
                size = os.fstat(file.fileno()).st_size
                self._left = min(_ALWAYS + _PER_BYTE * size, _MOST)
                yield from self._records(file, size)
        except OSError as exc:
            why = exc.strerror or exc
            raise RecordingError(f"{self._path} cannot be read: {why}") from exc
        except _Damaged:
            return

    def _records(self, file: BinaryIO, size: int) -> Iterator[McapMessage]:
        for kind, record in _top_records(file, size):
            if kind == DATA_END:
                file.seek(size - len(MAGIC))
                self.complete = file.read() == MAGIC  # without it, the summary was cut off
                return
            if kind != CHUNK:
                self._spend(len(record))
            if kind == METADATA:
                name, at = _text(record, 0)
                self.metadata[name] = _texts(record, at)
            elif kind == CHUNK:
                for inner, part in _split(self._unpacked(record)):
                    if (message := self._take(inner, part)) is not None:
                        yield message
            elif (message := self._take(kind, record)) is not None:
                yield message

    def _take(self, kind: int, record: memoryview) -> McapMessage | None:
        """Process a record of a kind that may be in a chunk; return the message, if it is one."""
        if kind == MESSAGE:
            number, _, log_time, _ = _unpack_from(_MESSAGE, record)
            channel = self._channels.get(number)
            if channel is None or log_time >= _LATEST:
                raise _Damaged
            self._spend(_MESSAGE_COST)
            return McapMessage(channel, log_time, record[_MESSAGE.size :])
        if kind == SCHEMA:
            (number,) = _unpack_from(_NUMBER, record)
            name, at = _text(record, 2)
            encoding, at = _text(record, at)
            self._schemas[number] = McapSchema(name, encoding, bytes(record[at + 4 :]))
        elif kind == CHANNEL:
            number, schema = _unpack_from(_NUMBERS, record)
            topic, at = _text(record, 4)
            encoding, _ = _text(record, at)
            self._channels[number] = McapChannel(topic, encoding, self._schemas.get(schema))
        return None

    def _spend(self, size: int) -> None:
        """Count memory that the file takes."""
        self._left -= size
        if self._left < 0:
            raise RecordingError(
                f"{self._path} unpacks to more than {_MOST >> 30} GiB, or to more than "
                f"{_ALWAYS >> 20} MiB and {_PER_BYTE} times its own size, which no recording of an "
                "arm does: it was not read. Take the part that you need out of a longer one first, "
                "such as by `mcap filter`"
            )

    def _unpacked(self, record: memoryview) -> memoryview:
        """Return the records of a chunk."""
        _, _, size, crc = _unpack_from(_CHUNK, record)
        compression, at = _text(record, _CHUNK.size)
        packed = record[at + 8 :]
        if size > _LARGEST:
            raise _Damaged
        self._spend(size)
        chunk = _unpack(self._path, compression)(packed, size)
        if crc and zlib.crc32(chunk) != crc:
            raise _Damaged
        return memoryview(chunk)


def _unpack(path: Path, compression: str) -> Callable[[memoryview, int], bytes]:
    """Return a function that unpacks a chunk; it raises `_Damaged` if the chunk is damaged."""
    if compression == "":
        return lambda packed, _: bytes(packed)
    if compression != "zstd":
        raise RecordingError(f"{path} is packed by {compression}: only zstd and none are read")
    with MissingExtra.named("a recording", "record"):
        import zstandard  # noqa: PLC0415 - an extra

    def unpack(packed: memoryview, size: int) -> bytes:
        try:
            # the frame's own claim is what would be allocated
            if zstandard.frame_content_size(packed) not in (-1, size):
                raise _Damaged
            return zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
        except (zstandard.ZstdError, MemoryError) as exc:
            raise _Damaged from exc

    return unpack


def _top_records(file: BinaryIO, size: int) -> Iterator[tuple[int, memoryview]]:
    """Iterate over the records of a file, from where it stands; those of other kinds are left out.

    Raises `_Damaged` at an incomplete one, and at one that is larger than any is.
    """
    while head := file.read(_RECORD.size):
        if len(head) < _RECORD.size:
            raise _Damaged
        kind, length = _RECORD.unpack(head)
        if length > size - file.tell():
            raise _Damaged
        if kind not in _USED:
            file.seek(length, os.SEEK_CUR)
            continue
        data = file.read(length) if length <= _LARGEST else b""
        if len(data) < length:
            raise _Damaged
        yield kind, memoryview(data)


def _split(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Iterate over the records in the bytes; raises `_Damaged` at an incomplete one."""
    at = 0
    while at < len(data):
        kind, length = _unpack_from(_RECORD, data, at)
        at += _RECORD.size
        if length > len(data) - at:
            raise _Damaged
        yield kind, data[at : at + length]
        at += length


def _unpack_from(layout: struct.Struct, data: memoryview, at: int = 0) -> tuple[Any, ...]:
    """As `Struct.unpack_from`; raises `_Damaged` if the data ends before."""
    if layout.size > len(data) - at:
        raise _Damaged
    return layout.unpack_from(data, at)


def _text(record: memoryview, at: int) -> tuple[str, int]:
    """Return a text that has its length before it, and the position of its end."""
    (length,) = _unpack_from(_LENGTH, record, at)
    at += _LENGTH.size
    if length > len(record) - at:
        raise _Damaged
    try:
        return str(record[at : at + length], "utf-8"), at + length
    except UnicodeDecodeError as exc:
        raise _Damaged from exc


def _texts(record: memoryview, at: int) -> dict[str, str]:
    (length,) = _unpack_from(_LENGTH, record, at)
    at += _LENGTH.size
    end, found = at + length, {}
    while at < end:
        key, at = _text(record, at)
        found[key], at = _text(record, at)
    return found
