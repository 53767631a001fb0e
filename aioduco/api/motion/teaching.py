"""Hand guiding, and tracks that are recorded and replayed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section
from aioduco.models import ranges
from aioduco.supervision.permits import asked_at_call

if TYPE_CHECKING:
    from aioduco.models.jog import JogFrame
    from aioduco.models.rules import FlagsLike, Real, WholesLike
    from aioduco.supervision.command import HeldMotion


_ENDING = "end_teach_mode"

#: the manual's interval by mode: degrees, seconds. The vendor's client sends 0.5 s instead
_INTERVAL = (5.0, 0.25)


class Teaching(Section):
    """Hand guiding (牵引示教), and tracks that are recorded and replayed (轨迹记录, 轨迹复现)."""

    __slots__ = ()

    def teach_mode(self, *, time: Real | None = None) -> HeldMotion:
        """Let the arm be guided by hand (进入牵引示教模式), until a command ends it.

            async with robot.motion.teach_mode():
                await taught()                  # leaving the block ends hand guiding

            await robot.motion.teach_mode()     # enters hand guiding, and returns
            await robot.motion.end_teach_mode()

        Set the right tool and load first: if the arm carries another weight than the one that was
        set, it sinks or rises by itself. Cancelling its await, or an error inside its block,
        stops the arm and ends hand guiding; so does leaving the robot's block.

        A stop by another program, a collision or an emergency stop may end hand guiding, too. The
        controller's task does not tell it, so that this ends without an error: see `Robot.events`.

        Args:
            time: seconds after which this program ends hand guiding, from 0.001. None: it lasts
                until a command ends it; used without a block, it returns when it has begun.

        Returns:
            The motion, not sent yet. It ends by `end_teach_mode`, by leaving its block, or after
            `time`.

        Raises:
            ParameterError: `time` is out of range.

        Manual section 1.3.5.
        """
        ranges.RUN_TIME("time", time)
        return self._held(
            *(calls.teach_mode(False), _ENDING),
            time=time,
            timed_by_program=time is not None,
            until_commanded=True,
        )

    async def end_teach_mode(self) -> None:
        """End hand guiding (退出牵引示教模式), and wait until the arm stands.

        If this program's hand guiding cannot be ended in this way, or if this is cancelled, the
        arm is stopped as by `Robot.stop`.

        Raises:
            TaskError: the controller did not end it, or it was paused: the arm was stopped.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.5.
        """
        await self._end(_ENDING)

    async def set_hand_teach_parameter(
        self,
        space: int,
        joint_scale: WholesLike,
        cart_scale: WholesLike,
        coord_type: JogFrame | int,
        direction: FlagsLike,
    ) -> None:
        """Set how the arm gives way to a hand (设置牵引参数).

        Args:
            space: 0 the joints give way, 1 the Cartesian directions.
            joint_scale: compliance of the six joints, whole numbers from 0. Shape (6,).
            cart_scale: compliance along and about x, y, z, whole numbers from 0. Shape (6,).
            coord_type: frame of the directions, a `JogFrame`: 0 world, 1 base, 2 tool, 3 work
                object.
            direction: whether the arm gives way in each of the six. Shape (6,).

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.5.
        """
        await self._finish(
            calls.set_hand_teach_parameter(
                ranges.TEACH_SPACE("space", space),
                ranges.TEACH_SCALE("joint_scale", joint_scale),
                ranges.TEACH_SCALE("cart_scale", cart_scale),
                ranges.FRAME_TYPE("coord_type", coord_type),
                ranges.TEACH_DIRECTIONS("direction", direction),
            )
        )

    async def start_record_track(
        self,
        name: str,
        mode: int,
        *,
        tool: str = "",
        wobj: str = "",
        interval: Real | None = None,
    ) -> None:
        """Start to record joints and poses of the arm on the controller (开启轨迹记录).

        When the recording is full, the controller ends it and pauses the running program, and
        motions, which go on at `Robot.resume`.

        Args:
            name: name of the track, for `replay`.
            mode: 0 to record a point each time that the joints have moved by `interval`, 1 at
                equal times.
            tool: name of the tool whose poses are recorded; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            interval: interval between two points, above 0: sum of the joints' travel [rad] in
                mode 0, time [s] in mode 1. None for 5° or 0.25 s, the manual's values. The manual's
                prototype lacks this argument; the wire has it.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not started.
            Refused: the controller does not take the name.

        Manual section 1.3.7.
        """
        name_ = ranges.LONG_NAME("name", name)
        mode_ = ranges.TRACK_MODE("mode", mode)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        if interval is None:
            interval_ = _INTERVAL[mode_]
        else:
            interval_ = ranges.TRACK_INTERVAL("interval", interval)
            interval_ = interval_ if mode_ else math.degrees(interval_)
        await self._begin(calls.start_record_track(name_, mode_, tool_, wobj_, interval_))

    async def stop_record_track(self) -> None:
        """End the recording of a track (停止轨迹记录).

        Raises:
            TaskError, Refused: it was not ended.

        Manual section 1.3.7.
        """
        await self._accept(calls.stop_record_track())

    @asked_at_call
    async def replay(self, name: str, v: int, mode: int) -> None:
        """Run a track that was recorded (轨迹复现), and wait until it has ended.

        The wire can only start the track and wait for its end, so there is no task to follow.
        Cancelling this stops the arm.

        Args:
            name: name of the track.
            v: speed in percent of the set speed, a whole number from 1 to 100.
            mode: 0 in joint space, 1 in Cartesian space.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: the track was not run to its end.
            OutcomeUnknown: it was sent, but not answered; the arm was stopped.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.5.
        """
        name_ = ranges.LONG_NAME("name", name)
        v_ = ranges.REPLAY_SPEED("v", v)
        mode_ = ranges.REPLAY_MODE("mode", mode)
        await self._run_blocking(calls.replay(name_, v_, mode_))
