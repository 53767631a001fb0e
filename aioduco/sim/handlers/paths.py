"""Base of the handlers of motions along a path (manual 1.3.5)."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from aioduco.errors import Unreachable
from aioduco.kinematics.forward import singular_values
from aioduco.models.enums import OperationMode
from aioduco.sim import trial
from aioduco.sim.controller.triggers import MotionTriggers, motion_triggers
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import HandlerSection, arguments_of, as_on_the_wire
from aioduco.sim.planner.curves import StraightLine
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.segments import (
    arc_move,
    flange_along,
    joint_move,
    line_move,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco._wire.rpc import Op
    from aioduco.models.rotation import Array
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.planner.segments import PathOptions, Segment


#: names that functions with external axes have for the same arguments
_SAME: Final = {"rad": "r", "qnear": "q_near"}


class MotionCall:
    """The arguments of one call, by their names on the wire; each function has some of them.

    Attributes:
        points: positions on the path with the action at each, in order; what plans the motion
            fills it.
    """

    joints_list: Sequence[float]
    p: Sequence[float]
    p1: Sequence[float]
    p2: Sequence[float]
    pose_offset: Sequence[float]
    pose_list: Sequence[Any]
    q_near: Sequence[float]
    tool: str
    wobj: str
    v: float
    a: float
    r: float
    mode: int
    rev: float
    len: float
    kp: float
    kd: float
    smooth_vel: float
    smooth_acc: float
    scheme_name: Any
    epose: Any
    eaxis_v: Any
    block: bool
    op: Op
    def_acc: bool

    def __init__(self, names: Sequence[str], values: Sequence[Any]) -> None:
        self.points: list[tuple[Array, Callable[[], None]]] = []
        for name, value in zip(names, values, strict=True):
            setattr(self, _SAME.get(name, name), value)


#: lowest, highest and unit
Range: TypeAlias = tuple[float, float, str]

#: range of the speeds and accelerations of joints, unless a function has its own
JOINT_SPEED = (math.radians(0.01), 1.25 * math.pi, "rad/s")
JOINT_ACCELERATION = (math.radians(0.01), math.inf, "rad/s²")
_LINE_SPEED = (0.01, 5.0, "m/s")
_LINE_ACCELERATION = (0.01, math.inf, "m/s²")
#: what percent of an acceleration are of: an assumption
DEFAULT_JOINT_ACCELERATION = 5.0
DEFAULT_LINE_ACCELERATION = 2.0
#: the kind of deviation that is forgiven for the speed of a motion with a target
TOO_FAST = "speed above its range"
#: parts of a branch, and the least distance of both configurations from the singularity between
#: its two sides: closer to it the sign of a value is unreliable [m; sines]
_BRANCH = ("shoulder", "elbow", "wrist")
_MIRRORED = 0.02
_UNLIMITED_ACCELERATION = 1e3  # stands for an acceleration that only the joints limit [m/s²]


class PathSection(HandlerSection):
    """Base of the handlers of motions that are planned as a whole."""

    def _motion(
        self, name: str, call: MotionCall, plan: Callable[[MotionCall], Plan], line: bool
    ) -> int:
        """Queue a motion: see `motion`."""

        def command(controller: Controller) -> int:
            named = getattr(call, "tool", "")  # motions to joint angles name none
            tool = self._frames.tool(named).matrix

            def tip(q: Array) -> Array:
                return (self._arm.fkine(q) @ tool)[:3, 3]

            planned = plan(call)
            if trial.current is not None:
                planned = trial.current.planned(name, self._arm, planned)
            triggers = motion_triggers(call.op, self._signals, tip, self._forgiving, distance=line)
            if call.points:
                triggers = triggers or MotionTriggers(tip)
                triggers.points.extend(call.points)
                triggers.flange = lambda q: self._arm.fkine(q)[:3, 3]
            return controller.move(name, planned, triggers)

        return self._task(name, call.block, command)

    def _joint_pace(self, call: MotionCall) -> tuple[float, float]:
        """Speed and acceleration of joints, as requested or as the controller chooses them."""
        return self._pace(call, JOINT_SPEED, JOINT_ACCELERATION, math.inf)

    def _line_pace(
        self,
        call: MotionCall,
        speeds: Range = _LINE_SPEED,
        accelerations: Range = _LINE_ACCELERATION,
    ) -> tuple[float, float]:
        """Speed and acceleration of the tool, as requested or as the controller chooses them."""
        return self._pace(call, speeds, accelerations, _UNLIMITED_ACCELERATION)

    def _pace(
        self, call: MotionCall, speeds: Range, accelerations: Range, steepest: float
    ) -> tuple[float, float]:
        """Speed and acceleration within their ranges, or the highest speed and `steepest`."""
        switches, mode = self._controller.optimization, self._runtime.snapshot.view.mode
        speed, change = speeds[1], steepest
        fast = switches.speed and mode is OperationMode.AUTO
        if not fast:
            speed = arguments.at_most(self._forgiving, TOO_FAST, "v", call.v, *speeds)
        if not (fast or switches.acceleration or call.def_acc):
            change = arguments.number("a", call.a, *accelerations)
        return speed, change

    def _path_options(self, wobj: str = "") -> PathOptions:
        """Options of paths at a work object, by the settings that are switched on."""
        weave = self._controller.weaving.active
        if weave is not None:
            axes = self._frames.wobj(wobj).matrix[:3, :3]
            weave = replace(weave, work_object=axes)
        around = self._controller.optimization.avoids
        return {"weave": weave, "around": around}

    def _to_joints(
        self, call: MotionCall, pace: tuple[float, float], radius: float | None = None
    ) -> Plan:
        """Plan a motion to joint angles; all joints arrive together."""
        end = np.array(arguments.joints("joints_list", call.joints_list))
        radius = blend(call.r) if radius is None else radius
        tip = self._frames.tool().matrix
        return lambda start: joint_move(self._arm, start, end, *pace, radius, tool=tip)

    def _to_pose(
        self, call: MotionCall, pace: tuple[float, float], radius: float | None = None
    ) -> Plan:
        """Plan a motion to a pose of the tool in joint space; all joints arrive together."""
        target, tip = self._target("p", call.p, call)
        reference, radius = near(call.q_near), blend(call.r) if radius is None else radius

        def planned(start: Array) -> Segment:
            try:
                end = self._inverse(target, start if reference is None else reference)
            except PlanError as error:
                way = StraightLine.between(self._arm.fkine(start), target)
                error.flange = flange_along(way, np.eye(4))
                raise
            return joint_move(self._arm, start, end, *pace, radius, tool=tip)

        return planned

    def _to_line(self, call: MotionCall, pace: tuple[float, float]) -> Plan:
        """Plan a motion to a pose of the tool; the tip moves along a straight line."""
        target, tip = self._target("p", call.p, call)
        radius, options = blend(call.r), self._path_options(call.wobj)
        return self._verified(
            lambda start: line_move(self._arm, start, target, *pace, radius, tool=tip, **options),
            call.q_near,
        )

    def _to_arc(self, call: MotionCall, pace: tuple[float, float], *, circle: bool = False) -> Plan:
        """Plan a motion along an arc through p1 to p2, or once round the circle through them."""
        via, tip = self._target("p1", call.p1, call)
        target, _ = self._target("p2", call.p2, call)
        modes, names = ((1, 2), "1 or 2") if circle else ((0, 1, 2), "0, 1 or 2")
        arguments.choice("mode", call.mode, modes, names)
        radius, options = blend(call.r), self._path_options(call.wobj)
        ways: Any = {"mode": call.mode, "full": circle, "tool": tip, **options}
        return self._verified(
            lambda start: arc_move(self._arm, start, via, target, *pace, radius, **ways),
            call.q_near,
        )

    def _verified(self, plan: Plan, q_near: Sequence[float]) -> Plan:
        """Wrap a plan so that its path must end in the branch of `q_near`, if that is given."""
        reference = near(q_near)
        if reference is None:
            return plan
        wanted = singular_values(self._arm.geometry, reference)

        def verified(start: Array) -> Segment:
            segment = plan(start)
            found = singular_values(self._arm.geometry, segment.q_end)
            other = (np.sign(wanted) != np.sign(found)) & (
                np.minimum(np.abs(wanted), np.abs(found)) > _MIRRORED
            )
            if other.any():
                which = ", ".join(np.array(_BRANCH)[other])
                error = PlanError(
                    "parameter",
                    f"q_near is in another branch than the end of the path: {which} mirrored",
                )
                error.joints = segment.q_end
                raise error
            return segment

        return verified

    def _inverse(self, flange: Array, reference: Array) -> Array:
        """Find joints for a pose of the flange, near to others [rad].

        Raises:
            PlanError: the pose is out of reach.
        """
        try:
            return self._arm.ikine(flange, reference)
        except Unreachable as exc:
            raise PlanError("unreachable", str(exc)) from exc

    def _target(self, name: str, p: Sequence[float], call: MotionCall) -> tuple[Array, Array]:
        """Pose of the flange in the base frame, and of the tool's tip in the flange's."""
        used = self._frames.tool(call.tool)
        base = self._frames.wobj(call.wobj)
        return base.matrix @ arguments.pose(name, p).matrix @ used.inverse, used.matrix


def motion(
    *, line: bool = True
) -> Callable[[Callable[[Any, MotionCall], Plan]], Callable[..., int]]:
    """Make a handler that queues a motion of what plans it.

    The plan has the function's name, and is made from the call; it raises Rejected if an argument
    is wrong.

    Args:
        line: whether its path has a length in metres, for triggers by distance.
    """

    def handler_of(plan: Callable[[Any, MotionCall], Plan]) -> Callable[..., int]:
        names = arguments_of(plan.__name__)

        def answer(self: PathSection, *values: Any) -> int:
            call = MotionCall(names, values)
            return self._motion(plan.__name__, call, partial(plan, self), line)

        return as_on_the_wire(plan, answer)

    return handler_of


def near(q_near: Sequence[float]) -> Array | None:
    """Reference joints; None if none are given."""
    return np.array(arguments.joints("q_near", q_near)) if q_near else None


def blend(r: float) -> float:
    """Check the radius of a blend [m]."""
    return arguments.number("r", r, 0.0, math.inf, "m")
