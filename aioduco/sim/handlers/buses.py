"""RS-485, CAN and Modbus (manual 1.3.6 and 1.3.9)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.models.enums import TaskState
from aioduco.sim.cabinet.modbus import ModbusKind, ModbusSignal, NoAnswer
from aioduco.sim.handlers.base import HandlerSection, task
from aioduco.sim.refusal import Rejected, mismatch

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.sim.cabinet.ports import SerialPort
    from aioduco.sim.controller.state_machine import Controller


Octets = list[int]
#: answer if nothing was read; no register and no coil has this value
_NOT_READ = -1


class BusHandlers(HandlerSection):
    """The RS-485 ports of the cabinet and of the tool, the CAN bus, the Modbus master.

    Bytes are signed on the wire.
    """

    @task()
    def set_baudrate_485(self, _: Controller, value: int) -> None:
        """设置 485 的波特率: the cabinet's port."""
        self._cabinet.serial.baudrate = _rate(value)

    def read_raw_data_485(self, len: int) -> Octets:  # noqa: A002 - the name on the wire
        """Read up to `len` bytes."""
        return self._receive(self._cabinet.serial, lambda port: port.read(len))

    def read_raw_data_485_h(self, head: Sequence[int], len: int) -> Octets:  # noqa: A002 - as above
        """Read a frame that begins with a head."""
        return self._receive(self._cabinet.serial, lambda port: port.read_framed(_bytes(head), len))

    def read_raw_data_485_ht(self, head: Sequence[int], tail: Sequence[int]) -> Octets:
        """Read a frame from a head to a tail."""
        ends = _bytes(head), _bytes(tail)
        return self._receive(self._cabinet.serial, lambda port: port.read_between(*ends))

    def read_data_485(self) -> Octets:
        """Read all bytes that have arrived; on the wire, not in the manual."""
        return self._receive(self._cabinet.serial, lambda port: port.read())

    def write_raw_data_485(self, data: Sequence[int]) -> bool:
        """485 写原生数据."""
        return self._send(self._cabinet.serial, data)

    def write_raw_data_485_h(self, data: Sequence[int], head: Sequence[int]) -> bool:
        """Write a head, then the data."""
        return self._send(self._cabinet.serial, head, data)

    def write_raw_data_485_ht(
        self, data: Sequence[int], head: Sequence[int], tail: Sequence[int]
    ) -> bool:
        """Write a head, the data, then a tail."""
        return self._send(self._cabinet.serial, head, data, tail)

    def write_data_485(self, data: Sequence[int]) -> bool:
        """The same as write_raw_data_485; on the wire, not in the manual."""
        return self._send(self._cabinet.serial, data)

    def tool_read_raw_data_485(self, len: int) -> Octets:  # noqa: A002 - the name on the wire
        """Read up to `len` bytes."""
        return self._receive(self._cabinet.tool_serial, lambda port: port.read(len))

    def tool_read_raw_data_485_h(self, head: Sequence[int], len: int) -> Octets:  # noqa: A002 - as above
        """Read a frame that begins with a head."""
        return self._receive(
            self._cabinet.tool_serial, lambda port: port.read_framed(_bytes(head), len)
        )

    def tool_read_raw_data_485_ht(self, head: Sequence[int], tail: Sequence[int]) -> Octets:
        """Read a frame from a head to a tail."""
        ends = _bytes(head), _bytes(tail)
        return self._receive(self._cabinet.tool_serial, lambda port: port.read_between(*ends))

    def tool_read_data_485(self) -> Octets:
        """Read all bytes that have arrived; on the wire, not in the manual."""
        return self._receive(self._cabinet.tool_serial, lambda port: port.read())

    def tool_write_raw_data_485(self, data: Sequence[int]) -> bool:
        """末端 485 写原生数据."""
        return self._send(self._cabinet.tool_serial, data)

    def tool_write_raw_data_485_h(self, data: Sequence[int], head: Sequence[int]) -> bool:
        """Write a head, then the data."""
        return self._send(self._cabinet.tool_serial, head, data)

    def tool_write_raw_data_485_ht(
        self, data: Sequence[int], head: Sequence[int], tail: Sequence[int]
    ) -> bool:
        """Write a head, the data, then a tail."""
        return self._send(self._cabinet.tool_serial, head, data, tail)

    def tool_write_data_485(self, data: Sequence[int]) -> bool:
        """The same as tool_write_raw_data_485; on the wire, not in the manual."""
        return self._send(self._cabinet.tool_serial, data)

    def _receive(self, port: SerialPort, read: Callable[[SerialPort], bytes]) -> Octets:
        with self._cabinet.lock:
            port.advance(self._runtime.snapshot.time)
            return _octets(read(port))

    def _send(self, port: SerialPort, *parts: Sequence[int]) -> bool:
        with self._cabinet.lock:
            return port.write(b"".join(map(_bytes, parts)), self._runtime.snapshot.time)

    @task()
    def set_baudrate_can(self, _: Controller, value: int) -> None:
        """设置 CAN 的波特率."""
        self._cabinet.can.bitrate = _rate(value)

    def read_raw_data_can(self) -> Octets:
        """Read a frame: its identifier, cut to the lowest byte if it is longer, then its data."""
        with self._cabinet.lock:
            frame = self._cabinet.can.read()
        return [] if frame is None else _octets(bytes([frame[0] & 0xFF]) + frame[1])

    def read_data_can(self) -> Octets:
        """The same as read_raw_data_can; on the wire, not in the manual."""
        return self.read_raw_data_can()

    def write_raw_data_can(self, id: int, data: Sequence[int]) -> bool:  # noqa: A002 - as on the wire
        """Send a frame."""
        with self._cabinet.lock:
            return self._cabinet.can.write(id, _bytes(data))

    def write_data_can(self, id: int, data: Sequence[int]) -> bool:  # noqa: A002 - as on the wire
        """The same as write_raw_data_can; on the wire, not in the manual."""
        return self.write_raw_data_can(id, data)

    def modbus_add_signal(
        self, ip: str, slave_number: int, signal_address: int, signal_type: int, signal_name: str
    ) -> int:
        """Define a signal; on the wire, not in the manual."""

        def change() -> None:
            kind = ModbusKind(signal_type)
            self._cabinet.modbus.add(
                signal_name, ModbusSignal(ip, slave_number, signal_address, kind)
            )

        return self._change("modbus_add_signal", change)

    def modbus_delete_signal(self, signal_name: str) -> int:
        """Delete a signal; on the wire, not in the manual."""
        return self._change(
            "modbus_delete_signal", lambda: self._cabinet.modbus.delete(signal_name)
        )

    def modbus_read(self, signal_name: str) -> int:
        """读取 modbus 节点的数据."""
        try:
            with self._cabinet.lock:
                return self._cabinet.modbus.read(signal_name, self._runtime.snapshot.time)
        except NoAnswer as exc:
            return self._invalid_arguments("modbus_read", exc, _NOT_READ)

    def modbus_write(self, signal_name: str, value: int) -> int:
        """对 modbus 节点进行写操作."""
        return self._change("modbus_write", lambda: self._cabinet.modbus.write(signal_name, value))

    def modbus_set_frequency(self, signal_name: str, frequence: int) -> None:
        """修改 modbus 节点的刷新频率 [Hz]."""
        self._change(
            "modbus_set_frequency",
            lambda: self._cabinet.modbus.set_frequency(signal_name, frequence),
        )

    def modbus_write_multiple_regs(
        self,
        slave_num: int,
        name: str,
        len: int,  # noqa: A002 - as on the wire
        word_list: Sequence[int],
    ) -> int:
        """对多寄存器进行写操作; words are signed on the wire."""
        words = [word & 0xFFFF for word in word_list]
        return self._several(
            "modbus_write_multiple_regs", slave_num, name, len, words, ModbusKind.REGISTER
        )

    def modbus_write_multiple_coils(
        self,
        slave_num: int,
        name: str,
        len: int,  # noqa: A002 - as on the wire
        byte_list: Sequence[int],
    ) -> int:
        """对多线圈进行写操作."""
        coils = list(byte_list)
        return self._several(
            "modbus_write_multiple_coils", slave_num, name, len, coils, ModbusKind.COIL
        )

    def _several(
        self, function: str, slave: int, name: str, length: int, values: list[int], kind: ModbusKind
    ) -> int:
        def change() -> None:
            if length != len(values):
                raise ValueError(f"len is {length}, but there are {len(values)} values")
            self._cabinet.modbus.write_several(name, slave, kind, values)

        return self._change(function, change)

    def _change(self, name: str, change: Callable[[], None]) -> int:
        wrong: Rejected | None = None
        # Without the controller's lock: a slave may use the simulator's methods, which need it.
        try:
            with self._cabinet.lock:
                change()
        except ValueError as exc:
            wrong = mismatch(str(exc))
        except NoAnswer as exc:
            wrong = Rejected(TaskState.ERROR, str(exc))

        def command(_: Controller) -> None:
            if wrong is not None:
                raise wrong

        return self._task(name, True, command)


def _rate(value: int) -> int:
    if value < 1:
        raise mismatch(f"value is {value}, but must be from 1 bit/s")
    return value


def _bytes(octets: Sequence[int]) -> bytes:
    return bytes(octet & 0xFF for octet in octets)


def _octets(data: bytes) -> Octets:
    return [octet - 256 if octet > 127 else octet for octet in data]
