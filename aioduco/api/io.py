"""Digital and analog inputs and outputs (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section
from aioduco.models import ranges

if TYPE_CHECKING:
    from aioduco.models.enums import OutputMode
    from aioduco.models.rules import Real, Whole


class IO(Section):
    """Inputs and outputs of the cabinet and of the tool (manual 1.3.7)."""

    __slots__ = ()

    async def set_standard_digital_out(self, num: int, value: bool) -> None:
        """Set a general output of the cabinet (控制柜通用 IO 输出).

        Args:
            num: number of the output, 1 to 16.
            value: true for high.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: the output was not set.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.STANDARD_IO("num", num), ranges.FLAG("value", value)
        await self._finish(calls.set_standard_digital_out(num_, value_, True))

    async def get_standard_digital_out(self, num: int) -> bool:
        """Read a general output of the cabinet (控制柜通用 IO 输出), 1 to 16.

        Manual section 1.3.7.
        """
        return await self._rpc.get_standard_digital_out(ranges.STANDARD_IO("num", num))

    async def get_standard_digital_in(self, num: int) -> bool:
        """Read a general input of the cabinet (控制柜用户 IO 输入), 1 to 16.

        Manual section 1.3.7.
        """
        return await self._rpc.get_standard_digital_in(ranges.STANDARD_IO("num", num))

    async def set_tool_digital_out(self, num: int, value: bool) -> None:
        """Set an output at the tool (末端 IO 输出).

        Args:
            num: number of the output, 1 or 2.
            value: true for high.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: the output was not set.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.TOOL_IO("num", num), ranges.FLAG("value", value)
        await self._finish(calls.set_tool_digital_out(num_, value_, True))

    async def get_tool_digital_out(self, num: int) -> bool:
        """Read an output at the tool (末端 IO 输出), 1 or 2. Manual section 1.3.7."""
        return await self._rpc.get_tool_digital_out(ranges.TOOL_IO("num", num))

    async def get_tool_digital_in(self, num: int) -> bool:
        """Read an input at the tool (末端 IO 输入), 1 or 2. Manual section 1.3.7."""
        return await self._rpc.get_tool_digital_in(ranges.TOOL_IO("num", num))

    async def get_function_digital_in(self, num: int) -> bool:
        """Read a function input of the cabinet (功能输入 IO), 1 to 8. Manual section 1.3.7."""
        return await self._rpc.get_function_digital_in(ranges.FUNCTION_IO("num", num))

    async def get_function_digital_out(self, num: int) -> bool:
        """Read a function output of the cabinet (功能输出 IO), 1 to 8. Manual section 1.3.7."""
        return await self._rpc.get_function_digital_out(ranges.FUNCTION_IO("num", num))

    async def get_config_digital_in(self, num: Whole) -> bool:
        """Read a configurable input of the cabinet, a whole number from 1.

        Not in the manual: the number of these inputs is not known.
        """
        return await self._rpc.get_config_digital_in(ranges.CONFIG_IO("num", num))

    async def set_digital_output_mode(
        self,
        num: Whole,
        type: OutputMode | int,  # noqa: A002  # the manual's name
        *,
        freq: Whole,
        duty_cycle: Whole,
    ) -> None:
        """Set whether a general output of the cabinet gives a level or pulses (IO 输出信号类型).

        It takes effect at the next `set_standard_digital_out`, which also starts and ends the
        pulses. All pulsing outputs have the same frequency and duty cycle.

        Args:
            num: number of the output, 1 to 16.
            type: an `OutputMode`: 0 a level, 1 pulses.
            freq: frequency of the pulses, 1 to 100 [Hz].
            duty_cycle: share of the time for which a pulse is high, 1 to 100 [%]. A pulse lasts at
                least 1 ms, so at 100 Hz the duty cycle is at least 10.

        Raises:
            ParameterError: an argument is out of range, or pulses would be too short; nothing
                was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.7, which prints its name as set_digital_out_mode.
        """
        num_, type_ = ranges.STANDARD_IO("num", num), ranges.OUTPUT_MODE("type", type)
        hertz, percent = ranges.pulse(freq, duty_cycle)
        await self._finish(calls.set_digital_output_mode(num_, type_, hertz, percent))

    async def get_standard_analog_voltage_in(self, num: Whole) -> float:
        """Read voltage input 1 to 4 of the cabinet (模拟电压输入) [V]. Manual section 1.3.7."""
        return await self._rpc.get_standard_analog_voltage_in(ranges.ANALOG_IO("num", num))

    async def set_standard_analog_voltage_out(self, num: Whole, value: Real) -> None:
        """Set a voltage output of the cabinet (模拟电压输出).

        Args:
            num: number of the channel, 1 to 4.
            value: voltage, 0 to 10 [V].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.ANALOG_IO("num", num), ranges.VOLTAGE("value", value)
        await self._finish(calls.set_standard_analog_voltage_out(num_, value_, True))

    async def get_tool_analog_voltage_in(self, num: Whole) -> float:
        """Read voltage input 1 or 2 of the tool (末端模拟电压输入) [V]. Manual section 1.3.7."""
        return await self._rpc.get_tool_analog_voltage_in(ranges.TOOL_ANALOG_IO("num", num))

    async def get_standard_analog_current_in(self, num: Whole) -> float:
        """Read current input 1 to 4 of the cabinet (模拟电流输入) [mA]. Manual section 1.3.7."""
        return await self._rpc.get_standard_analog_current_in(ranges.ANALOG_IO("num", num))

    async def set_standard_analog_current_out(self, num: Whole, value: Real) -> None:
        """Set a current output of the cabinet (模拟电流输出).

        Args:
            num: number of the channel, 1 to 4.
            value: current, 4 to 20 [mA].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.ANALOG_IO("num", num), ranges.CURRENT("value", value)
        await self._finish(calls.set_standard_analog_current_out(num_, value_, True))

    async def set_analog_output_mode(self, num: Whole, mode: Whole) -> None:
        """Set the mode of an analog output of the cabinet.

        Not in the manual: the meaning of the modes' numbers is not known.

        Args:
            num: number of the channel, 1 to 4.
            mode: number of the mode.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not set.
        """
        num_, mode_ = ranges.ANALOG_IO("num", num), ranges.INT_32("mode", mode)
        await self._finish(calls.set_analog_output_mode(num_, mode_, True))
