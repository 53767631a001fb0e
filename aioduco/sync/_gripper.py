"""A gripper for blocking programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Concatenate, ParamSpec, Self

from aioduco.errors import ParameterError
from aioduco.sync._generated_objects import GripperCalls
from aioduco.sync._robot import made_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco import robot as aio_robot
    from aioduco.devices.grippers.gripper import PolledGripper
    from aioduco.sync._generated import Robot


P = ParamSpec("P")


class Gripper(GripperCalls):
    """A gripper of `aioduco.devices.grippers`, whose functions return when they are done.

        with aioduco.sync.Gripper(robot, Robotiq.at_tool, "robotiq_2f85") as gripper:
            gripper.activate()
            gripper.close(force=40.0)

    An interrupt (Ctrl-C) halts the fingers before it is raised; a held object stays held.

    Args:
        robot: the robot, open.
        make: the driver's class, or a function that makes the driver, such as `Robotiq.at_tool`.
        *args: further arguments of `make`.
        **kwargs: further keyword arguments of `make`.

    Raises:
        ParameterError: `make` makes nothing.
    """

    def __init__(
        self,
        robot: Robot,
        make: Callable[Concatenate[aio_robot.Robot, P], PolledGripper],
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> None:
        given: object = make
        if not callable(given):
            made = "a driver's class, or what makes the driver of a robot, such as Robotiq.at_tool"
            raise ParameterError("make", given, made)
        driver = make(made_of(robot), *args, **kwargs)
        super().__init__(robot._runner, driver)

    def start(self) -> Self:
        """Read the gripper's state, and keep polling it. Nothing moves.

        Raises:
            GripperError: it was started before, and not shut down.
            ModbusError: the gripper does not answer as it should.
        """
        self._runner.call(self._made.start(), undo=lambda _: self._made.aclose())
        return self

    def shut_down(self) -> None:
        """End the polling. The gripper stays as it is, and keeps what it holds."""
        if self._runner.running:
            self._runner.call(self._made.aclose())

    def _enter(self) -> None:
        self.start()

    def _leave(self, exc: BaseException | None) -> None:  # noqa: ARG002
        self.shut_down()
