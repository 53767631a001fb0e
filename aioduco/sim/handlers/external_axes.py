"""External axes: schemes, and motions of axes and arm (外部轴, manual 1.3.14)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from aioduco._wire.rpc import EAxissInfo
from aioduco.models.enums import TaskState
from aioduco.sim.cabinet.axis_schemes import Axis
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.paths import PathSection
from aioduco.sim.planner.segments import stay
from aioduco.sim.refusal import illegal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import EAxisParam, EAxisSchemeParam, Op
    from aioduco.models.rotation import Array
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.planner.segments import Segment


_FARTHEST = 1e4  # stands for an unlimited range [rad or m]
_SPEEDS = (1e-6, 1e4, "rad/s or m/s")  # least above zero, and largest finite
_ACCELERATIONS = (1e-6, 1e6, "rad/s² or m/s²")
#: the manual's ranges begin at zero, unlike those of movel
_TOOL_SPEED = (1e-6, 5.0, "m/s")
_TOOL_ACCELERATION = (1e-6, math.inf, "m/s²")


class ExternalAxisHandlers(PathSection):
    """add_eaxis_scheme to get_eaxis_info, move_eaxis to move_circle_eaxis, move_jog_eaxis."""

    # -- set-up --------------------------------------------------------------------------------

    def set_eaxis_param(self, num: int, param: EAxisParam, block: bool) -> int:
        """Set up an axis; parameters of drives and encoders have no effect here."""
        return self._task(
            "set_eaxis_param", block, lambda c: c.external_axes.set_axis(num, _axis(param))
        )

    def set_eaxiss_scheme_param(self, num: int, param: EAxisSchemeParam, block: bool) -> int:
        """Set which axes belong to a scheme; their placement has no effect here."""
        return self._task(
            "set_eaxiss_scheme_param", block, lambda c: c.external_axes.link(num, param.axis_link)
        )

    def add_eaxis_scheme(self, num: int, block: bool) -> int:
        """Add a scheme. It is called "scheme<num>" and has no axes yet."""
        return self._task("add_eaxis_scheme", block, lambda c: c.external_axes.add(num))

    def delete_eaxis_scheme(self, num: int, block: bool) -> int:
        """Delete a scheme that is not active."""
        return self._task("delete_eaxis_scheme", block, lambda c: c.external_axes.delete(num))

    def enable_eaxis_scheme(self, scheme_name: str) -> int:
        """启动外部轴方案."""
        return self._task(
            "enable_eaxis_scheme", True, lambda c: c.external_axes.enable(scheme_name)
        )

    def disable_eaxis_scheme(self, scheme_name: str) -> int:
        """结束外部轴方案, only while nothing moves."""

        def command(controller: Controller) -> None:
            if not controller.idle:
                raise illegal("motions are running")
            controller.external_axes.disable(scheme_name)

        return self._task("disable_eaxis_scheme", True, command)

    def get_eaxis_info(self) -> list[EAxissInfo]:
        """Name of each scheme, whether it is active, and the position of its first axis."""
        states = self._controller.external_axes.states()
        return [EAxissInfo(each.name, int(each.active), each.position) for each in states]

    # -- motions -------------------------------------------------------------------------------

    def move_eaxis(
        self, scheme_name: str, epose: Sequence[float], v: float, block: bool, op: Op
    ) -> int:
        """Move the axes alone; the arm stays where it is."""

        def plan() -> Plan:
            return self._with_axes(lambda start: stay(self._arm, start), scheme_name, epose, v)

        return self._motion("move_eaxis", plan, op, block, line=False)

    def move_jog_eaxis(self, name: str, direction: int, vel: float, block: bool) -> int:
        """Jog the first axis of a scheme, until stop_manual_move or the end of its range."""

        def command(controller: Controller) -> int:
            arguments.choice("direction", direction, (-1, 1), "-1 or 1")
            share = arguments.positive("vel", vel, 100.0, "%") / 100.0
            axes = controller.external_axes.jog(name, direction, share)
            return controller.jog(
                "move_jog_eaxis",
                lambda start: replace(stay(self._arm, start), axes=axes),
                TaskState.FINISHED,
            )

        return self._task("move_jog_eaxis", block, command)

    def movej2_eaxis(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        rad: float,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move to joint angles, together with the axes."""

        def plan() -> Plan:
            moved = self._to_joints(joints_list, self._joint_pace(v, a, def_acc), rad)
            return self._with_axes(moved, scheme_name, epose, eaxis_v)

        return self._motion("movej2_eaxis", plan, op, block, line=False)

    def movej2_pose_eaxis(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        rad: float,
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move to a pose of the tool in joint space, together with the axes."""

        def plan() -> Plan:
            pace = self._joint_pace(v, a, def_acc)
            moved = self._to_pose(p, qnear, tool, wobj, pace, rad)
            return self._with_axes(moved, scheme_name, epose, eaxis_v)

        return self._motion("movej2_pose_eaxis", plan, op, block, line=False)

    def movel_eaxis(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        rad: float,
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move along a line, together with the axes."""

        def plan() -> Plan:
            pace = self._line_pace(v, a, def_acc, _TOOL_SPEED, _TOOL_ACCELERATION)
            moved = self._to_line(p, qnear, tool, wobj, pace, rad)
            return self._with_axes(moved, scheme_name, epose, eaxis_v)

        return self._motion("movel_eaxis", plan, op, block, line=False)

    def movec_eaxis(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        rad: float,
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
        mode: int,
    ) -> int:
        """Move along an arc, together with the axes."""

        def plan() -> Plan:
            pace = self._line_pace(v, a, def_acc, _TOOL_SPEED, _TOOL_ACCELERATION)
            moved = self._to_arc(p1, p2, mode, qnear, tool, wobj, pace, rad)
            return self._with_axes(moved, scheme_name, epose, eaxis_v)

        return self._motion("movec_eaxis", plan, op, block, line=False)

    def move_circle_eaxis(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        rad: float,
        mode: int,
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move once round a circle, together with the axes."""

        def plan() -> Plan:
            pace = self._line_pace(v, a, def_acc, _TOOL_SPEED, _TOOL_ACCELERATION)
            moved = self._to_arc(p1, p2, mode, qnear, tool, wobj, pace, rad, circle=True)
            return self._with_axes(moved, scheme_name, epose, eaxis_v)

        return self._motion("move_circle_eaxis", plan, op, block, line=False)

    # -- shared parts --------------------------------------------------------------------------

    def _with_axes(
        self, plan: Plan, scheme_name: str, epose: Sequence[float], eaxis_v: float
    ) -> Plan:
        """Add a move of the axes of a scheme to a motion of the arm."""
        target = arguments.numbers("epose", epose, 3)
        speed = arguments.number("eaxis_v", eaxis_v, *_SPEEDS)
        external = self._controller.external_axes
        external.check_active(scheme_name)

        def both(start: Array) -> Segment:
            return replace(plan(start), axes=external.to(scheme_name, target, speed))

        return both


def _axis(param: EAxisParam) -> Axis:
    """Make an axis from those parameters that have an effect here."""
    limits = param.position_limit or (-_FARTHEST, _FARTHEST)
    lower, upper = (
        arguments.number("position_limit", limit, -_FARTHEST, _FARTHEST, "rad or m")
        for limit in arguments.numbers("position_limit", limits, 2)
    )
    fastest = arguments.number("max_velo", param.max_velo, *_SPEEDS)
    steepest = arguments.number("max_acc", param.max_acc, *_ACCELERATIONS)
    speed = _reference("ref_velo", param.ref_velo, fastest)
    return Axis(
        lower, upper, fastest, _reference("ref_acc", param.ref_acc, steepest), steepest, speed
    )


def _reference(name: str, value: float, most: float) -> float:
    """Check a reference value: at most `most`, which is also the value of one that is left out."""
    return most if value == 0.0 else arguments.number(name, value, 1e-6, most, "rad or m, s")
