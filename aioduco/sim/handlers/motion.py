"""Motions that are planned as a whole (manual 1.3.5)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.paths import (
    DEFAULT_JOINT_ACCELERATION,
    PathSection,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import Op
    from aioduco.sim.motion import Plan


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
        """The same with speed and acceleration in percent; not in the manual."""

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
        """To a pose of the tool, all joints arriving together."""

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
        """The same with speed and acceleration in percent; not in the manual."""

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
        """To a pose of the tool, its tip going straight."""

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
        """Along an arc through p1 to p2."""

        def plan() -> Plan:
            pace = self._line_pace(v, a, def_acc)
            return self._to_arc(p1, p2, mode, q_near, tool, wobj, pace, r)

        return self._motion("movec", plan, op, block)

    # -- what they share -----------------------------------------------------------------------

    def _percent(self, v: float, a: float, def_acc: bool) -> tuple[float, float]:
        """Percent of the slowest joint's speed, and of the acceleration the controller chooses."""
        speed = arguments.positive("v", v, 100.0, "%") / 100.0 * min(self._arm.velocity)
        if def_acc:
            return speed, DEFAULT_JOINT_ACCELERATION
        return speed, arguments.positive("a", a, 100.0, "%") / 100.0 * DEFAULT_JOINT_ACCELERATION
