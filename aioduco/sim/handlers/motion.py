"""Motions that are planned as a whole (manual 1.3.5)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco.models.rotation import transform
from aioduco.sim.controller.triggers import point_trigger
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.paths import (
    DEFAULT_JOINT_ACCELERATION,
    PathSection,
    blend,
)
from aioduco.sim.planner.segments import line_move, spiral_move, spline_move
from aioduco.sim.planner.slices import in_turn
from aioduco.sim.refusal import mismatch

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco._wire.rpc import Op, PointOp
    from aioduco.models.rotation import Array
    from aioduco.sim.cabinet.tools import Tool
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.planner.segments import Segment


_MOST_POINTS = 50
_SPLINES = ("spline", "spline_op")
_FINE_SPEED = (1e-5, 5.0, "m/s")
_FINE_ACCELERATION = (1e-5, math.inf, "m/s²")
_BY_PARAMETERS, _BY_END = 0, 1


class MotionHandlers(PathSection):
    """movej to movec, circles, spirals and splines, lines by an offset, set_blend_ahead."""

    def movej2(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move to joint angles; all joints arrive together."""

        def plan() -> Plan:
            return self._to_joints(joints_list, self._joint_pace(v, a, def_acc), r)

        return self._motion("movej2", plan, op, block, line=False)

    def movej(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """The same as movej2 with speed and acceleration in percent; not in the manual."""

        def plan() -> Plan:
            return self._to_joints(joints_list, self._percent(v, a, def_acc), r)

        return self._motion("movej", plan, op, block, line=False)

    def movej_pose2(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        r: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move to a pose of the tool in joint space; all joints arrive together."""

        def plan() -> Plan:
            return self._to_pose(p, q_near, tool, wobj, self._joint_pace(v, a, def_acc), r)

        return self._motion("movej_pose2", plan, op, block, line=False)

    def movej_pose(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        r: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """The same as movej_pose2 with speed and acceleration in percent; not in the manual."""

        def plan() -> Plan:
            return self._to_pose(p, q_near, tool, wobj, self._percent(v, a, def_acc), r)

        return self._motion("movej_pose", plan, op, block, line=False)

    def movel(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        r: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move to a pose of the tool; the tip moves along a straight line."""

        def plan() -> Plan:
            return self._to_line(p, q_near, tool, wobj, self._line_pace(v, a, def_acc), r)

        return self._motion("movel", plan, op, block)

    def movec(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        mode: int,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move along an arc through p1 to p2."""

        def plan() -> Plan:
            pace = self._line_pace(v, a, def_acc)
            return self._to_arc(p1, p2, mode, q_near, tool, wobj, pace, r)

        return self._motion("movec", plan, op, block)

    def _percent(self, v: float, a: float, def_acc: bool) -> tuple[float, float]:
        """Convert percent of the slowest joint's speed and of the default acceleration."""
        speed = arguments.positive("v", v, 100.0, "%") / 100.0 * min(self._arm.velocity)
        if def_acc:
            return speed, DEFAULT_JOINT_ACCELERATION
        return speed, arguments.positive("a", a, 100.0, "%") / 100.0 * DEFAULT_JOINT_ACCELERATION

    # -- circles, spirals and splines -------------------------------------------------------------

    def move_circle(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        mode: int,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move once round the circle through p1 and p2."""

        def plan() -> Plan:
            pace = self._line_pace(v, a, def_acc)
            return self._to_arc(p1, p2, mode, q_near, tool, wobj, pace, r, circle=True)

        return self._motion("move_circle", plan, op, block)

    def move_spiral(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        rev: float,
        len: float,  # noqa: A002 - the name on the wire
        r: float,
        mode: int,
        v: float,
        a: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move along a spiral about the z axis of p1, to a radius and a height or to p2."""

        def plan() -> Plan:
            arguments.choice("mode", mode, (_BY_PARAMETERS, _BY_END), "0 or 1")
            base = self._frames.wobj(wobj)
            centre = base.matrix @ arguments.pose("p1", p1).matrix
            tip = self._frames.tool(tool).matrix
            target = self._target("p2", p2, tool, wobj)[0] if mode == _BY_END else None
            turns = arguments.number("rev", rev, -1000.0, 1000.0, "turns")
            axial = arguments.number("len", len, -10.0, 10.0, "m") if target is None else 0.0
            end = arguments.number("r", r, 0.0, 10.0, "m") if target is None else 0.0
            pace, options = self._line_pace(v, a, def_acc), self._path_options(wobj)
            return self._verified(
                lambda start: spiral_move(
                    self._arm,
                    start,
                    centre,
                    turns,
                    *pace,
                    axial=axial,
                    radius=end,
                    target=target,
                    tool=tip,
                    **options,
                ),
                q_near,
            )

        return self._motion("move_spiral", plan, op, block)

    def spline(
        self,
        pose_list: Sequence[Sequence[float]],
        v: float,
        a: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        r: float,
        def_acc: bool,
    ) -> int:
        """Move along a smooth curve through up to 50 poses."""

        def plan() -> Plan:
            pace = self._line_pace(v, a, def_acc)
            return self._spline(pose_list, pace, tool, wobj, r)

        return self._motion("spline", plan, op, block)

    def spline_op(
        self,
        pose_list: Sequence[PointOp],
        v: float,
        a: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        r: float,
        def_acc: bool,
    ) -> int:
        """The same as spline, with triggers at the poses."""
        fires: list[tuple[Array, Callable[[], None]]] = []

        def plan() -> Plan:
            poses = [point.pos for point in pose_list]
            for point in pose_list:
                fire = point_trigger(point.op, self._signals, self._forgiving)
                if fire is not None:
                    place, _ = self._target("pose_list", point.pos, tool, wobj)
                    fires.append((place[:3, 3], fire))
            # The manual gives smaller minimum values for this function than for spline.
            pace = self._line_pace(v, a, def_acc, _FINE_SPEED, _FINE_ACCELERATION)
            return self._spline(poses, pace, tool, wobj, r)

        return self._motion("spline_op", plan, op, block, points=fires)

    def _spline(
        self,
        poses: Sequence[Sequence[float]],
        pace: tuple[float, float],
        tool: str,
        wobj: str,
        r: float,
    ) -> Plan:
        if not 1 <= len(poses) <= _MOST_POINTS:
            raise mismatch(f"pose_list has {len(poses)} poses, but must have 1 to {_MOST_POINTS}")
        used, base = self._frames.tool(tool), self._frames.wobj(wobj).matrix
        tip, flange = used.matrix, used.inverse
        given = [arguments.pose("pose_list", p) for p in poses]
        radius, options = blend(r), self._path_options(wobj)
        apart = self._controller.last_motion in _SPLINES

        def path(start: Array) -> Segment:
            # Computed here, without the controller's lock: fifty poses take a millisecond.
            targets = in_turn(lambda pose: base @ pose.matrix @ flange, given)
            return spline_move(
                self._arm, start, targets, *pace, radius, tool=tip, apart=apart, **options
            )

        return path

    # -- lines by an offset from the end of the previous motion -----------------------------------

    def tcp_move(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move by an offset in the tool's frame."""

        def plan() -> Plan:
            used = self._frames.tool(tool)
            step = arguments.pose("pose_offset", pose_offset).matrix
            return self._offset_move(lambda tip: tip @ step, used, v, a, r, def_acc)

        return self._motion("tcp_move", plan, op, block)

    def tcp_move_2p(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move by the displacement from p1 to p2, in the tool's frame: tip · p1⁻¹ · p2."""

        def plan() -> Plan:
            used = self._frames.tool(tool)
            self._frames.wobj(wobj)  # it cancels out, but must exist
            first, second = arguments.pose("p1", p1), arguments.pose("p2", p2)
            step = first.inverse().matrix @ second.matrix
            return self._offset_move(lambda tip: tip @ step, used, v, a, r, def_acc, wobj)

        return self._motion("tcp_move_2p", plan, op, block)

    def wobj_move(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        r: float,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move by an offset along and about the axes of the work object."""

        def plan() -> Plan:
            step = arguments.pose("pose_offset", pose_offset).matrix
            axes = self._frames.wobj(wobj).matrix[:3, :3]
            used = self._frames.tool()
            return self._offset_move(
                lambda tip: _along(tip, axes, step), used, v, a, r, def_acc, wobj
            )

        return self._motion("wobj_move", plan, op, block)

    def wobj_move_2p(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move by the displacement from p1 to p2, along and about the axes of the work object."""

        def plan() -> Plan:
            used = self._frames.tool(tool)
            axes = self._frames.wobj(wobj).matrix[:3, :3]
            first, second = arguments.pose("p1", p1).matrix, arguments.pose("p2", p2).matrix
            step = transform(second[:3, :3] @ first[:3, :3].T, second[:3, 3] - first[:3, 3])
            return self._offset_move(
                lambda tip: _along(tip, axes, step), used, v, a, r, def_acc, wobj
            )

        return self._motion("wobj_move_2p", plan, op, block)

    def set_blend_ahead(self, per: int, num: int) -> int:
        """Set how far programs read motions ahead, and when blocking calls are answered."""

        def command(controller: Controller) -> None:
            arguments.choice("per", per, range(101), "from 0 to 100 %")
            # A client may leave `num` out: then it is 0 on the wire, which means 1.
            arguments.choice("num", num, range(4), "from 1 to 3")
            controller.read_ahead = per, max(num, 1)

        return self._task("set_blend_ahead", True, command)

    def _offset_move(
        self,
        moved: Callable[[Array], Array],
        tool: Tool,
        v: float,
        a: float,
        r: float,
        def_acc: bool,
        wobj: str = "",
    ) -> Plan:
        pace, radius, options = self._line_pace(v, a, def_acc), blend(r), self._path_options(wobj)

        def from_there(start: Array) -> Segment:
            target = moved(self._arm.fkine(start) @ tool.matrix) @ tool.inverse
            return line_move(self._arm, start, target, *pace, radius, tool=tool.matrix, **options)

        return from_there


def _along(tip: Array, axes: Array, step: Array) -> Array:
    """Move a tip along given axes, and turn it in place about them."""
    turned = axes @ step[:3, :3] @ axes.T @ tip[:3, :3]
    return transform(turned, tip[:3, 3] + axes @ step[:3, 3])
