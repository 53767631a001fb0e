"""Motions at a velocity: they go on until their time is over or they are told to end."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco.api.motion.aiming import ToolAim, twist_in_tool
from aioduco.api.section import Section
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.streaming.directions import into_tool

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rules import VectorLike
    from aioduco.streaming.directions import MotionFrame
    from aioduco.supervision.command import HeldMotion

__all__ = ["Velocity"]

#: how long a motion at a velocity goes on unless the program says otherwise [s]: if the program
#: is gone, or waits for something that never comes, the arm stops after that
RUN_TIME = 1.0
_ENDING = "speed_stop"
#: sine of the angle up to which two directions count as one
_SAME_DIRECTION = 1e-6


class Velocity(Section):
    """Motions at a velocity.

    They keep the arm moving, and the controller takes no notice of other motions meanwhile. So
    each has an end of its own: `time`, which the controller keeps, one second unless another is
    given. A second one like it takes over from the first, which then counts as blended.

        down = [0, 0, -0.02, 0, 0, 0]
        async with robot.motion.speedl(down, a=0.5, time=5.0, frame="base"):
            await contact()                     # leaving the block ends the motion
    """

    __slots__ = ()

    def speedj(
        self, velocities: VectorLike, a: float, *, time: float | None = RUN_TIME
    ) -> HeldMotion:
        """Turn the joints, each at a velocity (关节速度运动), for a time.

        Cancelling its await, or an error inside its block, stops the arm. If the arm moves on
        for two seconds after `time`, this program stops it.

        Args:
            velocities: of the six joints (joints_list), -1.25·π to 1.25·π [rad/s]. Shape (6,).
            a: acceleration of the leading joint, from 0.01·π/180 [rad/s²].
            time: seconds after which the controller stops the arm, from 0.001; None to go on
                until the block is left or `speed_stop` is called: only the heartbeat then stops
                the arm of a program that hangs.

        Returns:
            The motion, not sent yet. Its end is when the arm stands.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        velocities_ = ranges.JOINT_VELOCITIES("velocities", velocities)
        a_ = ranges.JOINT_ACCELERATION("a", a)
        time_ = ranges.RUN_TIME("time", time)
        return self._held(lambda rpc: rpc.speedj(velocities_, a_, time_, False), _ENDING, time=time)

    def speedl(
        self,
        twist: VectorLike,
        a: float,
        *,
        time: float | None = RUN_TIME,
        frame: MotionFrame = "tool",
        wobj: str = "",
    ) -> HeldMotion:
        """Move the tool at a velocity (末端速度运动), for a time.

        The controller takes the velocity in the tool's frame: manual 4.3 says so, manual 3.8 does
        not say. With another `frame` it is turned here, by the orientation of the tool that is
        read as the motion is sent: it is as old as the calls take, a few milliseconds.

        Cancelling its await, or an error inside its block, stops the arm. If the arm moves on
        for two seconds after `time`, this program stops it.

        Args:
            twist: velocity of the tool (pose_list): along x, y, z of `frame`, -5 to 5 [m/s], and
                about them, -1.25·π to 1.25·π [rad/s]. Shape (6,).
            a: acceleration of the tool, from 0.00001 [m/s²].
            time: seconds after which the controller stops the arm, from 0.001; None to go on
                until the block is left or `speed_stop` is called: only the heartbeat then stops
                the arm of a program that hangs.
            frame: whose axes are meant: "tool", "base" (z is up where the arm stands on a floor)
                or "wobj", a work object.
            wobj: name of the work object; empty for the one in use.

        Returns:
            The motion, not sent yet. Its end is when the arm stands. Sending it raises
            `StaleState` if the orientation cannot be read.

        Raises:
            ParameterError: an argument is out of range; or the tool is to turn about one
                direction while it moves along another, in another frame than its own. As the
                tool turns, that takes a new velocity each time: `robot.speed.linear`.

        Manual section 1.3.5.
        """
        twist_ = ranges.TWIST("twist", twist)
        a_ = ranges.FINE_ACCELERATION("a", a)
        time_ = ranges.RUN_TIME("time", time)
        turning = into_tool(frame, wobj)
        aim = None
        if turning is not None:
            if not _parallel(twist_[:3], twist_[3:]):
                raise ParameterError(
                    "twist",
                    twist,
                    f"along or about one direction with frame={frame!r}: as the tool turns, this "
                    "velocity would have to change; robot.speed.linear does that",
                )
            aim = ToolAim(self._supervisor, frame, turning, twist_in_tool)
        return self._held(
            lambda rpc: rpc.speedl(twist_, a_, time_, False), _ENDING, time=time, aim=aim
        )

    async def speed_stop(self) -> None:
        """End `speedj` and `speedl` (停止 speedj 及 speedl), and wait until the arm stands.

        If one of this program's is running and cannot be ended so, or if this is cancelled, the
        arm is stopped as by `Robot.stop`.

        Raises:
            TaskError: the controller did not end them.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.5.
        """
        await self._end(_ENDING)


def _parallel(along: Sequence[float], about: Sequence[float]) -> bool:
    """Whether a velocity stays what it is while the tool turns by it."""
    (x, y, z), (u, v, w) = along, about
    across = (y * w - z * v, z * u - x * w, x * v - y * u)
    size = math.hypot(*along) * math.hypot(*about)
    return math.hypot(*across) <= _SAME_DIRECTION * size
