"""Functions of the factory and of service technicians: only on the wire."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section
from aioduco.models import ranges
from aioduco.models.state import Vector, vector

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from aioduco.models.rules import Real, VectorLike, Whole


class Service(Section):
    """Functions of the factory and of service technicians. None of them is in the manual.

    Warning:
        They change how the joints are driven, and the position that the controller computes for
        the arm. A wrong value can make the arm move in an unforeseen way, or damage it, and may
        persist after a restart. The meaning of the numbers is not published: use them only with the
        vendor's instructions for this arm, and keep out of its reach.
    """

    __slots__ = ()

    async def set_servo_config(self, axis_num: Whole, id: Whole, value: Whole, qfmt: Whole) -> None:  # noqa: A002
        """Set a parameter of an axis' servo drive.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            axis_num: number of the axis, from 0.
            id: number of the parameter.
            value: its value.
            qfmt: format of the value.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._finish(
            calls.set_servo_config(
                ranges.AXIS_NUMBER("axis_num", axis_num),
                ranges.INT_32("id", id),
                ranges.INT_32("value", value),
                ranges.INT_32("qfmt", qfmt),
                True,
            )
        )

    async def apply_servo_config(self, axis_num: Whole) -> None:
        """Make an axis' servo drive use its parameters.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            axis_num: number of the axis, from 0.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._finish(calls.apply_servo_config(ranges.AXIS_NUMBER("axis_num", axis_num), True))

    async def set_servo_file_params(
        self,
        axis_num: Whole,
        id: Whole,  # noqa: A002
        name: str,
        value: Real,
        qfmt: Real,
    ) -> None:
        """Set a parameter in the file of an axis' servo drive.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            axis_num: number of the axis, from 0.
            id: number of the parameter.
            name: its name.
            value: its value.
            qfmt: format of the value.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(
            calls.set_servo_file_params(
                ranges.AXIS_NUMBER("axis_num", axis_num),
                ranges.INT_32("id", id),
                ranges.LONG_NAME("name", name),
                ranges.FINITE("value", value),
                ranges.FINITE("qfmt", qfmt),
            )
        )

    async def set_dynamic_calibration_params(self, params: Iterable[VectorLike]) -> None:
        """Set the parameters of the dynamic calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            params: a table of numbers.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(calls.set_dynamic_calibration_params(ranges.MATRIX("params", params)))

    async def set_kinematic_calibration_params(self, params: Iterable[VectorLike]) -> None:
        """Set the parameters of the kinematic calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            params: a table of numbers.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(calls.set_kinematic_calibration_params(ranges.MATRIX("params", params)))

    async def set_dynamic_calibration_info(self, passwd: str, info: str) -> None:
        """Set the notes to the dynamic calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.
            info: the notes.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(
            calls.set_dynamic_calibration_info(
                ranges.TEXT("passwd", passwd), ranges.TEXT("info", info)
            )
        )

    async def set_kinematic_calibration_info(self, passwd: str, info: str) -> None:
        """Set the notes to the kinematic calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.
            info: the notes.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(
            calls.set_kinematic_calibration_info(
                ranges.TEXT("passwd", passwd), ranges.TEXT("info", info)
            )
        )

    async def set_vibration_calibration_info(self, passwd: str, info: str) -> None:
        """Set the notes to the vibration calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.
            info: the notes.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(
            calls.set_vibration_calibration_info(
                ranges.TEXT("passwd", passwd), ranges.TEXT("info", info)
            )
        )

    async def save_dynamic_calibration_params(self, passwd: str) -> None:
        """Save the parameters of the dynamic calibration for good.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(calls.save_dynamic_calibration_params(ranges.TEXT("passwd", passwd)))

    async def save_kinematic_calibration_params(self, passwd: str) -> None:
        """Save the parameters of the kinematic calibration for good.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(calls.save_kinematic_calibration_params(ranges.TEXT("passwd", passwd)))

    async def upload_robot_param_to_toolboard(self, passwd: str) -> None:
        """Write the robot's parameters to the board in the tool flange.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(calls.upload_robot_param_to_toolboard(ranges.TEXT("passwd", passwd)))

    async def set_pendant_type(self, type: Whole) -> None:  # noqa: A002
        """Set the kind of the pendant.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            type: number of the kind.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not done.
        """
        await self._accept(calls.set_pendant_type(ranges.INT_32("type", type)))

    async def change_recipe(self) -> None:
        """Change the recipe.

        Not in the manual: it is not known what a recipe is, or which one follows.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.
        """
        await self._rpc.change_recipe()

    async def get_dynamic_calibration_params(self) -> tuple[Vector, ...]:
        """Read the parameters of the dynamic calibration: a read-only array for each row.

        Not in the manual.
        """
        return _table(await self._rpc.get_dynamic_calibration_params())

    async def get_vibration_calibration_params(self) -> tuple[Vector, ...]:
        """Read the parameters of the vibration calibration: a read-only array for each row.

        Not in the manual.
        """
        return _table(await self._rpc.get_vibration_calibration_params())

    async def get_axis_motor_kt(self) -> Vector:
        """Read the torque constants of the axes' motors, as a read-only array.

        Not in the manual, and neither is the unit.
        """
        return vector(await self._rpc.get_axis_motor_kt(), None)

    async def get_axis_motor_rated_current(self) -> Vector:
        """Read the rated currents of the axes' motors, as a read-only array.

        Not in the manual, and neither is the unit.
        """
        return vector(await self._rpc.get_axis_motor_rated_current(), None)

    async def get_pos_bias(self) -> Vector:
        """Read the biases of the positions of the axes, as a read-only array.

        Not in the manual, and neither is the unit.
        """
        return vector(await self._rpc.get_pos_bias(), None)

    async def get_axis_ratio(self) -> tuple[int, ...]:
        """Read the gear ratios of the axes.

        Not in the manual.
        """
        return tuple(await self._rpc.get_axis_ratio())

    async def get_motor_pole_pair_number(self) -> tuple[int, ...]:
        """Read the numbers of pole pairs of the axes' motors.

        Not in the manual.
        """
        return tuple(await self._rpc.get_motor_pole_pair_number())

    async def get_motor_stator_slots(self) -> tuple[int, ...]:
        """Read the numbers of stator slots of the axes' motors.

        Not in the manual.
        """
        return tuple(await self._rpc.get_motor_stator_slots())


def _table(wire: Sequence[Sequence[float]]) -> tuple[Vector, ...]:
    return tuple(vector(row, None) for row in wire)
