"""Modbus: a scripted slave, with RTU frames for an RS-485 port, and the controller's signals."""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import TypeVar

T = TypeVar("T")

_BROADCAST = 0
_ILLEGAL_FUNCTION, _ILLEGAL_ADDRESS, _ILLEGAL_VALUE = 1, 2, 3


class NoAnswer(Exception):
    """A signal is not defined, its slave does not answer, or answers with an exception."""


class ModbusSlave:
    """Coils, inputs and registers by address; those that are not given do not exist.

    Args:
        coils: outputs of one bit.
        inputs: inputs of one bit.
        registers: holding registers, 16 bits without a sign.
        input_registers: read-only registers.
    """

    def __init__(
        self,
        *,
        coils: dict[int, bool] | None = None,
        inputs: dict[int, bool] | None = None,
        registers: dict[int, int] | None = None,
        input_registers: dict[int, int] | None = None,
    ) -> None:
        self.coils: dict[int, bool] = dict(coils or {})
        self.inputs: dict[int, bool] = dict(inputs or {})
        self.registers: dict[int, int] = dict(registers or {})
        self.input_registers: dict[int, int] = dict(input_registers or {})

    def write_coils(self, address: int, values: list[bool]) -> None:
        """Set coils from an address on.

        Raises:
            KeyError: One of them does not exist; none is set.
        """
        _write(self.coils, address, values)

    def write_registers(self, address: int, values: list[int]) -> None:
        """Set holding registers from an address on.

        Raises:
            KeyError: One of them does not exist; none is set.
        """
        _write(self.registers, address, values)


class RtuSlave(ModbusSlave):
    """A slave at an RS-485 port: answers RTU frames of its unit, and nothing else.

    Args:
        unit: its number, 1 to 247.
        coils: the coils that it has, by address.
        inputs: its discrete inputs.
        registers: its holding registers.
        input_registers: its input registers.
    """

    def __init__(
        self,
        unit: int = 1,
        *,
        coils: dict[int, bool] | None = None,
        inputs: dict[int, bool] | None = None,
        registers: dict[int, int] | None = None,
        input_registers: dict[int, int] | None = None,
    ) -> None:
        super().__init__(
            coils=coils, inputs=inputs, registers=registers, input_registers=input_registers
        )
        self.unit = unit

    def receive(self, data: bytes) -> bytes | None:
        """Answer a frame; None if it is broken, a broadcast, or for another unit."""
        if len(data) < 4 or crc16(data[:-2]) != data[-2:] or data[0] not in (self.unit, _BROADCAST):
            return None
        try:
            answer = self._answer(data[1], data[2:-2])
        except KeyError:
            answer = bytes([data[1] | 0x80, _ILLEGAL_ADDRESS])
        except (ValueError, struct.error):
            answer = bytes([data[1] | 0x80, _ILLEGAL_VALUE])
        if data[0] == _BROADCAST:
            return None
        frame = bytes([self.unit]) + answer
        return frame + crc16(frame)

    def _answer(self, function: int, body: bytes) -> bytes:
        """Answer one request without unit and checksum."""
        if function in (1, 2):
            address, count = _counted(body, 2000)
            bits = self.coils if function == 1 else self.inputs
            packed = _pack([bits[address + i] for i in range(count)])
            return bytes([function, len(packed)]) + packed
        if function in (3, 4):
            address, count = _counted(body, 125)
            words = self.registers if function == 3 else self.input_registers
            values = [words[address + i] for i in range(count)]
            return bytes([function, 2 * count]) + struct.pack(f">{count}H", *values)
        if function == 5:
            address, value = struct.unpack(">HH", body)
            if value not in (0, 0xFF00):
                raise ValueError("a coil is set by 0 or 0xFF00")
            self.write_coils(address, [value == 0xFF00])
            return bytes([function]) + body
        if function == 6:
            address, value = struct.unpack(">HH", body)
            self.write_registers(address, [value])
            return bytes([function]) + body
        if function in (15, 16):
            address, count = _counted(body[:4], 1968 if function == 15 else 123)
            if len(body) < 5 or body[4] != len(body) - 5:
                raise ValueError("the count of bytes is wrong")
            if function == 15:
                self.write_coils(address, _unpack(body[5:], count))
            else:
                self.write_registers(address, list(struct.unpack(f">{count}H", body[5:])))
            return bytes([function]) + body[:4]
        return bytes([function | 0x80, _ILLEGAL_FUNCTION])


class ScriptedGripper(RtuSlave):
    """A gripper at the tool with the registers of a DH gripper; it reaches each position at once.

    It has no fingers in the scene, unlike `Simulator(gripper=...)`.

    Args:
        unit: its number.
        object_at: position, 0 to 1000, at which it meets an object; None for no object.
    """

    INITIALISE, FORCE, POSITION, SPEED = 0x0100, 0x0101, 0x0103, 0x0104
    INITIALISED, GRIPPING, ACTUAL = 0x0200, 0x0201, 0x0202

    def __init__(self, unit: int = 1, object_at: int | None = None) -> None:
        names = (self.INITIALISE, self.FORCE, self.POSITION, self.SPEED)
        state = (self.INITIALISED, self.GRIPPING, self.ACTUAL)
        super().__init__(unit, registers=dict.fromkeys((*names, *state), 0))
        self.object_at = object_at

    def write_registers(self, address: int, values: list[int]) -> None:
        """Write registers and run the command: initialise, or move (position 1000 is open)."""
        if address + len(values) > self.INITIALISED:
            raise KeyError(address)  # the state is read-only
        super().write_registers(address, values)
        written = range(address, address + len(values))
        if self.INITIALISE in written:
            self.registers[self.INITIALISED] = 1
        if self.POSITION in written and self.registers[self.INITIALISED]:
            goal, stop = self.registers[self.POSITION], self.object_at
            holds = stop is not None and goal < stop
            self.registers[self.ACTUAL] = stop if stop is not None and holds else goal
            self.registers[self.GRIPPING] = 2 if holds else 1


class ModbusKind(IntEnum):
    """Kind of a signal. The numbers are an assumption: manual 3.8 has no modbus_add_signal."""

    INPUT = 0
    COIL = 1
    INPUT_REGISTER = 2
    REGISTER = 3


@dataclass(slots=True)
class ModbusSignal:
    """One signal of the controller's Modbus.

    Attributes:
        ip: address of its device.
        unit: number of the slave at it.
        address: of the coil, input or register.
        kind: which of these it is.
        frequency: how often it is read [Hz].
        value: value that was read last.
        due: time from which it is read again [s].
    """

    ip: str
    unit: int
    address: int
    kind: ModbusKind
    frequency: int = 10
    value: int = 0
    due: float = float("-inf")


class ModbusSignals:
    """The controller's signals by name, and its slaves.

    Attributes:
        slaves: by IP address and unit number.
    """

    def __init__(self) -> None:
        self.slaves: dict[tuple[str, int], ModbusSlave] = {}
        self._signals: dict[str, ModbusSignal] = {}

    def add(self, name: str, signal: ModbusSignal) -> None:
        """Define a signal.

        Raises:
            ValueError: The name is empty or taken, or the address is not valid.
        """
        if not name or name in self._signals:
            raise ValueError(f"a signal must have a name of its own, not {name!r}")
        if not 0 <= signal.address <= 0xFFFF or not 0 <= signal.unit <= 255:
            raise ValueError(f"there is no address {signal.address} of slave {signal.unit}")
        self._signals[name] = signal

    def delete(self, name: str) -> None:
        """Delete a signal.

        Raises:
            NoAnswer: There is no signal of this name.
        """
        self._signal(name)
        del self._signals[name]

    def set_frequency(self, name: str, frequency: int) -> None:
        """Set how often a signal is read, 1 to 100 Hz.

        Raises:
            NoAnswer: There is no signal of this name.
            ValueError: The frequency is out of range.
        """
        signal = self._signal(name)
        if not 1 <= frequency <= 100:
            raise ValueError(f"frequency is {frequency}, but must be from 1 to 100 Hz")
        signal.frequency, signal.due = frequency, float("-inf")

    def restart(self) -> None:
        """Begin a run: every signal is read again."""
        for signal in self._signals.values():
            signal.due = float("-inf")

    def read(self, name: str, time: float) -> int:
        """Read a signal's value, not older than its period.

        Raises:
            NoAnswer: There is no such signal, or its slave does not answer.
        """
        signal = self._signal(name)
        if time >= signal.due:
            slave = self._slave(name, signal)
            banks: tuple[dict[int, bool] | dict[int, int], ...] = (
                slave.inputs, slave.coils, slave.input_registers, slave.registers,
            )  # fmt: skip
            bank = banks[signal.kind]
            if signal.address not in bank:
                raise NoAnswer(f"the slave of {name!r} has no address {signal.address}")
            signal.value = int(bank[signal.address])
            signal.due = time + 1.0 / signal.frequency
        return signal.value

    def write(self, name: str, value: int) -> None:
        """Write to a signal.

        Raises:
            NoAnswer: There is no such signal, or its slave does not answer.
            ValueError: It cannot be written, or the value does not fit.
        """
        signal = self._signal(name)
        if signal.kind not in (ModbusKind.COIL, ModbusKind.REGISTER):
            raise ValueError(f"{name!r} cannot be written: its kind is {signal.kind.name.lower()}")
        self._write(name, signal, [value])
        signal.due = float("-inf")

    def write_several(self, name: str, unit: int, kind: ModbusKind, values: list[int]) -> None:
        """Write coils or registers that follow each other, at the device of a signal.

        Args:
            name: name of the signal; its address is that of the first coil or register.
            unit: number of the slave at the device.
            kind: coil or register, whatever the kind of the signal.
            values: the values to write.

        Raises:
            NoAnswer: There is no such signal, or the slave does not answer.
            ValueError: A value does not fit, or there are no values.
        """
        signal = self._signal(name)
        self._write(name, replace(signal, unit=unit, kind=kind), values)
        signal.due = float("-inf")

    def _write(self, name: str, signal: ModbusSignal, values: list[int]) -> None:
        highest = 1 if signal.kind is ModbusKind.COIL else 0xFFFF
        if not values or not all(0 <= value <= highest for value in values):
            raise ValueError(f"{values} must be whole numbers from 0 to {highest}")
        slave = self._slave(name, signal)
        try:
            if signal.kind is ModbusKind.COIL:
                slave.write_coils(signal.address, [bool(value) for value in values])
            else:
                slave.write_registers(signal.address, values)
        except KeyError as exc:
            raise NoAnswer(f"the slave of {name!r} has no address {exc}") from None

    def _signal(self, name: str) -> ModbusSignal:
        if name not in self._signals:
            raise NoAnswer(f"there is no Modbus signal {name!r}")
        return self._signals[name]

    def _slave(self, name: str, signal: ModbusSignal) -> ModbusSlave:
        slave = self.slaves.get((signal.ip, signal.unit))
        if slave is None:
            raise NoAnswer(f"the slave of {name!r}, {signal.unit} at {signal.ip}, does not answer")
        return slave


def crc16(data: bytes) -> bytes:
    """The checksum that follows an RTU frame."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return crc.to_bytes(2, "little")


def _write(bank: dict[int, T], address: int, values: list[T]) -> None:
    addresses = range(address, address + len(values))
    for each in addresses:
        if each not in bank:
            raise KeyError(each)
    bank.update(zip(addresses, values, strict=True))


def _counted(body: bytes, most: int) -> tuple[int, int]:
    address, count = struct.unpack(">HH", body)
    if not 1 <= count <= most:
        raise ValueError(f"{count} is not from 1 to {most}")
    return address, count


def _pack(bits: list[bool]) -> bytes:
    number = sum(1 << i for i, bit in enumerate(bits) if bit)
    return number.to_bytes((len(bits) + 7) // 8, "little")


def _unpack(packed: bytes, count: int) -> list[bool]:
    if len(packed) != (count + 7) // 8:
        raise ValueError("the count of bytes is wrong")
    number = int.from_bytes(packed, "little")
    return [bool(number >> i & 1) for i in range(count)]
