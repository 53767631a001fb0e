"""Modbus RTU over RS-485: a device at the tool, such as a gripper.

Guarantees:
- One request at a time: a second caller waits until the first request was answered or has failed.
- The answer to an earlier request is not taken for the answer to this one: one that was cancelled,
  or for which other bytes came, is waited for until as many bytes as it has have come, or its
  time-out is over, and old bytes in the controller's buffer are discarded.
  A read's answer that comes after its time-out is not told from that of the next read of as many
  registers: nothing in it says which ones it has.
- A request is never sent twice.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final
from weakref import WeakKeyDictionary

import anyio

from aioduco._process.copying import Uncopied
from aioduco.devices.bus import frames
from aioduco.errors import (
    Described,
    ModbusError,
    ModbusGarbled,
    ModbusRefused,
    ModbusTimeout,
    ParameterError,
)
from aioduco.models import ranges
from aioduco.models.rules import Integer, Signed, Whole, WholesLike

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.api.bus import Bus
    from aioduco.devices.bus.frames import Request


_SOURCE = "Modbus application protocol 1.1b3"
_UNIT = Integer(1, 247, source="Modbus over serial line 1.02")
_WORD = Integer(0, 0xFFFF, source=_SOURCE)
_WORDS = Signed(16, "words", source=_SOURCE)
_READ_COUNT = Integer(1, 125, "registers", source=_SOURCE)
_MOST_WRITTEN = 123

#: number of bytes per read while the buffer is emptied; the longest frame has 256
_DRAIN_CHUNK = 256


class _Line:
    """What the devices on one bus share.

    Attributes:
        lock: held by the request that is under way.
        owed: a request that was given up, and may still be answered; None if there is none.
        come: number of bytes that have come for it.
        until: time up to which it may be answered, of `time.monotonic` [s].
    """

    def __init__(self) -> None:
        self.lock = anyio.Lock()
        self.owed: Request | None = None
        self.come = 0
        self.until = 0.0


#: by the section of a robot: the lines at its tool and at its cabinet
_lines: Final[WeakKeyDictionary[Bus, tuple[_Line, _Line]]] = WeakKeyDictionary()


@dataclass(frozen=True, slots=True)
class Port:
    """A serial port, given by its functions for writing and reading.

    Attributes:
        write: function that writes bytes.
        read: function that returns at once up to the given number of received bytes; empty if none
            have arrived.
    """

    write: Callable[[bytes], Awaitable[None]]
    read: Callable[[int], Awaitable[bytes]]
    _line: _Line = field(default_factory=_Line, repr=False, compare=False)

    @classmethod
    def tool(cls, bus: Bus) -> Port:
        """Return the tool's RS-485 port, from `robot.bus`."""
        return cls(bus.tool_write_raw_data_485, bus.tool_read_raw_data_485, _at(bus)[0])

    @classmethod
    def cabinet(cls, bus: Bus) -> Port:
        """Return the cabinet's RS-485 port, from `robot.bus`."""
        return cls(bus.write_raw_data_485, bus.read_raw_data_485, _at(bus)[1])


def _at(bus: Bus) -> tuple[_Line, _Line]:
    return _lines.setdefault(bus, (_Line(), _Line()))


class ModbusRtu(Uncopied):
    """A device that speaks Modbus RTU.

        gripper = ModbusRtu(Port.tool(robot.bus), unit=1)
        await gripper.write_register(0x0103, 500)
        (position,) = await gripper.read_registers(0x0202)

    Bit rate and parity of the tool's port must match the device: the wire has no function that
    sets them. Requests to the devices at a port of a robot wait for each other, drivers of grippers
    included; at a port of your own, those of devices that were made with the same `Port`.

    Args:
        port: the port to which the device is connected.
        unit: number of the device, 1 to 247.
        timeout: seconds within which it must answer, not including the emptying of the buffer. Not
            less than the device needs: a later answer could be taken for that of the next read.
        poll: seconds between two polls for the answer.

    Raises:
        ParameterError: an argument is out of range.
    """

    def __init__(
        self, port: Port, unit: Whole, *, timeout: float = 0.5, poll: float = 0.01
    ) -> None:
        self._port = port
        self._unit = _UNIT("unit", unit)
        self._timeout = ranges.TIMEOUT("timeout", timeout)
        self._poll = ranges.TIMEOUT("poll", poll)
        self._line = port._line

    def __repr__(self) -> str:
        return f"<ModbusRtu device {self._unit}>"

    def device(self, unit: Whole) -> ModbusRtu:
        """Make another device on the same bus; the requests of the two wait for each other.

        Args:
            unit: its number, 1 to 247.
        """
        return ModbusRtu(self._port, unit, timeout=self._timeout, poll=self._poll)

    async def read_registers(self, address: Whole, count: Whole = 1) -> tuple[int, ...]:
        """Read consecutive holding registers (function 0x03).

        Args:
            address: address of the first, 0 to 0xFFFF.
            count: number of registers, 1 to 125.

        Returns:
            Their values, 0 to 0xFFFF each.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            ModbusError: the answer is missing or wrong: one of the subclasses.
            BusError: the controller could not write to the bus.
        """
        return await self._read(address, count, frames.FunctionCode.READ_HOLDING)

    async def read_inputs(self, address: Whole, count: Whole = 1) -> tuple[int, ...]:
        """Read consecutive input registers (function 0x04).

        Args:
            address: address of the first, 0 to 0xFFFF.
            count: number of registers, 1 to 125.

        Returns:
            Their values, 0 to 0xFFFF each.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            ModbusError: the answer is missing or wrong: one of the subclasses.
            BusError: the controller could not write to the bus.
        """
        return await self._read(address, count, frames.FunctionCode.READ_INPUT)

    async def _read(
        self, address: Whole, count: Whole, function: frames.FunctionCode
    ) -> tuple[int, ...]:
        first, many = _WORD("address", address), _READ_COUNT("count", count)
        return await self._exchange(frames.read(self._unit, first, many, function))

    async def write_register(self, address: Whole, value: Whole) -> None:
        """Write a register (function 0x06).

        Args:
            address: its address, 0 to 0xFFFF.
            value: its value, 0 to 0xFFFF.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            ModbusError: the answer is missing or wrong: one of the subclasses. Unless it is
                `ModbusRefused`, the register may have been written.
            BusError: the controller could not write to the bus.
        """
        request = frames.write_one(self._unit, _WORD("address", address), _WORD("value", value))
        await self._exchange(request)

    async def write_registers(self, address: Whole, values: WholesLike) -> None:
        """Write consecutive registers (function 0x10).

        Args:
            address: address of the first, 0 to 0xFFFF.
            values: their values, 0 to 0xFFFF each, or -0x8000 to -1 for the same bits; 1 to 123.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            ModbusError: the answer is missing or wrong: one of the subclasses. Unless it is
                `ModbusRefused`, the registers may have been written.
            BusError: the controller could not write to the bus.
        """
        words = [value & 0xFFFF for value in _WORDS("values", values)]
        if len(words) > _MOST_WRITTEN:
            raise ParameterError(
                "values", Described(f"{len(words)} values"), f"at most {_MOST_WRITTEN}"
            )
        await self._exchange(frames.write(self._unit, _WORD("address", address), words))

    async def _exchange(self, request: Request) -> tuple[int, ...]:
        line = self._line
        async with line.lock:
            await self._wait_out()
            await self._drain()
            line.owed, line.come = request, 0
            line.until = time.monotonic() + self._timeout
            try:
                await self._port.write(request.frame)
                line.until = time.monotonic() + self._timeout
                answer = await self._answer(request)
            except ModbusRefused:
                line.owed = None
                raise
            line.owed = None
            return answer

    async def _wait_out(self) -> None:
        """Wait until a request that was given up is not answered any more."""
        line, owed = self._line, self._line.owed
        while owed and line.come < owed.length and time.monotonic() < line.until:
            try:
                await self._answer(owed)
            except ModbusGarbled:  # a part of its answer was taken before
                continue
            except ModbusError:
                pass
            break
        line.owed = None

    async def _drain(self) -> None:
        """Discard the old bytes in the controller's buffer."""
        until = time.monotonic() + self._timeout
        while left := await self._port.read(_DRAIN_CHUNK):
            if time.monotonic() >= until:
                raise ModbusGarbled(
                    f"the bus does not fall silent: bytes came for {self._timeout:g} s without a "
                    f"request, the last of them {left[-8:].hex(' ')}; nothing was sent"
                )

    async def _answer(self, request: Request) -> tuple[int, ...]:
        due, until = time.monotonic(), self._line.until
        got = b""
        while True:
            # Read no more than the missing bytes: bytes after the answer belong to no request.
            got += (piece := await self._port.read(request.missing_bytes(got)))
            self._line.come += len(piece)
            answer = request.answer(got)
            if answer is not None:
                return answer
            now = time.monotonic()
            if now >= until:
                come = f"only {got.hex(' ')} came" if got else "nothing came"
                raise ModbusTimeout(
                    f"device {self._unit} did not answer function {request.function:#04x} within "
                    f"{self._timeout:g} s: {come}"
                )
            due = max(due + self._poll, now)
            await anyio.sleep(due - now)
