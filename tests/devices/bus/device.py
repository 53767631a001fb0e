"""A device on RS-485: holding registers that answer Modbus RTU, byte by byte as they are asked."""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Callable

from aioduco.devices.bus.frames import framed


class Device:
    """A Modbus device and the buffer of the controller before it.

    Attributes:
        registers: its registers, by address.
        written: what was written to them, in order.
        requests: the frames that came.
        buffer: bytes that wait to be read.
        chunk: how many bytes one read gives at most.
        spoil: changes an answer on its way.
        busy: the exception's code with which everything is refused; 0 for none.
    """

    def __init__(self, unit: int = 1) -> None:
        self.unit = unit
        self.registers: dict[int, int] = defaultdict(int)
        self.written: list[tuple[int, int]] = []
        self.requests: list[bytes] = []
        self.buffer = b""
        self.chunk = 256
        self.spoil: Callable[[bytes], bytes] = bytes
        self.busy = 0

    async def write(self, data: bytes) -> None:
        self.take(bytes(data))

    async def read(self, count: int) -> bytes:
        return self.give(count)

    def take(self, frame: bytes) -> None:
        """A frame comes over the bus."""
        self.requests.append(frame)
        assert framed(frame[:-2]) == frame
        if frame[0] != self.unit:
            return
        self.buffer += self.spoil(framed(bytes((self.unit,)) + self._answer(frame[1:-2])))

    def give(self, count: int) -> bytes:
        """The controller is asked for what has come."""
        count = min(count, self.chunk)
        given, self.buffer = self.buffer[:count], self.buffer[count:]
        return given

    def _answer(self, request: bytes) -> bytes:
        function, address, value = struct.unpack(">BHH", request[:5])
        if self.busy:
            return bytes((function | 0x80, self.busy))
        match function:
            case 3 | 4:
                values = [self.registers[address + i] for i in range(value)]
                return struct.pack(f">BB{value}H", function, 2 * value, *values)
            case 6:
                self._write(address, [value])
            case 16:
                self._write(address, struct.unpack(f">{value}H", request[6:]))
            case _:
                return bytes((function | 0x80, 1))
        return request[:5]

    def _write(self, address: int, values: list[int] | tuple[int, ...]) -> None:
        for offset, value in enumerate(values):
            self.registers[address + offset] = value
            self.written.append((address + offset, value))
