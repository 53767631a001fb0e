"""Motions (移动控制, manual 1.3.5)."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING

from aioduco.api import ranges
from aioduco.api.section import Section
from aioduco.errors import DucoError, ParameterError
from aioduco.models.op import wire_op
from aioduco.supervision.command import MotionCommand

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.models.enums import Outcome
    from aioduco.models.op import Op
    from aioduco.models.pose import JointsLike, PoseLike
    from aioduco.supervision.task import Task

__all__ = ["Motion"]


class Motion(Section):
    """Motions of the arm (移动控制, manual 1.3.5).

    Each function checks its arguments and returns a motion as a value; nothing is sent before it
    is awaited, started, or run:

        await robot.motion.movej2(home, v=1.0, a=1.0)
        move = await robot.motion.movel(target, v=0.2, a=0.5).start()
        await robot.motion.run(approach, pass_by, retreat)
    """

    __slots__ = ()

    def movej2(
        self,
        joints: JointsLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move to joint angles, all joints together (关节运动).

        Args:
            joints: where to, six angles in [-2π, 2π] [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            op: outputs set on the way; triggers by distance have no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        q = ranges.JOINTS("joints", joints)
        v_ = ranges.JOINT_SPEED("v", v)
        a_ = ranges.JOINT_ACCELERATION("a", a)
        r_ = ranges.BLEND_RADIUS("r", r)
        op_ = wire_op("op", op, joint_motion=True)
        def_acc_ = ranges.FLAG("def_acc", def_acc)
        return self._motion(
            lambda rpc: rpc.movej2(q, v_, a_, r_, False, op_, def_acc_),
            r_,
            estimate=None if def_acc_ else _joint_move_time(q, v_, a_),
        )

    def movej_pose2(
        self,
        pose: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool to a pose, all joints together, not along a line (关节运动到位姿).

        Args:
            pose: where to: the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles near which the target's are chosen [rad]; None for the present.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way; triggers by distance have no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p = ranges.POSE("pose", pose)
        v_ = ranges.JOINT_SPEED("v", v)
        a_ = ranges.JOINT_ACCELERATION("a", a)
        r_ = ranges.BLEND_RADIUS("r", r)
        near = ranges.JOINTS_NEAR("q_near", q_near)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        op_ = wire_op("op", op, joint_motion=True)
        def_acc_ = ranges.FLAG("def_acc", def_acc)
        return self._motion(
            lambda rpc: rpc.movej_pose2(p, v_, a_, r_, near, tool_, wobj_, False, op_, def_acc_),
            r_,
        )

    def movel(
        self,
        pose: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool to a pose along a line (直线运动).

        Args:
            pose: where to: the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles near the target, to check its branch [rad]; None for the present.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p = ranges.POSE("pose", pose)
        v_ = ranges.LINE_SPEED("v", v)
        a_ = ranges.LINE_ACCELERATION("a", a)
        r_ = ranges.BLEND_RADIUS("r", r)
        near = ranges.JOINTS_NEAR("q_near", q_near)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        op_ = wire_op("op", op)
        def_acc_ = ranges.FLAG("def_acc", def_acc)
        return self._motion(
            lambda rpc: rpc.movel(p, v_, a_, r_, near, tool_, wobj_, False, op_, def_acc_), r_
        )

    def movec(
        self,
        via: PoseLike,
        pose: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        mode: int = 0,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool to a pose along an arc (圆弧运动).

        Args:
            via: a pose on the arc (p1): x, y, z [m], rx, ry, rz [rad].
            pose: where to (p2): the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            mode: the orientation: 0 goes over to the end's, 1 stays as at the start, 2 stays
                fixed to the arc's tangent.
            q_near: joint angles near the target, to check its branch [rad]; None for the present.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p1, p2 = ranges.POSE("via", via), ranges.POSE("pose", pose)
        v_ = ranges.LINE_SPEED("v", v)
        a_ = ranges.LINE_ACCELERATION("a", a)
        r_ = ranges.BLEND_RADIUS("r", r)
        mode_ = ranges.ARC_MODE("mode", mode)
        near = ranges.JOINTS_NEAR("q_near", q_near)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        op_ = wire_op("op", op)
        def_acc_ = ranges.FLAG("def_acc", def_acc)
        return self._motion(
            lambda rpc: rpc.movec(
                p1, p2, v_, a_, r_, mode_, near, tool_, wobj_, False, op_, def_acc_
            ),
            r_,
        )

    def tcp_move(
        self,
        offset: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        tool: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool by an offset in its own frame, along a line (沿工具坐标系直线移动).

        Args:
            offset: by how much: x, y, z [m], rx, ry, rz [rad], in the frame of the tool.
            v: highest speed of the tool, 0.01 to 5 [m/s]; a turn without a way takes it in
                proportion.
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            tool: name of the tool; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p = ranges.POSE("offset", offset)
        v_ = ranges.LINE_SPEED("v", v)
        a_ = ranges.LINE_ACCELERATION("a", a)
        r_ = ranges.BLEND_RADIUS("r", r)
        tool_ = ranges.FRAME("tool", tool)
        op_ = wire_op("op", op)
        def_acc_ = ranges.FLAG("def_acc", def_acc)
        return self._motion(
            lambda rpc: rpc.tcp_move(p, v_, a_, r_, tool_, False, op_, def_acc_), r_
        )

    async def run(self, *motions: MotionCommand, ahead: int = 3) -> tuple[Outcome, ...]:
        """Send motions one after another, ahead of the arm, and wait for all of them.

        The controller can blend a motion into the next only if it has that one in time. So some
        are sent ahead; the others follow as the first ones end.

        Args:
            motions: in the order in which they are to be carried out.
            ahead: how many the controller has at most, the running one included, from 1 on.

        Returns:
            The outcome of each: finished or blended.

        Raises:
            TaskError: one did not succeed. Those after it were stopped, or not sent.
            ParameterError: something in `motions` is no motion; nothing was sent.

        If this is cancelled, the arm is stopped.
        """
        for number, motion in enumerate(motions):
            if not isinstance(motion, MotionCommand):
                raise ParameterError(f"motions[{number}]", motion, "a motion")
            motion.hand_over()
        if ahead < 1:
            raise ParameterError("ahead", ahead, "a whole number from 1 on")
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


def _joint_move_time(
    target: Sequence[float], v: float, a: float
) -> Callable[[Sequence[float]], float]:
    """How long a joint move takes from given joints on: speed up, go on, slow down."""

    def seconds(start: Sequence[float]) -> float:
        way = max(abs(end - begin) for begin, end in zip(start, target, strict=False))
        if way >= v * v / a:
            return way / v + v / a
        return 2.0 * math.sqrt(way / a)

    return seconds
