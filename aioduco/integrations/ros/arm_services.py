"""Services of an arm, for any middleware: each a coroutine that never raises."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from aioduco import Joints, Pose
from aioduco.errors import DucoError

if TYPE_CHECKING:
    from collections.abc import Awaitable, Sequence

    from aioduco import Robot
    from aioduco.integrations.ros.trajectory_server import TrajectoryServer

__all__ = ["ArmServices", "ServiceReply"]


class ServiceReply(NamedTuple):
    """Reply of a service.

    Attributes:
        success: whether the request succeeded.
        message: the result, or the reason for the failure.
    """

    success: bool
    message: str


class ArmServices:
    """Services of one arm. The called functions check the numbers.

    Args:
        robot: the robot, open.
        goals: trajectory goals of the arm.
    """

    def __init__(self, robot: Robot, goals: TrajectoryServer) -> None:
        self._robot = robot
        self._goals = goals

    async def bring_up(self) -> ServiceReply:
        """Power on, enable and clear, so that the arm can move."""
        return await _answered(self._robot.bring_up())

    async def recover(self) -> ServiceReply:
        """Recover the arm from a stop."""
        return await _answered(self._robot.recover())

    async def stop(self) -> ServiceReply:
        """Stop the arm, and wait until it stands. A running goal is aborted."""
        return await _answered(self._robot.stop(), "the arm stands")

    async def pause(self) -> ServiceReply:
        """Pause a movej or movel; during a trajectory goal the request is refused."""
        if self._goals.busy:
            return ServiceReply(
                False, "a trajectory goal cannot be paused, nothing was done: cancel it, or stop"
            )
        return await _answered(self._robot.pause(), "paused")

    async def resume(self) -> ServiceReply:
        """Resume a paused motion."""
        return await _answered(self._robot.resume(), "resumed")

    async def set_digital_output(self, num: int, value: bool) -> ServiceReply:
        """Set an output of the cabinet, 1 to 16."""
        return await _answered(self._robot.io.set_standard_digital_out(num, value), "set")

    async def set_tool_output(self, num: int, value: bool) -> ServiceReply:
        """Set an output at the tool, 1 or 2."""
        return await _answered(self._robot.io.set_tool_digital_out(num, value), "set")

    async def set_speed(self, percent: float) -> ServiceReply:
        """Set the global speed, which scales motions: 1 to 100 percent."""
        return await _answered(self._robot.settings.speed(percent), "set")

    async def set_tool(
        self, name: str, offset: Sequence[float], mass: float, centre: Sequence[float]
    ) -> ServiceReply:
        """Define a tool and use it.

        Args:
            name: name of the tool.
            offset: pose of its tip in the flange's frame (x, y, z [m], rx, ry, rz [rad]).
            mass: mass of the tool [kg].
            centre: centre of mass of the tool [m], three.
        """
        if self._goals.busy:
            return _BUSY

        async def run() -> None:
            tip = Pose.of(list(offset))
            await self._robot.frames.set_tool_data(name, tip, (mass, *centre))

        return await _answered(run(), "set")

    async def set_load(self, mass: float, centre: Sequence[float]) -> ServiceReply:
        """Set the load that the tool holds: mass [kg], centre of mass [m], three."""

        async def run() -> None:
            await self._robot.frames.set_load_data((mass, *centre))

        return await _answered(run(), "set")

    async def movej(self, joints: Sequence[float], v: float, a: float) -> ServiceReply:
        """Move to joint angles, and wait for the end.

        Args:
            joints: target [rad]. Shape (6,).
            v: highest joint speed [rad/s].
            a: highest joint acceleration [rad/s²].
        """
        if self._goals.busy:
            return _BUSY

        async def run() -> None:
            await self._robot.motion.movej2(Joints.of(list(joints)), v, a)

        return await _answered(run(), "the arm is there")

    async def movel(
        self, pose: Sequence[float], v: float, a: float, tool: str = "", wobj: str = ""
    ) -> ServiceReply:
        """Move the tool along a line, and wait for the end.

        Args:
            pose: target (x, y, z [m], rx, ry, rz [rad]).
            v: highest speed [m/s].
            a: highest acceleration [m/s²].
            tool: name of the tool; empty: the one in use.
            wobj: name of the work object; empty: the one in use.
        """
        if self._goals.busy:
            return _BUSY

        async def run() -> None:
            await self._robot.motion.movel(Pose.of(list(pose)), v, a, tool=tool, wobj=wobj)

        return await _answered(run(), "the arm is there")


_BUSY = ServiceReply(False, "a trajectory goal is carried out; nothing was sent: cancel it first")


async def _answered(step: Awaitable[object], text: str = "") -> ServiceReply:
    """Await a step, and return its result as a reply."""
    try:
        outcome = await step
    except (DucoError, TypeError, ValueError, TimeoutError) as error:
        return ServiceReply(False, str(error) or repr(error))
    return ServiceReply(True, text or str(outcome))
