"""Jogging of one joint or one Cartesian direction, by a step or until a command ends it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import JOG_TIME, Section
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.jog import Jog, JogDirections, directions_of

if TYPE_CHECKING:
    from aioduco.models.rules import Real
    from aioduco.supervision.command import MotionCommand


_ENDING = "stop_manual_move"


class Jogging(Section):
    """Jogging (点动): steps, and motions that run until a command ends them."""

    __slots__ = ()

    def move_jog(
        self,
        jog: Jog,
        *,
        time: Real | None = JOG_TIME,
        directions: JogDirections | None = None,
    ) -> MotionCommand:
        """Jog one joint or one Cartesian direction (点动).

            await robot.motion.move_jog(Jog.joint(1, 1, vel=10, step=0.01))
            async with robot.motion.move_jog(Jog.cartesian("z", -1, vel=5), time=10.0):
                await released()                # leaving the block ends the jog

        A step ends by itself. Without a step the controller jogs until a command ends the jog:
        this program sends that command when the block is left, at the latest after `time`.
        Cancelling its await, or an error inside its block, stops the arm.

        Args:
            jog: the jog, made by `Jog.joint` or `Jog.cartesian`.
            time: seconds after which this program ends a jog without a step, from 0.001; None: it
                runs until the block is left or `stop_manual_move` is called. The wire has no such
                time: if the program hangs, only the heartbeat stops the arm.
            directions: the controller's meaning of the two directions, which differs between the
                manuals; None: as its version says. Try one that you give with a small step at a
                low speed.

        Returns:
            The motion, not sent yet. Without a step, it ends when the arm stands.

        Raises:
            ParameterError: an argument is out of range, or the controller's version is unknown
                and `directions` is not given.

        Manual section 1.3.5.
        """
        if not isinstance(jog, Jog):
            raise ParameterError("jog", jog, "a Jog: Jog.joint(...) or Jog.cartesian(...)")
        ranges.RUN_TIME("time", time)
        param = jog.wire(directions_of(directions, self._supervisor.version))
        motion: MotionCommand
        if jog.step is not None:
            motion = self._motion(calls.move_jog(param, False))
        else:
            motion = self._held(
                calls.move_jog(param, False), _ENDING, time=time, timed_by_program=True
            )
        motion.command = replace(motion.command, sense=jog.direction)
        return motion

    async def stop_manual_move(self) -> None:
        """End a jog (结束点动), and wait until the arm stands.

        If a jog of this program is running and cannot be ended in this way, or
        if this is cancelled, the arm is stopped as by `Robot.stop`.

        Raises:
            TaskError: the controller did not end it, or it was paused: the arm was stopped.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.5.
        """
        await self._end(_ENDING)
