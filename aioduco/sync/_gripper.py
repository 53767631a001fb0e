"""A gripper for blocking programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Concatenate, ParamSpec

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType
    from typing import Self

    from aioduco import robot as aio_robot
    from aioduco.grippers.gripper import GripperState, PolledGripper
    from aioduco.models.gripper_models import GripperModel
    from aioduco.sync._robot import Robot

__all__ = ["Gripper"]

P = ParamSpec("P")


class Gripper:
    """A gripper of `aioduco.grippers`, whose functions return when they are done.

        with aioduco.sync.Gripper(robot, Robotiq.at_tool, "robotiq_2f85") as gripper:
            gripper.activate()
            gripper.close(force=40.0)

    An interrupt (Ctrl-C) halts the fingers before it is raised; a held object stays held.

    Args:
        robot: the robot, open.
        make: the driver's class, or a function that makes the driver, such as `Robotiq.at_tool`.
        *args: further arguments of `make`.
        **kwargs: further keyword arguments of `make`.
    """

    def __init__(
        self,
        robot: Robot,
        make: Callable[Concatenate[aio_robot.Robot, P], PolledGripper],
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> None:
        self._runner = robot._runner
        self._gripper = make(robot._robot, *args, **kwargs)

    def __repr__(self) -> str:
        return repr(self._gripper)

    def start(self) -> Self:
        """Read the gripper's state, and keep polling it. Nothing moves.

        Raises:
            ModbusError: the gripper does not answer as it should.
        """
        gripper = self._gripper
        self._runner.call(gripper.start(), undo=lambda _: gripper.aclose())
        return self

    def shut_down(self) -> None:
        """End the polling. The gripper stays as it is, and keeps what it holds."""
        if self._runner.running:
            self._runner.call(self._gripper.aclose())

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.shut_down()

    @property
    def model(self) -> GripperModel:
        """Its stroke, forces and speeds."""
        return self._gripper.model

    @property
    def state(self) -> GripperState:
        """The state that was read last; this takes no time."""
        return self._gripper.state

    def read(self) -> GripperState:
        """Read the gripper's state now: see `PolledGripper.read`."""
        return self._runner.call(self._gripper.read())

    def activate(self) -> None:
        """Make the gripper ready, if it needs that: see its driver."""
        self._runner.call(self._gripper.activate())

    def move(
        self, width: float, *, speed: float | None = None, force: float | None = None
    ) -> GripperState:
        """Move the fingers, and return when they stand: see `PolledGripper.move`."""
        return self._runner.call(self._gripper.move(width, speed=speed, force=force))

    def open(self, *, speed: float | None = None, force: float | None = None) -> GripperState:
        """Open as far as it goes."""
        return self._runner.call(self._gripper.open(speed=speed, force=force))

    def close(self, *, speed: float | None = None, force: float | None = None) -> GripperState:
        """Close until it holds something, or as far as it goes."""
        return self._runner.call(self._gripper.close(speed=speed, force=force))

    def halt(self) -> None:
        """Stop the fingers where they are."""
        self._runner.call(self._gripper.halt())

    def check_held(self) -> None:
        """Raise `ObjectLost` or `HoldUnknown` unless the gripped object is still held."""
        self._gripper.check_held()
