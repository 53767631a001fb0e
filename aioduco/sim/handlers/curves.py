"""Circles, spirals and splines (manual 1.3.5)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import mismatch
from aioduco.sim.handlers.paths import PathSection, blend, near
from aioduco.sim.planner.segments import spiral_move, spline_move
from aioduco.sim.triggers import at_point

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from aioduco._wire.rpc import Op, PointOp
    from aioduco.sim.motion import Plan

    Matrix = NDArray[np.float64]

_MOST_POINTS = 50
_FINE_SPEED = (1e-5, 5.0, "m/s")
_FINE_ACCELERATION = (1e-5, math.inf, "m/s²")
_BY_PARAMETERS, _BY_END = 0, 1


class CurveHandlers(PathSection):
    """move_circle, move_spiral, spline, spline_op."""

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
        """Once round the circle through p1 and p2."""

        def plan() -> Plan:
            pace = self._line_pace(v, a, def_acc)
            return self._round(p1, p2, mode, q_near, tool, wobj, pace, r)

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
        """Along a spiral about the z axis of p1, to a radius and a height or to p2."""

        def plan() -> Plan:
            if mode not in (_BY_PARAMETERS, _BY_END):
                raise mismatch(f"mode is {mode}, but must be 0 or 1")
            base = arguments.wobj(self._frames, wobj)
            centre = base.matrix @ arguments.pose("p1", p1).matrix
            tip = arguments.tool(self._frames, tool).matrix
            target = self._target("p2", p2, tool, wobj)[0] if mode == _BY_END else None
            near(q_near)
            turns = arguments.number("rev", rev, -1000.0, 1000.0, "turns")
            axial = arguments.number("len", len, -10.0, 10.0, "m") if target is None else 0.0
            end = arguments.number("r", r, 0.0, 10.0, "m") if target is None else 0.0
            pace, manner = self._line_pace(v, a, def_acc), self._manner(wobj)
            return lambda start: spiral_move(
                self._arm,
                start,
                centre,
                turns,
                *pace,
                axial=axial,
                radius=end,
                target=target,
                tool=tip,
                **manner,
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
        """Along a smooth curve through up to 50 poses."""

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
        """The same, with what is triggered at each pose."""
        fires: list[tuple[Matrix, Callable[[], None]]] = []

        def plan() -> Plan:
            poses = [point.pos for point in pose_list]
            for point in pose_list:
                fire = at_point(point.op, self._signals)
                if fire is not None:
                    place, _ = self._target("pose_list", point.pos, tool, wobj)
                    fires.append((place[:3, 3], fire))
            # The manual gives this function smaller least values than the other one.
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
        tip = arguments.tool(self._frames, tool).matrix
        targets = [self._target("pose_list", p, tool, wobj)[0] for p in poses]
        radius, manner = blend(r), self._manner(wobj)
        return lambda start: spline_move(
            self._arm, start, targets, *pace, radius, tool=tip, **manner
        )
