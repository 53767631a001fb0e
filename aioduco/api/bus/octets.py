"""Conversion of the wire's bytes, which are signed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.errors import BusError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["octets", "written"]


def octets(wire: Sequence[int]) -> bytes:
    """Convert the wire's signed numbers to bytes."""
    return bytes(value & 0xFF for value in wire)


def written(function: str, answer: bool) -> None:
    """Check the answer of a function that writes to a bus.

    Raises:
        BusError: the answer is false.
    """
    if not answer:
        raise BusError(function)
