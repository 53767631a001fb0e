"""Records of MCAP files, as their bytes, and messages as protobuf's own library reads them."""

from __future__ import annotations

import struct
from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

from aioduco.recording.container import CHANNEL, MAGIC, MESSAGE

__all__ = ["HEAD", "channel", "decoded", "message", "record", "text"]

HEAD = MAGIC + struct.pack("<BQ", 1, 8) + bytes(8)


def record(kind: int, body: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(body)) + body


def text(value: str | bytes) -> bytes:
    data = value.encode() if isinstance(value, str) else value
    return struct.pack("<I", len(data)) + data


def channel(number: int, topic: str) -> bytes:
    return record(CHANNEL, struct.pack("<HH", number, 0) + text(topic) + text("json") + bytes(4))


def message(number: int, data: bytes, at: int = 10**18) -> bytes:
    return record(MESSAGE, struct.pack("<HIQQ", number, 0, at, at) + data)


def decoded(schema: bytes, name: str, data: bytes) -> Any:
    """A message by protobuf's own library, from its schema."""
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(schema).file:
        pool.Add(file)
    found = pool.FindMessageTypeByName(name)
    return message_factory.GetMessageClass(found).FromString(data)
