"""External axes: schemes, and motions of axes and arm (外部轴, manual 1.3.14)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from aioduco._wire.rpc import EAxisParam, EAxisSchemeParam, EAxissInfo
from aioduco.models.enums import TaskState
from aioduco.sim.cabinet.axis_schemes import Axis
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import task
from aioduco.sim.handlers.paths import MotionCall, PathSection, motion
from aioduco.sim.planner.segments import Segment, stay
from aioduco.sim.refusal import illegal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.sim.controller.state_machine import Controller


_FARTHEST = 1e4  # stands for an unlimited range [rad or m]
_SPEEDS = (1e-6, 1e4, "rad/s or m/s")  # least above zero, and largest finite
_ACCELERATIONS = (1e-6, 1e6, "rad/s² or m/s²")
#: the manual's ranges begin at zero, unlike those of movel
_TOOL_SPEED = (1e-6, 5.0, "m/s")
_TOOL_ACCELERATION = (1e-6, math.inf, "m/s²")


class ExternalAxisHandlers(PathSection):
    """add_eaxis_scheme to get_eaxis_info, move_eaxis to move_circle_eaxis, move_jog_eaxis."""

    # -- set-up --------------------------------------------------------------------------------

    @task()
    def set_eaxis_param(self, controller: Controller, num: int, param: EAxisParam) -> None:
        """Set up an axis; parameters of drives and encoders have no effect here."""
        controller.external_axes.set_axis(num, _axis(param))

    @task()
    def set_eaxiss_scheme_param(
        self, controller: Controller, num: int, param: EAxisSchemeParam
    ) -> None:
        """Set which axes belong to a scheme; their placement has no effect here."""
        controller.external_axes.link(num, param.axis_link)

    def add_eaxis_scheme(self, num: int, block: bool) -> int:
        """Add a scheme. It is called "scheme<num>" and has no axes yet."""
        return self._task("add_eaxis_scheme", block, lambda c: c.external_axes.add(num))

    def delete_eaxis_scheme(self, num: int, block: bool) -> int:
        """Delete a scheme that is not active."""
        return self._task("delete_eaxis_scheme", block, lambda c: c.external_axes.delete(num))

    @task()
    def enable_eaxis_scheme(self, controller: Controller, scheme_name: str) -> None:
        """启动外部轴方案."""
        controller.external_axes.enable(scheme_name)

    @task()
    def disable_eaxis_scheme(self, controller: Controller, scheme_name: str) -> None:
        """结束外部轴方案, only while nothing moves."""
        if not controller.idle:
            raise illegal("motions are running")
        controller.external_axes.disable(scheme_name)

    def get_eaxis_info(self) -> list[EAxissInfo]:
        """Name of each scheme, whether it is active, and the position of its first axis."""
        states = self._controller.external_axes.states()
        return [EAxissInfo(each.name, int(each.active), each.position) for each in states]

    # -- motions -------------------------------------------------------------------------------

    @motion(line=False)
    def move_eaxis(self, call: MotionCall) -> Plan:
        """Move the axes alone; the arm stays where it is."""
        call.eaxis_v = call.v
        return self._with_axes(lambda start: stay(self._arm, start), call)

    @task()
    def move_jog_eaxis(self, controller: Controller, name: str, direction: int, vel: float) -> int:
        """Jog the first axis of a scheme, until stop_manual_move or the end of its range."""
        arguments.choice("direction", direction, (-1, 1), "-1 or 1")
        share = arguments.positive("vel", vel, 100.0, "%") / 100.0
        axes = controller.external_axes.jog(name, direction, share)
        return controller.jog(
            "move_jog_eaxis",
            lambda start: replace(stay(self._arm, start), axes=axes),
            TaskState.FINISHED,
        )

    @motion(line=False)
    def movej2_eaxis(self, call: MotionCall) -> Plan:
        """Move to joint angles, together with the axes."""
        return self._with_axes(self._to_joints(call, self._joint_pace(call)), call)

    @motion(line=False)
    def movej2_pose_eaxis(self, call: MotionCall) -> Plan:
        """Move to a pose of the tool in joint space, together with the axes."""
        return self._with_axes(self._to_pose(call, self._joint_pace(call)), call)

    @motion(line=False)
    def movel_eaxis(self, call: MotionCall) -> Plan:
        """Move along a line, together with the axes."""
        return self._with_axes(self._to_line(call, self._tool_pace(call)), call)

    @motion(line=False)
    def movec_eaxis(self, call: MotionCall) -> Plan:
        """Move along an arc, together with the axes."""
        return self._with_axes(self._to_arc(call, self._tool_pace(call)), call)

    @motion(line=False)
    def move_circle_eaxis(self, call: MotionCall) -> Plan:
        """Move once round a circle, together with the axes."""
        return self._with_axes(self._to_arc(call, self._tool_pace(call), circle=True), call)

    # -- shared parts --------------------------------------------------------------------------

    def _tool_pace(self, call: MotionCall) -> tuple[float, float]:
        return self._line_pace(call, _TOOL_SPEED, _TOOL_ACCELERATION)

    def _with_axes(self, plan: Plan, call: MotionCall) -> Plan:
        """Add a move of the axes of a scheme to a motion of the arm."""
        scheme_name, epose, eaxis_v = self._scheme(call)
        target = arguments.numbers("epose", epose, 3)
        speed = arguments.number("eaxis_v", eaxis_v, *_SPEEDS)
        external = self._controller.external_axes
        external.check_active(scheme_name)

        def both(start: Array) -> Segment:
            return replace(plan(start), axes=external.to(scheme_name, target, speed))

        return both

    def _scheme(self, call: MotionCall) -> tuple[str, Sequence[float], float]:
        """The scheme of a call, with the positions and the speed of its axes."""
        return call.scheme_name, call.epose, call.eaxis_v


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
