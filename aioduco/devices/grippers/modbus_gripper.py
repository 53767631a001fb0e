"""The common parts of grippers on Modbus RTU: their model, their device, the tool's port."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar, Self

import anyio

from aioduco.devices.bus import ModbusRtu, Port
from aioduco.devices.grippers.gripper import PolledGripper, awaited
from aioduco.errors import GripperTimeout, ParameterError
from aioduco.models.gripper_models import GRIPPERS, GripperModel, gripper_model
from aioduco.models.words import one_of
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.robot import Robot


class ModbusGripper(PolledGripper):
    """A gripper that is a device on Modbus RTU; a base class for drivers.

    A driver sets `usual_model` to the name of its usual model, and `usual_unit` to the factory
    setting of its device number; `make` is what the names of its models begin with.

    Args:
        modbus: the device.
        model: name of a model, or a `GripperModel`; None for the usual one.
        poll: seconds between two polls of the gripper's state.
        timeout: seconds within which a movement must have ended.
        max_age: seconds without a new state after which `carrying` stops the arm.

    Raises:
        ParameterError: an argument is out of range.
    """

    usual_model: ClassVar[str]
    usual_unit: ClassVar[int]
    make: ClassVar[str] = ""

    def __init__(
        self,
        modbus: ModbusRtu,
        model: str | GripperModel | None = None,
        *,
        poll: float = 0.05,
        timeout: float = 10.0,
        max_age: float = 1.0,
    ) -> None:
        wanted = self.usual_model if model is None else model
        if isinstance(wanted, str):
            names = [name for name in GRIPPERS if name.startswith(self.make)]
            known = gripper_model(one_of("model", wanted, names, besides="a GripperModel"))
        else:
            known = wanted
        if not isinstance(known, GripperModel) or not 0.0 < known.stroke < math.inf:
            raise ParameterError("model", known, "a GripperModel with a stroke")
        super().__init__(known, poll=poll, timeout=timeout, max_age=max_age)
        self._modbus = modbus

    async def _until_ready(self, ready: Callable[[], Awaitable[bool]]) -> None:
        """Ask again and again whether the gripper is ready, until it is.

        Raises:
            GripperTimeout: it did not become ready within `timeout`.
        """
        with anyio.move_on_after(self._timeout):
            async for _ in every(self._poll):
                if await ready():
                    return
        raise GripperTimeout(f"{self} was not ready within {self._timeout:g} s; it may still move")

    @classmethod
    def at_tool(
        cls,
        robot: Robot,
        model: str | GripperModel | None = None,
        *,
        unit: int | None = None,
        answer_timeout: float = 0.5,
        timeout: float = 10.0,
        max_age: float | None = None,
    ) -> Self:
        """Make the driver of the gripper at the tool's RS-485 port of a robot.

        Args:
            robot: the robot.
            model: as for the class.
            unit: number of the device; None for the factory setting.
            answer_timeout: seconds within which it must answer a request.
            timeout: seconds within which a movement must have ended.
            max_age: seconds without a new state after which `carrying` stops the arm; None for
                twice `answer_timeout`.

        Raises:
            ParameterError: an argument is out of range, or the robot is one of `aioduco.sync`.
        """
        number = cls.usual_unit if unit is None else unit
        modbus = ModbusRtu(Port.tool(awaited(robot).bus), number, timeout=answer_timeout)
        limit = 2 * answer_timeout if max_age is None else max_age
        return cls(modbus, model, timeout=timeout, max_age=limit)
