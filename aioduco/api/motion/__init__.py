"""Motions (移动控制, manual 1.3.5)."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from aioduco.api import ranges
from aioduco.api.motion.curves import Curves
from aioduco.api.motion.jog import Jogging
from aioduco.api.motion.joints import JointMotions
from aioduco.api.motion.lines import Lines
from aioduco.api.motion.servo import Servo
from aioduco.api.motion.teaching import Teaching
from aioduco.api.motion.velocity import Velocity
from aioduco.api.section import done
from aioduco.errors import DucoError, ParameterError
from aioduco.models.rules import Integer
from aioduco.supervision.command import MotionCommand

if TYPE_CHECKING:
    from aioduco.models.enums import Outcome
    from aioduco.supervision.task import Task

__all__ = ["Motion"]

_AHEAD = Integer(1, 1000, "motions", source="this package")


class Motion(JointMotions, Lines, Curves, Velocity, Servo, Jogging, Teaching):
    """Motions of the arm (移动控制, manual 1.3.5).

    Each function checks its arguments and returns a motion as a value; nothing is sent before it
    is awaited, started, or run:

        await robot.motion.movej2(home, v=1.0, a=1.0)
        move = await robot.motion.movel(target, v=0.2, a=0.5).start()
        await robot.motion.run(approach, pass_by, retreat)

    Motions at a velocity, jogs and hand guiding go on until they are told to end: they are tied
    to a block, which ends them when it is left.
    """

    __slots__ = ()

    async def set_blend_ahead(self, per: int, num: int = 1) -> None:
        """Set how early the controller reads the next motion, to blend into it (融合预读取).

        Args:
            per: percent of a motion after which the next is read, 0 to 100; usually 0 or 50.
            num: how many motions are read ahead if `per` is 0, 1 to 3: more for short motions
                that follow each other fast.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.5.
        """
        per_ = ranges.BLEND_AHEAD("per", per)
        num_ = ranges.BLEND_AHEAD_MOVES("num", num)
        done("set_blend_ahead", await self._rpc.set_blend_ahead(per_, num_))

    async def run(self, *motions: MotionCommand, ahead: int = 3) -> tuple[Outcome, ...]:
        """Send motions one after another, ahead of the arm, and wait for all of them.

        The controller can blend a motion into the next only if it has that one in time. So some
        are sent ahead; the others follow as the first ones end.

        Args:
            motions: in the order in which they are to be carried out.
            ahead: how many the controller has at most, the running one included, 1 to 1000.

        Returns:
            The outcome of each: finished or blended.

        Raises:
            TaskError: one did not succeed. Those after it were stopped, or not sent.
            ParameterError: something in `motions` is no motion, or `ahead` is out of range;
                nothing was sent.

        If this is cancelled, the arm is stopped.
        """
        for number, motion in enumerate(motions):
            if not isinstance(motion, MotionCommand):
                raise ParameterError(f"motions[{number}]", motion, "a motion")
            motion.hand_over()
        _AHEAD("ahead", ahead)
        tasks: deque[Task] = deque()
        outcomes: list[Outcome] = []
        try:
            for motion in motions:
                if len(tasks) >= ahead:
                    outcomes.append(await tasks.popleft())
                tasks.append(await motion.start())
            while tasks:
                outcomes.append(await tasks.popleft())
        except DucoError:
            # One was refused, or failed: those that were sent must not go on without it.
            if tasks:
                await tasks[0].cancel()
            raise
        except BaseException:
            if tasks:
                await tasks[0].forsake()
            raise
        return tuple(outcomes)
