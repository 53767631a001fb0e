"""Registers and variables of the controller (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from aioduco._wire.rpc import WireCall, calls
from aioduco.api.section import Section
from aioduco.errors import Refused
from aioduco.models import ranges
from aioduco.models.state import Vector, vector

if TYPE_CHECKING:
    from aioduco.models.rules import Real, VectorLike, Whole

T = TypeVar("T")


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
            value: value to write, true or false.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not written.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.BOOL_REGISTER("num", num), ranges.FLAG("value", value)
        await self._finish(calls.write_bool_reg(num_, value_))

    async def read_bool_reg(self, num: Whole) -> bool:
        """Read an internal bool register (内部 bool 寄存器), 1 to 64. Manual section 1.3.7."""
        return await self._rpc.read_bool_reg(ranges.BOOL_REGISTER("num", num))

    async def write_word_reg(self, num: Whole, value: Whole) -> None:
        """Write an internal word register (内部 word 寄存器).

        Args:
            num: number of the register, 1 to 32.
            value: value to write, 16 bits: -32768 to 65535.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not written.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.WORD_REGISTER("num", num), ranges.WORD("value", value)
        await self._finish(calls.write_word_reg(num_, value_))

    async def read_word_reg(self, num: Whole) -> int:
        """Read an internal word register (内部 word 寄存器), 1 to 32. Manual section 1.3.7."""
        return await self._rpc.read_word_reg(ranges.WORD_REGISTER("num", num))

    async def write_float_reg(self, num: Whole, value: Real) -> None:
        """Write an internal float register (内部 float 寄存器).

        Args:
            num: number of the register, 1 to 32.
            value: value to write, a finite number.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not written.

        Manual section 1.3.7.
        """
        num_, value_ = ranges.FLOAT_REGISTER("num", num), ranges.FINITE("value", value)
        await self._finish(calls.write_float_reg(num_, value_))

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
            value: new value, true or false.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        name_, value_ = ranges.LONG_NAME("name", name), ranges.FLAG("value", value)
        await self._set(calls.set_system_value_bool(name_, value_))

    async def get_system_value_bool(self, name: str) -> bool:
        """Read a variable of the controller of type bool (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.

        Manual section 1.3.7.
        """
        return await self._value(calls.get_system_value_bool(ranges.LONG_NAME("name", name)))

    async def set_system_value_double(self, name: str, value: Real) -> None:
        """Set a variable of the controller of type double (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: new value, a finite number.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        name_, value_ = ranges.LONG_NAME("name", name), ranges.FINITE("value", value)
        await self._set(calls.set_system_value_double(name_, value_))

    async def get_system_value_double(self, name: str) -> float:
        """Read a variable of the controller of type double (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.

        Manual section 1.3.7.
        """
        return await self._value(calls.get_system_value_double(ranges.LONG_NAME("name", name)))

    async def set_system_value_str(self, name: str, value: str) -> None:
        """Set a variable of the controller of type str (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: new value, a text.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        name_, value_ = ranges.LONG_NAME("name", name), ranges.TEXT("value", value)
        await self._set(calls.set_system_value_str(name_, value_))

    async def get_system_value_str(self, name: str) -> str:
        """Read a variable of the controller of type str (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.

        Manual section 1.3.7.
        """
        return await self._value(calls.get_system_value_str(ranges.LONG_NAME("name", name)))

    async def set_system_value_list(self, name: str, value: VectorLike) -> None:
        """Set a variable of the controller of type num_list (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: new value, finite numbers.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        name_, value_ = ranges.LONG_NAME("name", name), ranges.FINITES("value", value)
        await self._set(calls.set_system_value_list(name_, value_))

    async def get_system_value_list(self, name: str) -> Vector:
        """Read a variable of the controller of type num_list (系统变量), as a read-only array.

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.

        Manual section 1.3.7.
        """
        name_ = ranges.LONG_NAME("name", name)
        return vector(await self._value(calls.get_system_value_list(name_)), None)

    async def get_system_value_lists(self, name: str) -> tuple[Vector, ...]:
        """Read a variable of the controller that is a list of poses, each a read-only array.

        Not in manual 3.8, but on its wire; manual 4.3 describes it.

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.
        """
        values = await self._value(calls.get_system_value_lists(ranges.LONG_NAME("name", name)))
        return tuple(vector(row, None) for row in values)

    async def _value(self, call: WireCall[T]) -> T:
        """Read a variable; it may have gone since the last read, as with another project."""
        (name,) = call.args
        return await self._read_checked(call, name)

    async def _set(self, call: WireCall[int]) -> None:
        """Set a variable, and check the answer, which is 0 on success."""
        before = await self._follower.error_list()
        answer = await self._rpc.send(call)
        if answer != 0:
            why = "; ".join(await self._follower.new_errors(before))
            raise Refused(call.name, answer, why or "no such variable, or one of another type")
