"""Registers and variables of the controller (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.api.section import Section, done, succeeded
from aioduco.models import ranges
from aioduco.models.state import vector

if TYPE_CHECKING:
    from aioduco.models.rules import Real, VectorLike, Whole
    from aioduco.models.state import Vector

__all__ = ["Registers"]


class Registers(Section):
    """Registers (寄存器) and global variables (系统变量) of the controller (manual 1.3.7).

        await robot.registers.write_word_reg(5, 1200)
        count = await robot.registers.get_system_value_double("cell.count")

    Programs of the controller, fieldbuses and this program share them. A variable within a
    domain is named "domain.variable".
    """

    __slots__ = ()

    async def write_bool_reg(self, num: Whole, value: bool) -> None:
        """Write an internal bool register (内部 bool 寄存器).

        Args:
            num: number of the register, 1 to 64.
            value: what is written, true or false.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not written.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.BOOL_REGISTER("num", num), ranges.FLAG("value", value)
        done("write_bool_reg", await self._rpc.write_bool_reg(num_, value_))

    async def read_bool_reg(self, num: Whole) -> bool:
        """Read an internal bool register (内部 bool 寄存器), 1 to 64. Manual section 1.3.7."""
        return await self._rpc.read_bool_reg(ranges.BOOL_REGISTER("num", num))

    async def write_word_reg(self, num: Whole, value: Whole) -> None:
        """Write an internal word register (内部 word 寄存器).

        Args:
            num: number of the register, 1 to 32.
            value: what is written, 16 bits: -32768 to 65535.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not written.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.WORD_REGISTER("num", num), ranges.WORD("value", value)
        done("write_word_reg", await self._rpc.write_word_reg(num_, value_))

    async def read_word_reg(self, num: Whole) -> int:
        """Read an internal word register (内部 word 寄存器), 1 to 32. Manual section 1.3.7."""
        return await self._rpc.read_word_reg(ranges.WORD_REGISTER("num", num))

    async def write_float_reg(self, num: Whole, value: Real) -> None:
        """Write an internal float register (内部 float 寄存器).

        Args:
            num: number of the register, 1 to 32.
            value: what is written, a finite number.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not written.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.FLOAT_REGISTER("num", num), ranges.FINITE("value", value)
        done("write_float_reg", await self._rpc.write_float_reg(num_, value_))

    async def read_float_reg(self, num: Whole) -> float:
        """Read an internal float register (内部 float 寄存器), 1 to 32. Manual section 1.3.7."""
        return await self._rpc.read_float_reg(ranges.FLOAT_REGISTER("num", num))

    async def get_function_reg_in(self, num: Whole) -> bool:
        """Read a function input register (功能输入寄存器), 1 to 16. Manual section 1.3.7."""
        return await self._rpc.get_function_reg_in(ranges.FUNCTION_REGISTER("num", num))

    async def get_function_reg_out(self, num: Whole) -> bool:
        """Read a function output register (功能输出寄存器), 1 to 16. Manual section 1.3.7."""
        return await self._rpc.get_function_reg_out(ranges.FUNCTION_REGISTER("num", num))

    async def set_system_value_bool(self, name: str, value: bool) -> None:
        """Set a variable of the controller of type bool (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: what it is set to: true or false.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        name_, value_ = ranges.LONG_NAME("name", name), ranges.FLAG("value", value)
        answer = await self._rpc.set_system_value_bool(name_, value_)
        succeeded("set_system_value_bool", answer)

    async def get_system_value_bool(self, name: str) -> bool:
        """Read a variable of the controller of type bool (系统变量). Manual section 1.3.7."""
        return await self._rpc.get_system_value_bool(ranges.LONG_NAME("name", name))

    async def set_system_value_double(self, name: str, value: Real) -> None:
        """Set a variable of the controller of type double (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: what it is set to: a finite number.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        name_, value_ = ranges.LONG_NAME("name", name), ranges.FINITE("value", value)
        answer = await self._rpc.set_system_value_double(name_, value_)
        succeeded("set_system_value_double", answer)

    async def get_system_value_double(self, name: str) -> float:
        """Read a variable of the controller of type double (系统变量). Manual section 1.3.7."""
        return await self._rpc.get_system_value_double(ranges.LONG_NAME("name", name))

    async def set_system_value_str(self, name: str, value: str) -> None:
        """Set a variable of the controller of type str (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: what it is set to: text.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        name_, value_ = ranges.LONG_NAME("name", name), ranges.TEXT("value", value)
        answer = await self._rpc.set_system_value_str(name_, value_)
        succeeded("set_system_value_str", answer)

    async def get_system_value_str(self, name: str) -> str:
        """Read a variable of the controller of type str (系统变量). Manual section 1.3.7."""
        return await self._rpc.get_system_value_str(ranges.LONG_NAME("name", name))

    async def set_system_value_list(self, name: str, value: VectorLike) -> None:
        """Set a variable of the controller of type num_list (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: what it is set to: finite numbers.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        name_, value_ = ranges.LONG_NAME("name", name), ranges.FINITES("value", value)
        answer = await self._rpc.set_system_value_list(name_, value_)
        succeeded("set_system_value_list", answer)

    async def get_system_value_list(self, name: str) -> Vector:
        """Read a variable of the controller of type num_list (系统变量), as a read-only array.

        Manual section 1.3.7.
        """
        values = await self._rpc.get_system_value_list(ranges.LONG_NAME("name", name))
        return vector(values, len(values))

    async def get_system_value_lists(self, name: str) -> tuple[Vector, ...]:
        """Read a variable of the controller that is a list of poses, each a read-only array.

        Not in manual 3.8, but on its wire; manual 4.3 describes it.
        """
        values = await self._rpc.get_system_value_lists(ranges.LONG_NAME("name", name))
        return tuple(vector(row, len(row)) for row in values)
