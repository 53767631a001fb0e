"""Digital inputs and outputs (manual 1.3.7)."""

from __future__ import annotations

from aioduco.api import ranges
from aioduco.api.section import Section, done

__all__ = ["IO"]


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
            TaskError: the output was not set.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.STANDARD_IO("num", num), ranges.FLAG("value", value)
        answer = await self._rpc.set_standard_digital_out(num_, value_, True)
        done("set_standard_digital_out", answer)

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
            TaskError: the output was not set.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.TOOL_IO("num", num), ranges.FLAG("value", value)
        answer = await self._rpc.set_tool_digital_out(num_, value_, True)
        done("set_tool_digital_out", answer)

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
