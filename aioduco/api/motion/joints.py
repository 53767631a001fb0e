"""Motions of the joints to a target: all joints begin and end together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.arguments import frames, limits, outputs
from aioduco.api.section import Section
from aioduco.models import ranges
from aioduco.supervision.task_state import JointEta

if TYPE_CHECKING:
    from aioduco.models.op import Op
    from aioduco.models.pose import JointsLike, PoseLike
    from aioduco.models.rules import Real
    from aioduco.supervision.command import MotionCommand


class JointMotions(Section):
    """Motions of the joints, at speeds in rad/s or in percent."""

    __slots__ = ()

    def movej2(
        self,
        joints: JointsLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move to joint angles, all joints together (关节运动).

        Args:
            joints: target, six angles in [-2π, 2π] [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            op: outputs set on the way, by time: a distance is refused, since it has no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        q = ranges.JOINTS("joints", joints)
        v_, a_, r_ = limits(ranges.JOINT_SPEED, ranges.JOINT_ACCELERATION, v, a, r)
        end = outputs(op, def_acc, joint_motion=True)
        return self._motion(
            calls.movej2(q, v_, a_, r_, *end),
            r_,
            eta=JointEta(q, v_, None if end[2] else a_),
        )

    def movej_pose2(
        self,
        pose: PoseLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool to a pose, all joints together, not along a line (关节运动到位姿).

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way, by time: a distance is refused, since it has no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p = ranges.POSE("pose", pose)
        v_, a_, r_ = limits(ranges.JOINT_SPEED, ranges.JOINT_ACCELERATION, v, a, r)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc, joint_motion=True)
        return self._motion(calls.movej_pose2(p, v_, a_, r_, *there, *end), r_)

    def movej(
        self,
        joints: JointsLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move to joint angles at a speed in percent (关节运动). `movej2` takes it in rad/s.

        Args:
            joints: target, six angles in [-2π, 2π] [rad].
            v: highest joint speed in percent of what the arm can do, above 0, up to 100.
            a: highest joint acceleration in percent of what the arm can do, above 0, up to 100.
            r: blend radius into the next motion in percent of the largest one that is set in the
                controller, from 0 to below 50; 0 to stop at the end.
            op: outputs set on the way, by time: a distance is refused, since it has no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Warns:
            UnitWarning: `v` looks like rad/s: it has a decimal point, and is at most 3.926.

        Not in the manual. The wire of 3.8 has it, and it is much used; the unit, percent, is what
        its users report, and the comments of the vendor's class.
        """
        q = ranges.JOINTS("joints", joints)
        v_, a_ = ranges.percent_of_speed("v", v), ranges.PERCENT("a", a)
        r_ = ranges.BLEND_PERCENT("r", r)
        end = outputs(op, def_acc, joint_motion=True)
        return self._motion(calls.movej(q, v_, a_, r_, *end), r_)

    def movej_pose(
        self,
        pose: PoseLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool to a pose by the joints at a speed in percent (关节运动到位姿).

        `movej_pose2` takes the speed in rad/s.

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest joint speed in percent of what the arm can do, above 0, up to 100.
            a: highest joint acceleration in percent of what the arm can do, above 0, up to 100.
            r: blend radius into the next motion in percent of the largest one that is set in the
                controller, from 0 to below 50; 0 to stop at the end.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way, by time: a distance is refused, since it has no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Warns:
            UnitWarning: `v` looks like rad/s: it has a decimal point, and is at most 3.926.

        Not in the manual. The wire of 3.8 has it, and it is much used; the unit, percent, is what
        its users report, and the comments of the vendor's class.
        """
        p = ranges.POSE("pose", pose)
        v_, a_ = ranges.percent_of_speed("v", v), ranges.PERCENT("a", a)
        r_ = ranges.BLEND_PERCENT("r", r)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc, joint_motion=True)
        return self._motion(calls.movej_pose(p, v_, a_, r_, *there, *end), r_)
