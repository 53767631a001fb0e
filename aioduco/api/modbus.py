"""Signals over Modbus (manual 1.3.9)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import LOOKS, Section
from aioduco.errors import ParameterError, Refused
from aioduco.models import ranges

if TYPE_CHECKING:
    from aioduco.models.rules import Whole, WholesLike


class Modbus(Section):
    """Signals that the controller exchanges over Modbus (Modbus, manual 1.3.9).

    A signal is a register or a coil of a device. It has a name in the controller, which polls it.
    For Modbus over the tool's RS-485 see `robot.bus`.
    """

    __slots__ = ()

    async def modbus_read(self, signal_name: str) -> int:
        """Read the last value of a signal that the controller polled (读取 modbus 节点).

        Args:
            signal_name: its name.

        Returns:
            0 to 65535 for a register, 0 or 1 for a coil or an input.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller answers -1: there is no such signal, or its device does not
                answer.

        Manual section 1.3.9.
        """
        name_ = ranges.LONG_NAME("signal_name", signal_name)
        value = await self._read_checked(calls.modbus_read(name_), name_, lambda value: value == -1)
        if value == -1:  # no register and no coil has this value
            raise Refused("modbus_read", value, "there is no such signal, or its device is away")
        return value

    async def modbus_write(self, signal_name: str, value: Whole) -> None:
        """Write a signal (modbus 节点写操作).

        Args:
            signal_name: its name.
            value: 0 to 65535 for a register, 0 or 1 for a coil.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not written.

        Manual section 1.3.9.
        """
        name_ = ranges.LONG_NAME("signal_name", signal_name)
        value_ = ranges.MODBUS_VALUE("value", value)
        await self._finish(calls.modbus_write(name_, value_))

    async def modbus_set_frequency(self, signal_name: str, frequency: Whole) -> None:
        """Set how often the controller reads a signal (刷新频率).

        Args:
            signal_name: its name.
            frequency: polls per second, 1 to 100 [Hz]; the controller's default is 10.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: the controller lists an error: there is no such signal. The wire has no answer
                to this function, so the error list is the only sign of a failure.

        Manual section 1.3.9.
        """
        name_ = ranges.LONG_NAME("signal_name", signal_name)
        frequency_ = ranges.MODBUS_FREQUENCY("frequency", frequency)
        call, why = calls.modbus_set_frequency(name_, frequency_), ""
        for _ in range(LOOKS):
            _, why = await self._send_listed(call, name_)
            if not why:
                return
        raise Refused(call.name, None, why)

    async def modbus_write_multiple_regs(
        self, slave_num: Whole, name: str, word_list: WholesLike
    ) -> None:
        """Write consecutive registers (多寄存器写操作).

        The name of a signal selects the device and the first address; `slave_num` selects the unit
        at that device. Registers are written whatever the signal is: the manual's examples write
        registers and coils of two units by one name. The manual does not say more.

        Args:
            slave_num: number of the unit, 0 to 255.
            name: name of a signal at the first register's address.
            word_list: values to write, at least one, each 0 to 65535, or -32768 to -1 for the
                upper half.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: the registers were not written.

        Manual section 1.3.9.
        """
        unit, name_ = ranges.MODBUS_UNIT("slave_num", slave_num), ranges.LONG_NAME("name", name)
        words = ranges.MODBUS_WORDS("word_list", word_list)
        await self._accept(calls.modbus_write_multiple_regs(unit, name_, len(words), words))

    async def modbus_write_multiple_coils(
        self, slave_num: Whole, name: str, byte_list: WholesLike
    ) -> None:
        """Write consecutive coils (多线圈写操作).

        Device, unit and first address are selected as in `modbus_write_multiple_regs`.

        Args:
            slave_num: number of the unit, 0 to 255.
            name: name of a signal at the first coil's address.
            byte_list: values to write, at least one, each 0 or 1.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: the coils were not written.

        Manual section 1.3.9.
        """
        unit, name_ = ranges.MODBUS_UNIT("slave_num", slave_num), ranges.LONG_NAME("name", name)
        coils = ranges.MODBUS_COILS("byte_list", byte_list)
        if not coils:
            raise ParameterError("byte_list", byte_list, "at least one, each 0 or 1")
        await self._accept(calls.modbus_write_multiple_coils(unit, name_, len(coils), coils))

    async def modbus_add_signal(
        self,
        ip: str,
        slave_number: Whole,
        signal_address: Whole,
        signal_type: Whole,
        signal_name: str,
    ) -> None:
        """Add a signal to those that the controller exchanges.

        Not in the manual: the meaning of the types' numbers is not known.

        Args:
            ip: address of the device.
            slave_number: number of the device, 0 to 255.
            signal_address: address of the register or coil, 0 to 65535.
            signal_type: number of the type.
            signal_name: name for the signal.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not added.
        """
        await self._accept(
            calls.modbus_add_signal(
                ranges.LONG_NAME("ip", ip),
                ranges.MODBUS_UNIT("slave_number", slave_number),
                ranges.MODBUS_VALUE("signal_address", signal_address),
                ranges.INT_32("signal_type", signal_type),
                ranges.LONG_NAME("signal_name", signal_name),
            )
        )

    async def modbus_delete_signal(self, signal_name: str) -> None:
        """Remove a signal from those that the controller exchanges.

        Not in the manual.

        Args:
            signal_name: its name.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            TaskError, Refused: it was not deleted.
        """
        name_ = ranges.LONG_NAME("signal_name", signal_name)
        await self._accept(calls.modbus_delete_signal(name_))
