"""Bytes as the wire carries them: signed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.errors import BusError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["octets", "written"]


def octets(wire: Sequence[int]) -> bytes:
    """Bytes that came as signed numbers."""
    return bytes(value & 0xFF for value in wire)


def written(function: str, answer: bool) -> None:
    """Check what a function that writes to a bus returned.

    Raises:
        BusError: it is not true.
    """
    if not answer:
        raise BusError(function)
