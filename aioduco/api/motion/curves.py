"""Motions of the tool along arcs, circles, splines and spirals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.arguments import frames, limits, line, outputs
from aioduco.api.points import points_with_outputs
from aioduco.api.section import Section
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.pose import JointsLike, Pose, PoseLike

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco.models.op import Op, PointOp
    from aioduco.models.rules import Real
    from aioduco.supervision.command import MotionCommand


class Curves(Section):
    """Motions of the tool along curves."""

    __slots__ = ()

    def movec(
        self,
        via: PoseLike,
        pose: PoseLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
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
            pose: target pose (p2) of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            mode: orientation of the tool: 0 changes to that of the end pose, 1 stays as at the
                start, 2 stays fixed to the arc's tangent.
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
        p1, p2 = ranges.POSE("via", via), ranges.POSE("pose", pose)
        v_, a_, r_ = line(v, a, r)
        mode_ = ranges.ARC_MODE("mode", mode)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc)
        return self._motion(calls.movec(p1, p2, v_, a_, r_, mode_, *there, *end), r_)

    def move_circle(
        self,
        p1: PoseLike,
        p2: PoseLike,
        v: Real,
        a: Real,
        *,
        r: Real = 0.0,
        mode: int = 1,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool along a whole circle (圆周运动), from its present pose through two poses.

        Args:
            p1: the first pose on the circle: x, y, z [m], rx, ry, rz [rad].
            p2: the second pose on the circle; the order start, p1, p2 gives the direction.
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            mode: orientation of the tool: 1 as at the start, 2 fixed to the circle's tangent.
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
        p1_, p2_ = ranges.POSE("p1", p1), ranges.POSE("p2", p2)
        v_, a_, r_ = line(v, a, r)
        mode_ = ranges.CIRCLE_MODE("mode", mode)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc)
        return self._motion(calls.move_circle(p1_, p2_, v_, a_, r_, mode_, *there, *end), r_)

    def spline(
        self,
        poses: Iterable[PoseLike],
        v: Real,
        a: Real,
        *,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        r: Real = 0.0,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool along a spline through poses (样条运动).

        If two splines follow each other, the second one must not begin with the last pose of the
        first.

        Args:
            poses: 1 to 50 poses of the tool in the work object; the first may be the present
                pose; x, y, z [m], rx, ry, rz [rad]. Shape (n, 6).
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            r: blend radius into the next motion [m]; 0 to stop at the end.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        points = ranges.SPLINE_POINTS("poses", poses)
        v_, a_, r_ = line(v, a, r)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        block, op_, def_acc_ = outputs(op, def_acc)
        return self._motion(
            calls.spline(points, v_, a_, tool_, wobj_, block, op_, r_, def_acc_), r_
        )

    def spline_op(
        self,
        points: Iterable[PointOp],
        v: Real,
        a: Real,
        *,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        r: Real = 0.0,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool along a spline, and set outputs at its points (样条运动, 触发点位 OP).

        If two splines follow each other, the second one must not begin with the last pose of the
        first.

        Args:
            points: 1 to 50 poses of the tool in the work object, each with outputs to set there.
            v: speed of the tool, 0.00001 to 5 [m/s].
            a: acceleration of the tool, from 0.00001 [m/s²].
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way along the whole spline.
            r: blend radius into the next motion [m]; 0 to stop at the end.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        given = points_with_outputs("points", points, ranges.SPLINE_COUNT, Pose)
        points_ = [point.wire(f"points[{number}]") for number, point in enumerate(given)]
        v_, a_, r_ = limits(ranges.FINE_SPEED, ranges.FINE_ACCELERATION, v, a, r)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        block, op_, def_acc_ = outputs(op, def_acc)
        return self._motion(
            calls.spline_op(points_, v_, a_, tool_, wobj_, block, op_, r_, def_acc_), r_
        )

    def move_spiral(
        self,
        center: PoseLike,
        pose: PoseLike | None,
        rev: Real,
        length: Real,
        radius: Real,
        mode: int,
        v: Real,
        a: Real,
        *,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool along a spiral (螺旋运动), given by parameters or by its end.

        Args:
            center: pose of the spiral's centre (p1): x, y, z [m], rx, ry, rz [rad].
            pose: target pose (p2): x, y, z [m], rx, ry, rz [rad]; None in mode 0, which ignores it.
            rev: total number of turns, negative for clockwise.
            length: distance along the axis (len) [m], signed by the right-hand rule; mode 1
                ignores it.
            radius: radius at the end (rad, once red in the manual), from 0 [m]; mode 1 ignores
                it.
            mode: 0 for a spiral given by parameters, 1 for one given by its end.
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range, or `pose` is missing in mode 1.

        Manual section 1.3.5.
        """
        p1 = ranges.POSE("center", center)
        mode_ = ranges.SPIRAL_MODE("mode", mode)
        if pose is None and mode_ == 1:
            raise ParameterError("pose", pose, "a pose in mode 1: the spiral's end")
        # In mode 0 the controller ignores the pose, but reads six numbers.
        p2 = p1 if pose is None else ranges.POSE("pose", pose)
        rev_ = ranges.SPIRAL_TURNS("rev", rev)
        length_ = ranges.SPIRAL_LENGTH("length", length)
        radius_ = ranges.SPIRAL_RADIUS("radius", radius)
        v_ = ranges.LINE_SPEED("v", v)
        a_ = ranges.LINE_ACCELERATION("a", a)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc)
        return self._motion(
            calls.move_spiral(p1, p2, rev_, length_, radius_, mode_, v_, a_, *there, *end)
        )
