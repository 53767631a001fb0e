"""Frames of Modbus RTU: encoding and decoding, without I/O or clock.

`Request.answer` checks the bytes that have arrived so far. It returns the answer, or None if more
bytes are needed, or raises an error for a wrong answer. Modbus over serial line, version 1.02;
Modbus application protocol, version 1.1b3.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

from aioduco.errors import ModbusGarbled, ModbusRefused

if TYPE_CHECKING:
    from collections.abc import Sequence


#: unit, function, exception's code, checksum
_SHORTEST = 5
#: unit, function, address, value or number, checksum
_ECHO = 8
_ERROR = 0x80

_MEANINGS = {
    1: "it does not have this function",
    2: "it does not have this register",
    3: "it does not take this value",
    4: "it failed while it did it",
    5: "it has taken it, and needs longer",
    6: "it is busy",
}
_UNLISTED = "whose meaning is the device's own"


class FunctionCode(IntEnum):
    """Function codes of Modbus that are used here."""

    READ_HOLDING = 0x03
    READ_INPUT = 0x04
    WRITE_ONE = 0x06
    WRITE = 0x10


def crc16(data: bytes) -> int:
    """Compute the checksum of Modbus RTU: polynomial 0xA001, beginning with 0xFFFF."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


def framed(body: bytes) -> bytes:
    """Add the checksum, its low byte first."""
    return body + struct.pack("<H", crc16(body))


@dataclass(frozen=True, slots=True)
class Request:
    """A request, and the check of its answer.

    Attributes:
        unit: number of the device, 1 to 247.
        function: function code.
        body: bytes after unit and function, without the checksum.
        count: number of registers in the answer to a read; 0 for a write.
    """

    unit: int
    function: FunctionCode
    body: bytes
    count: int = 0

    @property
    def frame(self) -> bytes:
        """The bytes to send."""
        return framed(bytes((self.unit, self.function)) + self.body)

    @property
    def length(self) -> int:
        """Length of the answer, if it is no exception."""
        return _SHORTEST + 2 * self.count if self.count else _ECHO

    def _length(self, got: bytes) -> int:
        """Return the length of the answer, or the minimum length while it is unknown."""
        return _SHORTEST if len(got) < 2 or got[1] & _ERROR else self.length

    def missing_bytes(self, got: bytes) -> int:
        """Return the minimum number of missing bytes; 0 when the answer is complete."""
        return max(0, self._length(got) - len(got))

    def answer(self, got: bytes) -> tuple[int, ...] | None:
        """Check and decode the answer.

        Args:
            got: the bytes that have arrived so far.

        Returns:
            The registers, empty for a write; None while bytes are missing.

        Raises:
            ModbusRefused: the answer is an exception of the device.
            ModbusGarbled: the bytes are not an answer to this request.
        """
        if got and got[0] != self.unit:
            raise self._garbled(got, f"it begins with {got[0]}, not with the device's number")
        if len(got) >= 2 and got[1] & ~_ERROR != self.function:
            raise self._garbled(got, f"it answers another function, {got[1]:#04x}")
        if self.missing_bytes(got):
            return None
        if len(got) != self._length(got):
            raise self._garbled(got, f"it has {len(got)} bytes instead of {self._length(got)}")
        if framed(got[:-2]) != got:
            raise self._garbled(got, "its checksum is wrong")
        if got[1] & _ERROR:
            raise ModbusRefused(self.function, got[2], _MEANINGS.get(got[2], _UNLISTED))
        if not self.count:
            # The answer to a write has its address, and the value or the number of registers.
            if got[2:6] != self.body[:4]:
                raise self._garbled(got, "it speaks of other registers or another value")
            return ()
        if got[2] != 2 * self.count:
            raise self._garbled(got, f"it says {got[2]} bytes instead of {2 * self.count}")
        return struct.unpack(f">{self.count}H", got[3:-2])

    def _garbled(self, got: bytes, why: str) -> ModbusGarbled:
        return ModbusGarbled(
            f"the answer of device {self.unit} to function {self.function:#04x}, "
            f"{got.hex(' ')}, is none: {why}"
        )


def read(unit: int, address: int, count: int, function: FunctionCode) -> Request:
    """Make a request to read 1 to 125 consecutive registers."""
    return Request(unit, function, struct.pack(">HH", address, count), count)


def write_one(unit: int, address: int, value: int) -> Request:
    """Make a request to write a register."""
    return Request(unit, FunctionCode.WRITE_ONE, struct.pack(">HH", address, value))


def write(unit: int, address: int, values: Sequence[int]) -> Request:
    """Make a request to write 1 to 123 consecutive registers."""
    count = len(values)
    head = struct.pack(">HHB", address, count, 2 * count)
    return Request(unit, FunctionCode.WRITE, head + struct.pack(f">{count}H", *values))
