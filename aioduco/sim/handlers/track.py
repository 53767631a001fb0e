"""The track pool (manual 1.3.12)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco.models.pose import Pose
from aioduco.sim.following import Following
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import Section, mismatch
from aioduco.sim.planner.track import JointTrack, ToolTrack
from aioduco.sim.triggers import at_point

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Any

    import numpy as np
    from numpy.typing import NDArray

    from aioduco._wire.rpc import PointOp
    from aioduco.sim.controller import Controller
    from aioduco.sim.planner.follower import Follower

    Vector = NDArray[np.float64]

_JOINT_SPEED = (math.radians(0.01), 1.25 * math.pi, "rad/s")
_JOINT_ACCELERATION = (math.radians(0.01), 12.5 * math.pi, "rad/s²")
_LINE_SPEED = (1e-5, 5.0, "m/s")
_LINE_ACCELERATION = (1e-5, math.inf, "m/s²")
_STEEPEST = 1e4  # stands for an acceleration without a limit [m/s²]


class TrackHandlers(Section):
    """trackEnqueue to trackCartMotion."""

    def trackEnqueue(self, track: Sequence[Sequence[float]], block: bool) -> int:  # noqa: N802
        """轨迹点入池."""
        return self._put("trackEnqueue", block, lambda: [(_point(p), None) for p in track])

    def trackEnqueueOp(self, track: Sequence[PointOp], block: bool) -> int:  # noqa: N802
        """The same, each with what is triggered there."""

        def points() -> list[tuple[tuple[float, ...], Any]]:
            return [(_point(p.pos), at_point(p.op, self._signals)) for p in track]

        return self._put("trackEnqueueOp", block, points)

    def trackClearQueue(self) -> int:  # noqa: N802 - the name on the wire
        """清空轨迹池; an arm that follows it slows down."""

        def command(controller: Controller) -> int:
            controller.pool.clear()
            return controller.finish("trackClearQueue")

        return self._task("trackClearQueue", True, command)

    def getQueueSize(self) -> int:  # noqa: N802 - the name on the wire
        """轨迹池未被提取的点位数量."""
        with self._runtime.command() as controller:
            return len(controller.pool)

    def trackJointMotion(self, speed: float, acc: float, block: bool) -> int:  # noqa: N802
        """Through the points as joints, until there are none."""

        def following(controller: Controller) -> Following:
            v = arguments.number("speed", speed, *_JOINT_SPEED)
            a = arguments.number("acc", acc, *_JOINT_ACCELERATION)

            def make(q: Vector) -> Follower:
                return JointTrack(
                    self._arm, q, self._runtime.cycle, controller.pool, v, a, _reached
                )

            return Following.behind("trackJointMotion", make)

        return self._follow("trackJointMotion", following, block)

    def trackCartMotion(  # noqa: N802 - the name on the wire
        self, speed: float, acc: float, block: bool, tool: str, wobj: str, radius: float
    ) -> int:
        """Through the points as poses of the tool in the work object, until there are none."""

        def following(controller: Controller) -> Following:
            v = arguments.number("speed", speed, *_LINE_SPEED)
            a = min(arguments.number("acc", acc, *_LINE_ACCELERATION), _STEEPEST)
            arguments.number("radius", radius, 0.0, math.inf, "m")
            used, base = arguments.tool(self._frames, tool), arguments.wobj(self._frames, wobj)

            def make(q: Vector) -> Follower:
                return ToolTrack(
                    self._arm,
                    q,
                    self._runtime.cycle,
                    controller.pool,
                    v,
                    a,
                    _reached,
                    tool=used.matrix,
                    wobj=base.matrix,
                    matrix=lambda values: Pose(*values).matrix,
                )

            return Following.behind("trackCartMotion", make)

        return self._follow("trackCartMotion", following, block)

    def _follow(self, name: str, following: Callable[[Controller], Following], block: bool) -> int:
        return self._task(name, block, lambda c: c.follow(name, following(c)))

    def _put(
        self, name: str, block: bool, points: Callable[[], list[tuple[tuple[float, ...], Any]]]
    ) -> int:
        def command(controller: Controller) -> int:
            if not controller.pool.put(points()):
                raise PoolFull
            return controller.finish(name)

        try:
            return self._task(name, block, command)
        except PoolFull:
            return -1


class PoolFull(Exception):
    """The points do not fit; none of them was taken."""


def _point(values: Sequence[float]) -> tuple[float, ...]:
    point = arguments.numbers("a point", values, 6)
    # What a point is, joints or a pose, the motion decides; angles of both have this range.
    if any(abs(value) > 2 * math.pi for value in point):
        raise mismatch(f"a point is {list(point)}, but its numbers must be from -2π to 2π")
    return point


def _reached(fire: Callable[[], None]) -> None:
    fire()
