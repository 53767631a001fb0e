"""Motions of the tool along a line, to a pose or by an offset."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.arguments import frames, line, outputs
from aioduco.api.section import Section
from aioduco.models import ranges

if TYPE_CHECKING:
    from aioduco.models.op import Op
    from aioduco.models.pose import JointsLike, PoseLike
    from aioduco.models.rules import Real
    from aioduco.supervision.command import MotionCommand


class Lines(Section):
    """Motions of the tool along a line."""

    __slots__ = ()

    def movel(
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
        """Move the tool to a pose along a line (直线运动). The manual prints its name as move1.

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles near the target [rad], to check its branch; None: the present ones.
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
        v_, a_, r_ = line(v, a, r)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc)
        return self._motion(calls.movel(p, v_, a_, r_, *there, *end), r_)

    def tcp_move(
        self,
        offset: PoseLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
        tool: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool by an offset in its own frame, along a line (沿工具坐标系直线移动).

        Args:
            offset: translation x, y, z [m] and rotation rx, ry, rz [rad], in the tool's frame.
            v: highest speed of the tool, 0.01 to 5 [m/s]; an offset without translation turns at
                a speed scaled from it.
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
        v_, a_, r_ = line(v, a, r)
        tool_ = ranges.FRAME("tool", tool)
        end = outputs(op, def_acc)
        return self._motion(calls.tcp_move(p, v_, a_, r_, tool_, *end), r_)

    def tcp_move_2p(
        self,
        p1: PoseLike,
        p2: PoseLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool along a line by the offset between two poses, in the tool's frame.

        沿工具坐标系直线移动两点之差: the target is the present pose · p1⁻¹ · p2.

        Args:
            p1: the pose from which the offset is taken; x, y, z [m], rx, ry, rz [rad].
            p2: the pose to which the offset is taken; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s]; an offset without translation turns at
                a speed scaled from it.
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
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
        p1_, p2_ = ranges.POSE("p1", p1), ranges.POSE("p2", p2)
        v_, a_, r_ = line(v, a, r)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        end = outputs(op, def_acc)
        return self._motion(calls.tcp_move_2p(p1_, p2_, v_, a_, r_, tool_, wobj_, *end), r_)

    def wobj_move(
        self,
        offset: PoseLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool by an offset in the work object's frame (沿工件坐标系直线移动), in a line.

        Args:
            offset: translation x, y, z [m] and rotation rx, ry, rz [rad], in the work object's
                frame.
            v: highest speed of the tool, 0.01 to 5 [m/s]; an offset without translation turns at
                a speed scaled from it.
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p = ranges.POSE("offset", offset)
        v_, a_, r_ = line(v, a, r)
        wobj_ = ranges.FRAME("wobj", wobj)
        end = outputs(op, def_acc)
        return self._motion(calls.wobj_move(p, v_, a_, r_, wobj_, *end), r_)

    def wobj_move_2p(
        self,
        p1: PoseLike,
        p2: PoseLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool along a line by the offset between two poses, in the work object's frame.

        沿工件坐标系直线移动两点之差: the offset from p1 to p2 as it is in the work object's frame.

        Args:
            p1: the pose from which the offset is taken; x, y, z [m], rx, ry, rz [rad].
            p2: the pose to which the offset is taken; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s]; an offset without translation turns at
                a speed scaled from it.
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            tool: name of the tool of the two poses; empty for the one in use.
            wobj: name of the work object of the two poses; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p1_, p2_ = ranges.POSE("p1", p1), ranges.POSE("p2", p2)
        v_, a_, r_ = line(v, a, r)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        end = outputs(op, def_acc)
        return self._motion(calls.wobj_move_2p(p1_, p2_, v_, a_, r_, tool_, wobj_, *end), r_)
