"""Motions that are planned as a whole (manual 1.3.5)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from aioduco.models.ranges import BLEND_PERCENT
from aioduco.models.rotation import Array, transform
from aioduco.sim.controller.triggers import point_trigger
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import task
from aioduco.sim.handlers.paths import DEFAULT_JOINT_ACCELERATION, PathSection, blend, motion
from aioduco.sim.planner.segments import Segment, line_move, spiral_move, spline_move
from aioduco.sim.planner.slices import in_turn
from aioduco.sim.refusal import mismatch

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.sim.cabinet.tools import NamedFrame
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.handlers.paths import MotionCall


_MOST_POINTS = 50
_SPLINES = ("spline", "spline_op")
_FINE_SPEED = (1e-5, 5.0, "m/s")
_FINE_ACCELERATION = (1e-5, math.inf, "m/s²")
_BY_PARAMETERS, _BY_END = 0, 1
#: what the radii of movej and movej_pose are percent of: an assumption [m]
_LARGEST_RADIUS = 0.2


class MotionHandlers(PathSection):
    """movej to movec, circles, spirals and splines, lines by an offset, set_blend_ahead."""

    @motion(line=False)
    def movej2(self, call: MotionCall) -> Plan:
        """Move to joint angles; all joints arrive together."""
        return self._to_joints(call, self._joint_pace(call))

    @motion(line=False)
    def movej(self, call: MotionCall) -> Plan:
        """The same as movej2 with speed and acceleration in percent; not in the manual."""
        return self._to_joints(call, *self._percent(call))

    @motion(line=False)
    def movej_pose2(self, call: MotionCall) -> Plan:
        """Move to a pose of the tool in joint space; all joints arrive together."""
        return self._to_pose(call, self._joint_pace(call))

    @motion(line=False)
    def movej_pose(self, call: MotionCall) -> Plan:
        """The same as movej_pose2 with speed and acceleration in percent; not in the manual."""
        return self._to_pose(call, *self._percent(call))

    @motion()
    def movel(self, call: MotionCall) -> Plan:
        """Move to a pose of the tool; the tip moves along a straight line."""
        return self._to_line(call, self._line_pace(call))

    @motion()
    def movec(self, call: MotionCall) -> Plan:
        """Move along an arc through p1 to p2."""
        return self._to_arc(call, self._line_pace(call))

    def _percent(self, call: MotionCall) -> tuple[tuple[float, float], float]:
        """Convert percent of the slowest joint's speed, the default acceleration, and a radius."""
        speed = arguments.positive("v", call.v, 100.0, "%") / 100.0 * min(self._arm.velocity)
        radius = arguments.number("r", call.r, 0.0, BLEND_PERCENT.high, "%") / 100.0
        change = math.inf
        if not call.def_acc:
            share = arguments.positive("a", call.a, 100.0, "%") / 100.0
            change = share * DEFAULT_JOINT_ACCELERATION
        return (speed, change), radius * _LARGEST_RADIUS

    # -- circles, spirals and splines -------------------------------------------------------------

    @motion()
    def move_circle(self, call: MotionCall) -> Plan:
        """Move once round the circle through p1 and p2."""
        return self._to_arc(call, self._line_pace(call), circle=True)

    @motion()
    def move_spiral(self, call: MotionCall) -> Plan:
        """Move along a spiral about the z axis of p1, to a radius and a height or to p2."""
        arguments.choice("mode", call.mode, (_BY_PARAMETERS, _BY_END), "0 or 1")
        base = self._frames.wobj(call.wobj)
        centre = base.matrix @ arguments.pose("p1", call.p1).matrix
        tip = self._frames.tool(call.tool).matrix
        target = self._target("p2", call.p2, call)[0] if call.mode == _BY_END else None
        turns = arguments.number("rev", call.rev, -1000.0, 1000.0, "turns")
        axial = arguments.number("len", call.len, -10.0, 10.0, "m") if target is None else 0.0
        end = arguments.number("r", call.r, 0.0, 10.0, "m") if target is None else 0.0
        pace, options = self._line_pace(call), self._path_options(call.wobj)
        ways: Any = {"axial": axial, "radius": end, "target": target, "tool": tip, **options}
        return self._verified(
            lambda start: spiral_move(self._arm, start, centre, turns, *pace, **ways), call.q_near
        )

    @motion()
    def spline(self, call: MotionCall) -> Plan:
        """Move along a smooth curve through up to 50 poses."""
        return self._spline(call, call.pose_list, self._line_pace(call))

    @motion()
    def spline_op(self, call: MotionCall) -> Plan:
        """The same as spline, with triggers at the poses."""
        for point in call.pose_list:
            fire = point_trigger(point.op, self._signals, self._forgiving)
            if fire is not None:
                place, _ = self._target("pose_list", point.pos, call)
                call.points.append((place[:3, 3], fire))
        # The manual gives smaller minimum values for this function than for spline.
        pace = self._line_pace(call, _FINE_SPEED, _FINE_ACCELERATION)
        return self._spline(call, [point.pos for point in call.pose_list], pace)

    def _spline(
        self, call: MotionCall, poses: Sequence[Sequence[float]], pace: tuple[float, float]
    ) -> Plan:
        if not 1 <= len(poses) <= _MOST_POINTS:
            raise mismatch(f"pose_list has {len(poses)} poses, but must have 1 to {_MOST_POINTS}")
        used, base = self._frames.tool(call.tool), self._frames.wobj(call.wobj).matrix
        tip, flange = used.matrix, used.inverse
        given = [arguments.pose("pose_list", p) for p in poses]
        radius, options = blend(call.r), self._path_options(call.wobj)
        apart = self._controller.last_motion in _SPLINES

        def path(start: Array) -> Segment:
            # Computed here, without the controller's lock: fifty poses take a millisecond.
            targets = in_turn(lambda pose: base @ pose.matrix @ flange, given)
            return spline_move(
                self._arm, start, targets, *pace, radius, tool=tip, apart=apart, **options
            )

        return path

    # -- lines by an offset from the end of the previous motion -----------------------------------

    @motion()
    def tcp_move(self, call: MotionCall) -> Plan:
        """Move by an offset in the tool's frame."""
        used = self._frames.tool(call.tool)
        step = arguments.pose("pose_offset", call.pose_offset).matrix
        return self._offset_move(call, lambda tip: tip @ step, used)

    @motion()
    def tcp_move_2p(self, call: MotionCall) -> Plan:
        """Move by the displacement from p1 to p2, in the tool's frame: tip · p1⁻¹ · p2."""
        used = self._frames.tool(call.tool)
        self._frames.wobj(call.wobj)  # it cancels out, but must exist
        first, second = arguments.pose("p1", call.p1), arguments.pose("p2", call.p2)
        step = first.inverse().matrix @ second.matrix
        return self._offset_move(call, lambda tip: tip @ step, used, call.wobj)

    @motion()
    def wobj_move(self, call: MotionCall) -> Plan:
        """Move by an offset along and about the axes of the work object."""
        step = arguments.pose("pose_offset", call.pose_offset).matrix
        axes = self._frames.wobj(call.wobj).matrix[:3, :3]
        used = self._frames.tool()
        return self._offset_move(call, lambda tip: _along(tip, axes, step), used, call.wobj)

    @motion()
    def wobj_move_2p(self, call: MotionCall) -> Plan:
        """Move by the displacement from p1 to p2, along and about the axes of the work object."""
        used = self._frames.tool(call.tool)
        axes = self._frames.wobj(call.wobj).matrix[:3, :3]
        first, second = arguments.pose("p1", call.p1).matrix, arguments.pose("p2", call.p2).matrix
        step = transform(second[:3, :3] @ first[:3, :3].T, second[:3, 3] - first[:3, 3])
        return self._offset_move(call, lambda tip: _along(tip, axes, step), used, call.wobj)

    @task()
    def set_blend_ahead(self, controller: Controller, per: int, num: int) -> None:
        """Set how far programs read motions ahead, and when blocking calls are answered."""
        arguments.choice("per", per, range(101), "from 0 to 100 %")
        if per == 0:
            # A client may leave `num` out: then it is 0 on the wire, which means 1.
            arguments.choice("num", num, range(4), "from 1 to 3")
        controller.read_ahead = per, max(num, 1)

    def _offset_move(
        self, call: MotionCall, moved: Callable[[Array], Array], tool: NamedFrame, wobj: str = ""
    ) -> Plan:
        pace, radius = self._line_pace(call), blend(call.r)
        options = self._path_options(wobj)

        def from_there(start: Array) -> Segment:
            target = moved(self._arm.fkine(start) @ tool.matrix) @ tool.inverse
            return line_move(self._arm, start, target, *pace, radius, tool=tool.matrix, **options)

        return from_there


def _along(tip: Array, axes: Array, step: Array) -> Array:
    """Move a tip along given axes, and turn it in place about them."""
    turned = axes @ step[:3, :3] @ axes.T @ tip[:3, :3]
    return transform(turned, tip[:3, 3] + axes @ step[:3, 3])
