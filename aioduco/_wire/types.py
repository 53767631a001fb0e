"""The numbers of Thrift's types, as in thriftpy2, which is not loaded for them."""

from __future__ import annotations

from typing import Final

__all__ = ["TType"]


class TType:
    """The number of each type on the wire; `STOP` ends a struct."""

    STOP: Final = 0
    BOOL: Final = 2
    BYTE: Final = 3
    DOUBLE: Final = 4
    I16: Final = 6
    I32: Final = 8
    I64: Final = 10
    STRING: Final = 11
    STRUCT: Final = 12
    MAP: Final = 13
    SET: Final = 14
    LIST: Final = 15
