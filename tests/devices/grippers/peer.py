"""A gripper whose frames pymodbus decodes and encodes: an independent second opinion on ours."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable

from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU, ModbusPDU
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersResponse,
    WriteMultipleRegistersResponse,
    WriteSingleRegisterResponse,
)


class Peer:
    """Registers behind pymodbus's framer, and the controller's buffer before it.

    Attributes:
        registers: by address.
        frames: the requests, as they came.
        written: what was written, in order: the first address, and the values.
        after_write: called after each write, with the number of reads since set to 0.
        before_read: called before each read, with how many there were since the last write.
        spoil: changes an answer on its way; empty for none.
    """

    def __init__(self, unit: int) -> None:
        self.unit = unit
        self.registers: dict[int, int] = defaultdict(int)
        self.frames: list[bytes] = []
        self.written: list[tuple[int, list[int]]] = []
        self.before_read: Callable[[int], None] = lambda _: None
        self.spoil: Callable[[bytes], bytes] = bytes
        self._framer = FramerRTU(DecodePDU(True))
        self._reads = 0
        self._buffer = b""

    async def write(self, data: bytes) -> None:
        """A request comes over the bus."""
        frame = bytes(data)
        self.frames.append(frame)
        used, request = self._framer.handleFrame(frame, self.unit, 0)
        assert used == len(frame)
        assert request is not None
        answer = self._answer(request)
        answer.dev_id = self.unit
        self._buffer += self.spoil(self._framer.buildFrame(answer))

    async def read(self, count: int) -> bytes:
        """What has come is asked for."""
        given, self._buffer = self._buffer[:count], self._buffer[count:]
        return given

    def _answer(self, request: ModbusPDU) -> ModbusPDU:
        address = request.address
        if request.function_code == 3:
            self.before_read(self._reads)
            self._reads += 1
            values = [self.registers[address + i] for i in range(request.count)]
            return ReadHoldingRegistersResponse(registers=values)
        values = list(request.registers)
        self.written.append((address, values))
        self._reads = 0
        for i, value in enumerate(values):
            self.registers[address + i] = value
        if request.function_code == 6:
            return WriteSingleRegisterResponse(address=address, registers=values)
        assert request.function_code == 16
        return WriteMultipleRegistersResponse(address=address, count=len(values))
