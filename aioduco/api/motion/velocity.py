"""Motions at a velocity: they run until their time is over or a command ends them."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.motion.aiming import tool_aim
from aioduco.api.section import Section
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.streaming.shared.turning import MotionFrame, into_tool, turned

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rules import Real, VectorLike
    from aioduco.supervision.command import HeldMotion


#: duration of a motion at a velocity if the program gives none [s]: if the program has exited, or
#: waits for an event that never comes, the arm stops after this time
RUN_TIME = 1.0
_ENDING = "speed_stop"
#: sine of the angle up to which two directions count as one
_SAME_DIRECTION = 1e-6


class Velocity(Section):
    """Motions at a velocity.

    They keep the arm moving, and the controller ignores other motions in the meantime. So each has
    a limit, `time`, which the controller enforces. The manual's default is -1, until `speed_stop`;
    one second is this package's choice, for a program that hangs. A second motion of
    the same kind replaces the first, which then counts as blended.

        down = [0, 0, -0.02, 0, 0, 0]
        async with robot.motion.speedl(down, a=0.5, time=5.0, frame="base"):
            await contact()                     # leaving the block ends the motion
    """

    __slots__ = ()

    def speedj(
        self, velocities: VectorLike, a: Real, *, time: Real | None = RUN_TIME
    ) -> HeldMotion:
        """Turn the joints, each at a velocity (关节速度运动), for a time.

        Cancelling its await, or an error inside its block, stops the arm. If the arm still
        moves two seconds after `time`, this program stops it.

        Args:
            velocities: velocities of the six joints (joints_list), -1.25·π to 1.25·π [rad/s].
                Shape (6,).
            a: acceleration of the leading joint, from 0.01·π/180 [rad/s²].
            time: seconds after which the controller stops the arm, from 0.001, up to what an arm
                can move at that velocity; None: the motion runs until the block is left or
                `speed_stop` is called. Then only the heartbeat stops the arm if the program hangs.
                None is the manual's default, -1; a second is this package's choice.

        Returns:
            The motion, not sent yet. It ends when the arm stands.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        velocities_ = ranges.JOINT_VELOCITIES("velocities", velocities)
        a_ = ranges.JOINT_ACCELERATION("a", a)
        fastest = max(map(abs, velocities_))
        time_ = ranges.run_time("time", time, (fastest, ranges.WHOLE_TURN))
        return self._held(calls.speedj(velocities_, a_, time_, False), _ENDING, time=time)

    def speedl(
        self,
        twist: VectorLike,
        a: Real,
        *,
        time: Real | None = RUN_TIME,
        frame: MotionFrame = "tool",
        wobj: str = "",
    ) -> HeldMotion:
        """Move the tool at a velocity (末端速度运动), for a time.

        The controller takes the velocity in the tool's frame: manual 4.3 says so, manual 3.8 does
        not say. With another `frame`, this package converts it by the tool's orientation. It reads
        the orientation just before it sends the motion, so the value is a few milliseconds old.

        Cancelling its await, or an error inside its block, stops the arm. If the arm still
        moves two seconds after `time`, this program stops it.

        Args:
            twist: velocity of the tool (pose_list): along x, y, z of `frame`, -5 to 5 [m/s], and
                about them, -1.25·π to 1.25·π [rad/s]. Shape (6,).
            a: acceleration of the tool, from 0.00001 [m/s²].
            time: seconds after which the controller stops the arm, from 0.001, up to what an arm
                can move at that velocity; None: the motion runs until the block is left or
                `speed_stop` is called. Then only the heartbeat stops the arm if the program hangs.
                None is the manual's default, -1; a second is this package's choice.
            frame: frame of the velocity: "tool", "base" (z points up if the arm stands on a floor)
                or "wobj", a work object.
            wobj: name of the work object; empty for the one in use.

        Returns:
            The motion, not sent yet. It ends when the arm stands. Sending it raises
            `StaleState` if the orientation cannot be read.

        Raises:
            ParameterError: an argument is out of range; or, in another frame than the tool's, the
                tool is to turn about one direction while it moves along another. That needs a new
                velocity each time that the tool has turned: use `robot.speed.linear`.

        Manual section 1.3.5.
        """
        twist_ = ranges.TWIST("twist", twist)
        a_ = ranges.FINE_ACCELERATION("a", a)
        along, about = math.hypot(*twist_[:3]), math.hypot(*twist_[3:])
        ways = ((along, ranges.WHOLE_WAY), (about, ranges.WHOLE_TURN))
        time_ = ranges.run_time("time", time, *ways)
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
            aim = tool_aim(self._supervisor, turning, partial(turned, back=turning.back))
        call = calls.speedl(twist_, a_, time_, False)
        return self._held(call, _ENDING, time=time, aim=aim, frame=frame)

    async def speed_stop(self) -> None:
        """End `speedj` and `speedl` (停止 speedj 及 speedl), and wait until the arm stands.

        If a motion of this program is running and cannot be ended in this way, or if this is
        cancelled, the arm is stopped as by `Robot.stop`.

        Raises:
            TaskError: the controller did not end them, or they were paused: the arm was stopped.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.5.
        """
        await self._end(_ENDING)


def _parallel(along: Sequence[float], about: Sequence[float]) -> bool:
    """Whether a velocity stays constant in the tool's frame while the tool turns with it."""
    (x, y, z), (u, v, w) = along, about
    across = (y * w - z * v, z * u - x * w, x * v - y * u)
    size = math.hypot(*along) * math.hypot(*about)
    return math.hypot(*across) <= _SAME_DIRECTION * size
