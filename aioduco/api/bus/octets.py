"""Conversion of the wire's bytes, which are signed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.errors import BusError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import AsyncRpc, WireCall

__all__ = ["octets", "write"]


def octets(wire: Sequence[int]) -> bytes:
    """Convert the wire's signed numbers to bytes."""
    return bytes(value & 0xFF for value in wire)


async def write(rpc: AsyncRpc, call: WireCall[bool]) -> None:
    """Call a function that writes to a bus.

    Raises:
        BusError: it answers that it did not.
    """
    if not await rpc.send(call):
        raise BusError(call.name)
