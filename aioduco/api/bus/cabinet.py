"""The cabinet's RS-485 port (manual 1.3.6)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.bus.octets import octets, write
from aioduco.api.section import Section
from aioduco.models import ranges

if TYPE_CHECKING:
    from aioduco.models.rules import BytesLike, Whole

__all__ = ["CabinetPort"]


class CabinetPort(Section):
    """The cabinet's RS-485 port (485 端口, manual 1.3.6)."""

    __slots__ = ()

    async def set_baudrate_485(self, value: Whole) -> None:
        """Set the bit rate of the cabinet's RS-485 port (设置 485 波特率).

        This is the cabinet's port; the wire has no such function for the tool's port.

        Args:
            value: bits a second, a whole number from 1. The manual lists no rates.

        Raises:
            ParameterError: the rate is out of range; nothing was sent.
            TaskError, Refused: the rate was not set.

        Manual section 1.3.6.
        """
        value_ = ranges.BAUD_RATE("value", value)
        await self._finish(calls.set_baudrate_485(value_, True))

    async def read_raw_data_485(self, len: Whole) -> bytes:  # noqa: A002  # the manual's name
        """Take bytes out of the buffer of the cabinet's port (485 读取原生数据).

        Args:
            len: maximum number of bytes, a whole number from 1.

        Returns:
            The bytes; empty if none have arrived.

        Raises:
            ParameterError: the number is out of range; nothing was sent.
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.

        Manual section 1.3.6.
        """
        len_ = ranges.READ_LENGTH("len", len)
        return octets(await self._rpc.read_raw_data_485(len_))

    async def read_raw_data_485_h(
        self,
        head: BytesLike,
        len: Whole,  # noqa: A002  # the manual's name
    ) -> bytes:
        """Take a frame that begins with a head from the cabinet's port (485 匹配头).

        On one arm this returned nothing where `read_raw_data_485` returned bytes.

        Args:
            head: the bytes that the frame begins with, at least one.
            len: length of the frame, a whole number from 1.

        Returns:
            The frame; empty if none has arrived.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.

        Manual section 1.3.6.
        """
        head_, len_ = ranges.BYTES("head", head), ranges.READ_LENGTH("len", len)
        return octets(await self._rpc.read_raw_data_485_h(head_, len_))

    async def read_raw_data_485_ht(self, head: BytesLike, tail: BytesLike) -> bytes:
        """Take a frame between a head and a tail from the cabinet's port (485 匹配头和尾).

        Args:
            head: the bytes that the frame begins with, at least one.
            tail: the bytes that it ends with, at least one.

        Returns:
            The frame; empty if none has arrived.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.

        Manual section 1.3.6.
        """
        head_, tail_ = ranges.BYTES("head", head), ranges.BYTES("tail", tail)
        return octets(await self._rpc.read_raw_data_485_ht(head_, tail_))

    async def write_raw_data_485(self, data: BytesLike) -> None:
        """Write bytes to the cabinet's port (485 写原生数据).

        Args:
            data: the bytes, at least one.

        Raises:
            ParameterError: `data` is empty, or contains a value that is not a byte; nothing was
                sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        data_ = ranges.BYTES("data", data)
        await write(self._rpc, calls.write_raw_data_485(data_))

    async def write_raw_data_485_h(self, data: BytesLike, head: BytesLike) -> None:
        """Write bytes with a head before them to the cabinet's port (485 写原生数据, 加头).

        Args:
            data: the bytes, at least one.
            head: the bytes that are put before the data, at least one.

        Raises:
            ParameterError: an argument is empty, or contains a value that is not a byte; nothing
                was sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        data_, head_ = ranges.BYTES("data", data), ranges.BYTES("head", head)
        await write(self._rpc, calls.write_raw_data_485_h(data_, head_))

    async def write_raw_data_485_ht(
        self, data: BytesLike, head: BytesLike, tail: BytesLike
    ) -> None:
        """Write bytes between a head and a tail to the cabinet's port (485 写原生数据, 加头和尾).

        Args:
            data: the bytes, at least one.
            head: the bytes that are put before the data, at least one.
            tail: the bytes that are put behind the data, at least one.

        Raises:
            ParameterError: an argument is empty, or contains a value that is not a byte; nothing
                was sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        data_, head_ = ranges.BYTES("data", data), ranges.BYTES("head", head)
        tail_ = ranges.BYTES("tail", tail)
        await write(self._rpc, calls.write_raw_data_485_ht(data_, head_, tail_))

    async def read_data_485(self) -> bytes:
        """Take bytes out of the buffer of the cabinet's port.

        Not in the manual. It is not known how it differs from `read_raw_data_485`, or how many
        bytes it returns.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.
        """
        return octets(await self._rpc.read_data_485())

    async def write_data_485(self, data: BytesLike) -> None:
        """Write bytes to the cabinet's port.

        Not in the manual. It is not known how it differs from `write_raw_data_485`.

        Args:
            data: the bytes, at least one.

        Raises:
            ParameterError: `data` is empty, or contains a value that is not a byte; nothing was
                sent.
            BusError: the bytes were not written.
        """
        data_ = ranges.BYTES("data", data)
        await write(self._rpc, calls.write_data_485(data_))
