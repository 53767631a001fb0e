"""Lines by an offset from where the motion before ends (manual 1.3.5)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import mismatch
from aioduco.sim.handlers.paths import PathSection, blend
from aioduco.sim.planner.segments import line_move

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from aioduco._wire.rpc import Op
    from aioduco.sim.controller import Controller
    from aioduco.sim.frames import Tool
    from aioduco.sim.motion import Plan
    from aioduco.sim.planner.segments import Segment

    Vector = NDArray[np.float64]
    Matrix = NDArray[np.float64]


class OffsetHandlers(PathSection):
    """tcp_move, tcp_move_2p, wobj_move, wobj_move_2p, set_blend_ahead."""

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
        """By an offset in the tool's frame."""

        def plan() -> Plan:
            used = arguments.tool(self._frames, tool)
            step = arguments.pose("pose_offset", pose_offset).matrix
            return self._by(lambda tip: tip @ step, used, v, a, r, def_acc)

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
        """By the way from one pose to another, in the tool's frame: tip · p1⁻¹ · p2."""

        def plan() -> Plan:
            used = arguments.tool(self._frames, tool)
            arguments.wobj(self._frames, wobj)  # it cancels out, but must exist
            first, second = arguments.pose("p1", p1), arguments.pose("p2", p2)
            step = first.inverse().matrix @ second.matrix
            return self._by(lambda tip: tip @ step, used, v, a, r, def_acc, wobj)

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
        """By an offset along and about the axes of the work object."""

        def plan() -> Plan:
            step = arguments.pose("pose_offset", pose_offset).matrix
            axes = arguments.wobj(self._frames, wobj).matrix[:3, :3]
            used = self._frames.tool()
            return self._by(lambda tip: _along(tip, axes, step), used, v, a, r, def_acc, wobj)

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
        """By the way from one pose to another, along and about the axes of the work object."""

        def plan() -> Plan:
            used = arguments.tool(self._frames, tool)
            axes = arguments.wobj(self._frames, wobj).matrix[:3, :3]
            first, second = arguments.pose("p1", p1).matrix, arguments.pose("p2", p2).matrix
            step = np.eye(4)
            step[:3, 3] = second[:3, 3] - first[:3, 3]
            step[:3, :3] = second[:3, :3] @ first[:3, :3].T
            return self._by(lambda tip: _along(tip, axes, step), used, v, a, r, def_acc, wobj)

        return self._motion("wobj_move_2p", plan, op, block)

    def set_blend_ahead(self, per: int, num: int) -> int:
        """How far programs read motions ahead; those that clients send are known as they come."""

        def command(controller: Controller) -> int:
            if not 0 <= per <= 100:
                raise mismatch(f"per is {per}, but must be from 0 to 100 %")
            # A client may leave it out, which is 0 on the wire and means 1.
            if not 0 <= num <= 3:
                raise mismatch(f"num is {num}, but must be from 1 to 3")
            controller.read_ahead = per, max(num, 1)
            return controller.finish("set_blend_ahead")

        return self._task("set_blend_ahead", True, command)

    def _by(
        self,
        moved: Callable[[Matrix], Matrix],
        tool: Tool,
        v: float,
        a: float,
        r: float,
        def_acc: bool,
        wobj: str = "",
    ) -> Plan:
        pace, radius, manner = self._line_pace(v, a, def_acc), blend(r), self._manner(wobj)

        def from_there(start: Vector) -> Segment:
            target = moved(self._arm.fkine(start) @ tool.matrix) @ tool.inverse
            return line_move(self._arm, start, target, *pace, radius, tool=tool.matrix, **manner)

        return from_there


def _along(tip: Matrix, axes: Matrix, step: Matrix) -> Matrix:
    """A tip moved and turned in place, along and about given axes."""
    moved = tip.copy()
    moved[:3, 3] += axes @ step[:3, 3]
    moved[:3, :3] = axes @ step[:3, :3] @ axes.T @ tip[:3, :3]
    return moved
