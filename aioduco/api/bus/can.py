"""The CAN bus (manual 1.3.6)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from aioduco._wire.rpc import calls
from aioduco.api.bus.octets import octets, write
from aioduco.api.section import Section
from aioduco.models import ranges

if TYPE_CHECKING:
    from aioduco.models.rules import BytesLike, Whole

__all__ = ["CanBus", "CanFrame"]


class CanFrame(NamedTuple):
    """A frame that came over the CAN bus.

    Attributes:
        id: the lowest eight bits of the sender's identifier; the wire carries no more.
        data: its bytes.
    """

    id: int
    data: bytes


class CanBus(Section):
    """The CAN bus (CAN 总线, manual 1.3.6)."""

    __slots__ = ()

    async def set_baudrate_can(self, value: Whole) -> None:
        """Set the bit rate of the CAN bus (设置 CAN 波特率).

        Args:
            value: bits a second, a whole number from 1. The manual lists no rates.

        Raises:
            ParameterError: the rate is out of range; nothing was sent.
            TaskError, Refused: the rate was not set.

        Manual section 1.3.6.
        """
        value_ = ranges.BAUD_RATE("value", value)
        await self._finish(calls.set_baudrate_can(value_, True))

    async def read_raw_data_can(self) -> CanFrame | None:
        """Take a frame out of the buffer of the CAN bus (读取一帧 CAN 数据).

        Returns:
            The frame; None if none has arrived.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: a frame may be lost.

        Manual section 1.3.6.
        """
        data = octets(await self._rpc.read_raw_data_can())
        return CanFrame(data[0], data[1:]) if data else None

    async def write_raw_data_can(self, id: Whole, data: BytesLike) -> None:  # noqa: A002
        """Write a frame to the CAN bus (CAN 写原生数据).

        Args:
            id: its identifier, 0 to 0x1FFFFFFF.
            data: its bytes; a frame may have none.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            BusError: the frame was not written.

        Manual section 1.3.6.
        """
        id_, data_ = ranges.CAN_ID("id", id), ranges.CAN_DATA("data", data)
        await write(self._rpc, calls.write_raw_data_can(id_, data_))

    async def read_data_can(self) -> bytes:
        """Take bytes out of the buffer of the CAN bus.

        Not in the manual. It is not known how it differs from `read_raw_data_can`, or whether an
        identifier comes first. So the bytes are returned unchanged.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.
        """
        return octets(await self._rpc.read_data_can())

    async def write_data_can(self, id: Whole, data: BytesLike) -> None:  # noqa: A002
        """Write a frame to the CAN bus.

        Not in the manual. It is not known how it differs from `write_raw_data_can`.

        Args:
            id: its identifier, 0 to 0x1FFFFFFF.
            data: its bytes; a frame may have none.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            BusError: the frame was not written.
        """
        id_, data_ = ranges.CAN_ID("id", id), ranges.CAN_DATA("data", data)
        await write(self._rpc, calls.write_data_can(id_, data_))
