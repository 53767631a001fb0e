"""Structs to bytes and back, by thriftpy2.

Most calls need none of it: arguments of fixed width, and results of numbers, are packed and read by
formats of `struct`. thriftpy2 takes longer to load than the rest of this package, so `codec` loads
this module for the first value that needs it. Import it beforehand where a call may not be late.
"""

from __future__ import annotations

from typing import Any

from thriftpy2.protocol import TCyBinaryProtocol
from thriftpy2.thrift import TApplicationException, TDecodeException
from thriftpy2.transport import TCyMemoryBuffer

__all__ = ["TApplicationException", "TDecodeException", "read_struct", "write_struct"]

#: thriftpy2 has type hints for half of its functions only
_protocol: Any = TCyBinaryProtocol


def write_struct(value: object) -> bytes:
    """Encode a struct whose class has a `thrift_spec`.

    Raises:
        TDecodeException: a value does not fit its type.
    """
    # a new buffer for each call: a signal handler may encode a stop in the middle of another call
    buffer = TCyMemoryBuffer()
    _protocol(buffer).write_struct(value)
    encoded: bytes = buffer.getvalue()
    return encoded


def read_struct(data: bytes, into: object) -> None:
    """Decode a struct that is complete, and set the attributes of the fields that it has."""
    _protocol(TCyMemoryBuffer(data)).read_struct(into)
