"""Motions that are planned as a whole (manual 1.3.5)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from aioduco.errors import Unreachable
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import Section, mismatch
from aioduco.sim.planner.errors import PlanError
from aioduco.sim.planner.segments import arc_move, joint_move, line_move
from aioduco.sim.refusal import Refusal

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from aioduco._wire.rpc import Op
    from aioduco.sim.controller import Controller
    from aioduco.sim.motion import Plan
    from aioduco.sim.planner.segments import Segment

    Vector = NDArray[np.float64]
    Matrix = NDArray[np.float64]

_JOINT_SPEED = (math.radians(0.01), 1.25 * math.pi, "rad/s")
_JOINT_ACCELERATION = (math.radians(0.01), math.inf, "rad/s²")
_LINE_SPEED = (0.01, 5.0, "m/s")
_LINE_ACCELERATION = (0.01, math.inf, "m/s²")
#: what the controller takes when it is to choose the acceleration itself: an assumption
_DEFAULT_JOINT_ACCELERATION = 5.0
_DEFAULT_LINE_ACCELERATION = 2.0


class MotionHandlers(Section):
    """movej, movej2, movej_pose, movej_pose2, movel, movec, tcp_move."""

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
        """To joints, all arriving together."""

        def plan() -> Plan:
            return self._to_joints(joints_list, _joint_speed(v), _joint_acceleration(a, def_acc), r)

        return self._motion("movej2", plan, op, block)

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
        """The same with speed and acceleration in percent; not in the manual."""

        def plan() -> Plan:
            return self._to_joints(joints_list, *self._percent(v, a, def_acc), r)

        return self._motion("movej", plan, op, block)

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
        """To a pose of the tool, all joints arriving together."""

        def plan() -> Plan:
            speed, acceleration = _joint_speed(v), _joint_acceleration(a, def_acc)
            return self._to_pose(p, q_near, tool, wobj, speed, acceleration, r)

        return self._motion("movej_pose2", plan, op, block)

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
        """The same with speed and acceleration in percent; not in the manual."""

        def plan() -> Plan:
            return self._to_pose(p, q_near, tool, wobj, *self._percent(v, a, def_acc), r)

        return self._motion("movej_pose", plan, op, block)

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
        """To a pose of the tool, its tip going straight."""

        def plan() -> Plan:
            target, tip = self._target("p", p, tool, wobj)
            _near(q_near)
            speed, acceleration, blend = _line_speed(v), _line_acceleration(a, def_acc), _blend(r)
            return lambda start: line_move(
                self._arm, start, target, speed, acceleration, blend, tool=tip
            )

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
        """Along an arc through p1 to p2."""

        def plan() -> Plan:
            via, tip = self._target("p1", p1, tool, wobj)
            target, _ = self._target("p2", p2, tool, wobj)
            _near(q_near)
            if mode not in (0, 1, 2):
                raise mismatch(f"mode is {mode}, but must be 0, 1 or 2")
            speed, acceleration, blend = _line_speed(v), _line_acceleration(a, def_acc), _blend(r)
            return lambda start: arc_move(
                self._arm, start, via, target, speed, acceleration, blend, mode=mode, tool=tip
            )

        return self._motion("movec", plan, op, block)

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
        """Straight by an offset in the tool's frame, from where the motion before it ends."""

        def plan() -> Plan:
            used = arguments.tool(self._frames, tool)
            step = used.matrix @ arguments.pose("pose_offset", pose_offset).matrix @ used.inverse
            speed, acceleration, blend = _line_speed(v), _line_acceleration(a, def_acc), _blend(r)

            def from_there(start: Vector) -> Segment:
                target = self._arm.fkine(start) @ step
                return line_move(
                    self._arm, start, target, speed, acceleration, blend, tool=used.matrix
                )

            return from_there

        return self._motion("tcp_move", plan, op, block)

    # -- what they share -----------------------------------------------------------------------

    def _motion(self, name: str, plan: Callable[[], Plan], op: Op, block: bool) -> int:
        if op.time_or_dist_1 or op.time_or_dist_2 or op.time_or_dist_3:
            raise Refusal(f"{name}: triggers along the path (op) are not simulated yet")

        def command(controller: Controller) -> int:
            return controller.move(name, plan())

        return self._task(name, block, command)

    def _to_joints(self, target: Sequence[float], v: float, a: float, r: float) -> Plan:
        end = np.array(arguments.joints("joints_list", target))
        blend = _blend(r)
        tip = self._frames.tool().matrix
        return lambda start: joint_move(self._arm, start, end, v, a, blend, tool=tip)

    def _to_pose(
        self,
        p: Sequence[float],
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        v: float,
        a: float,
        r: float,
    ) -> Plan:
        target, tip = self._target("p", p, tool, wobj)
        near, blend = _near(q_near), _blend(r)

        def inverse(start: Vector) -> Segment:
            try:
                end = self._arm.ikine(target, start if near is None else near)
            except Unreachable as exc:
                raise PlanError("unreachable", str(exc)) from exc
            return joint_move(self._arm, start, end, v, a, blend, tool=tip)

        return inverse

    def _target(self, name: str, p: Sequence[float], tool: str, wobj: str) -> tuple[Matrix, Matrix]:
        """Pose of the flange in the base frame, and of the tool's tip in the flange's."""
        used = arguments.tool(self._frames, tool)
        base = arguments.wobj(self._frames, wobj)
        return base.matrix @ arguments.pose(name, p).matrix @ used.inverse, used.matrix

    def _percent(self, v: float, a: float, def_acc: bool) -> tuple[float, float]:
        """Percent of the slowest joint's speed, and of the acceleration the controller chooses."""
        speed = arguments.positive("v", v, 100.0, "%") / 100.0 * min(self._arm.velocity)
        if def_acc:
            return speed, _DEFAULT_JOINT_ACCELERATION
        return speed, arguments.positive("a", a, 100.0, "%") / 100.0 * _DEFAULT_JOINT_ACCELERATION


def _near(q_near: Sequence[float]) -> Vector | None:
    """Reference joints; None for none given."""
    return np.array(arguments.joints("q_near", q_near)) if q_near else None


def _blend(r: float) -> float:
    return arguments.number("r", r, 0.0, math.inf, "m")


def _joint_speed(v: float) -> float:
    return arguments.number("v", v, *_JOINT_SPEED)


def _line_speed(v: float) -> float:
    return arguments.number("v", v, *_LINE_SPEED)


def _joint_acceleration(a: float, chosen: bool) -> float:
    if chosen:
        return _DEFAULT_JOINT_ACCELERATION
    return arguments.number("a", a, *_JOINT_ACCELERATION)


def _line_acceleration(a: float, chosen: bool) -> float:
    return _DEFAULT_LINE_ACCELERATION if chosen else arguments.number("a", a, *_LINE_ACCELERATION)
