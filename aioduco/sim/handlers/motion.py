"""Motions that are planned as a whole (manual 1.3.5)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.errors import Unreachable
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import mismatch
from aioduco.sim.handlers.paths import (
    DEFAULT_JOINT_ACCELERATION,
    PathSection,
    blend,
    near,
)
from aioduco.sim.planner.errors import PlanError
from aioduco.sim.planner.segments import arc_move, joint_move

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco._wire.rpc import Op
    from aioduco.sim.motion import Plan
    from aioduco.sim.planner.segments import Segment

    Vector = NDArray[np.float64]
    Matrix = NDArray[np.float64]


class MotionHandlers(PathSection):
    """movej, movej2, movej_pose, movej_pose2, movel, movec."""

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
            return self._to_joints(joints_list, *self._joint_pace(v, a, def_acc), r)

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
        """The same with speed and acceleration in percent; not in the manual."""

        def plan() -> Plan:
            return self._to_joints(joints_list, *self._percent(v, a, def_acc), r)

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
        """To a pose of the tool, all joints arriving together."""

        def plan() -> Plan:
            speed, acceleration = self._joint_pace(v, a, def_acc)
            return self._to_pose(p, q_near, tool, wobj, speed, acceleration, r)

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
        """The same with speed and acceleration in percent; not in the manual."""

        def plan() -> Plan:
            return self._to_pose(p, q_near, tool, wobj, *self._percent(v, a, def_acc), r)

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
        """To a pose of the tool, its tip going straight."""

        def plan() -> Plan:
            target, tip = self._target("p", p, tool, wobj)
            near(q_near)
            pace, radius, weave = self._line_pace(v, a, def_acc), blend(r), self._weave(wobj)
            return lambda start: self._line(start, target, pace, radius, tip, weave)

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
            near(q_near)
            if mode not in (0, 1, 2):
                raise mismatch(f"mode is {mode}, but must be 0, 1 or 2")
            pace, radius, weave = self._line_pace(v, a, def_acc), blend(r), self._weave(wobj)
            return lambda start: arc_move(
                self._arm, start, via, target, *pace, radius, mode=mode, tool=tip, weave=weave
            )

        return self._motion("movec", plan, op, block)

    # -- what they share -----------------------------------------------------------------------

    def _to_joints(self, target: Sequence[float], v: float, a: float, r: float) -> Plan:
        end = np.array(arguments.joints("joints_list", target))
        radius = blend(r)
        tip = self._frames.tool().matrix
        return lambda start: joint_move(self._arm, start, end, v, a, radius, tool=tip)

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
        reference, radius = near(q_near), blend(r)

        def inverse(start: Vector) -> Segment:
            try:
                end = self._arm.ikine(target, start if reference is None else reference)
            except Unreachable as exc:
                raise PlanError("unreachable", str(exc)) from exc
            return joint_move(self._arm, start, end, v, a, radius, tool=tip)

        return inverse

    def _percent(self, v: float, a: float, def_acc: bool) -> tuple[float, float]:
        """Percent of the slowest joint's speed, and of the acceleration the controller chooses."""
        speed = arguments.positive("v", v, 100.0, "%") / 100.0 * min(self._arm.velocity)
        if def_acc:
            return speed, DEFAULT_JOINT_ACCELERATION
        return speed, arguments.positive("a", a, 100.0, "%") / 100.0 * DEFAULT_JOINT_ACCELERATION
