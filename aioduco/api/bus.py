"""RS-485 of the cabinet and of the tool, and CAN (can 及 485 总线, manual 1.3.6)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from aioduco._wire.rpc import WireCall, calls
from aioduco.api.section import Section
from aioduco.errors import BusError
from aioduco.models import ranges

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rules import BytesLike, Whole


class CanFrame(NamedTuple):
    """A frame that came over the CAN bus.

    Attributes:
        id: the lowest eight bits of the sender's identifier; the wire carries no more.
        data: its bytes.
    """

    id: int
    data: bytes


class Bus(Section):
    """RS-485 of the cabinet and of the tool, and CAN (can 及 485 总线, manual 1.3.6).

        await robot.bus.tool_write_raw_data_485(b"\\x01\\x06\\x01\\x00\\x00\\x01\\x49\\xf6")
        answer = await robot.bus.tool_read_raw_data_485(8)

    Functions take bytes as `bytes` or as numbers; 255 and -1 are the same byte. They return
    `bytes`. Data from a bus stays in the controller's buffer until it is read. Before a request
    whose answer matters, read until the buffer is empty.
    """

    __slots__ = ("__weakref__",)

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
        return _octets(await self._rpc.read_raw_data_485(len_))

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
        return _octets(await self._rpc.read_raw_data_485_h(head_, len_))

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
        return _octets(await self._rpc.read_raw_data_485_ht(head_, tail_))

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
        await self._write(calls.write_raw_data_485(data_))

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
        await self._write(calls.write_raw_data_485_h(data_, head_))

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
        await self._write(calls.write_raw_data_485_ht(data_, head_, tail_))

    async def read_data_485(self) -> bytes:
        """Take bytes out of the buffer of the cabinet's port.

        Not in the manual. It is not known how it differs from `read_raw_data_485`, or how many
        bytes it returns.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.
        """
        return _octets(await self._rpc.read_data_485())

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
        await self._write(calls.write_data_485(data_))

    async def tool_read_raw_data_485(self, len: Whole) -> bytes:  # noqa: A002  # the manual's name
        """Take bytes out of the buffer of the tool's port (末端 485 读取原生数据).

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
        return _octets(await self._rpc.tool_read_raw_data_485(len_))

    async def tool_read_raw_data_485_h(
        self,
        head: BytesLike,
        len: Whole,  # noqa: A002  # the manual's name
    ) -> bytes:
        """Take a frame that begins with a head from the tool's port (末端 485 匹配头).

        On one arm this returned nothing where `tool_read_raw_data_485` returned bytes.

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
        return _octets(await self._rpc.tool_read_raw_data_485_h(head_, len_))

    async def tool_read_raw_data_485_ht(self, head: BytesLike, tail: BytesLike) -> bytes:
        """Take a frame between a head and a tail from the tool's port (末端 485 匹配头和尾).

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
        return _octets(await self._rpc.tool_read_raw_data_485_ht(head_, tail_))

    async def tool_write_raw_data_485(self, data: BytesLike) -> None:
        """Write bytes to the tool's port (末端 485 写原生数据).

        Args:
            data: the bytes, at least one.

        Raises:
            ParameterError: `data` is empty, or contains a value that is not a byte; nothing was
                sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        data_ = ranges.BYTES("data", data)
        await self._write(calls.tool_write_raw_data_485(data_))

    async def tool_write_raw_data_485_h(self, data: BytesLike, head: BytesLike) -> None:
        """Write bytes with a head before them to the tool's port (末端 485 写原生数据, 加头).

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
        await self._write(calls.tool_write_raw_data_485_h(data_, head_))

    async def tool_write_raw_data_485_ht(
        self, data: BytesLike, head: BytesLike, tail: BytesLike
    ) -> None:
        """Write bytes between a head and a tail to the tool's port (末端 485 写原生数据, 加头和尾).

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
        await self._write(calls.tool_write_raw_data_485_ht(data_, head_, tail_))

    async def tool_read_data_485(self) -> bytes:
        """Take bytes out of the buffer of the tool's port.

        Not in the manual. It is not known how it differs from `tool_read_raw_data_485`, or how
        many bytes it returns.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.
        """
        return _octets(await self._rpc.tool_read_data_485())

    async def tool_write_data_485(self, data: BytesLike) -> None:
        """Write bytes to the tool's port.

        Not in the manual. It is not known how it differs from `tool_write_raw_data_485`.

        Args:
            data: the bytes, at least one.

        Raises:
            ParameterError: `data` is empty, or contains a value that is not a byte; nothing was
                sent.
            BusError: the bytes were not written.
        """
        data_ = ranges.BYTES("data", data)
        await self._write(calls.tool_write_data_485(data_))

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
        data = _octets(await self._rpc.read_raw_data_can())
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
        await self._write(calls.write_raw_data_can(id_, data_))

    async def read_data_can(self) -> bytes:
        """Take bytes out of the buffer of the CAN bus.

        Not in the manual. It is not known how it differs from `read_raw_data_can`, or whether an
        identifier comes first. So the bytes are returned unchanged.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.
        """
        return _octets(await self._rpc.read_data_can())

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
        await self._write(calls.write_data_can(id_, data_))

    async def _write(self, call: WireCall[bool]) -> None:
        """Call a function that writes to a bus.

        Raises:
            BusError: it answers that it did not.
        """
        if not await self._rpc.send(call):
            raise BusError(call.name)


def _octets(wire: Sequence[int]) -> bytes:
    """Convert the wire's signed numbers to bytes."""
    return bytes(value & 0xFF for value in wire)
