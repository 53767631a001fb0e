"""The track pool, and tracks that are recorded and replayed (manual 1.3.12, 1.3.5, 1.3.7)."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

from aioduco.models.pose import Pose
from aioduco.sim.cabinet.project import RecordedTrack
from aioduco.sim.controller.motion_queue import Following
from aioduco.sim.controller.recorder import BY_POSITION, BY_TIME
from aioduco.sim.controller.triggers import point_trigger
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import HandlerSection, task
from aioduco.sim.handlers.paths import (
    DEFAULT_JOINT_ACCELERATION,
    DEFAULT_LINE_ACCELERATION,
    JOINT_SPEED,
)
from aioduco.sim.planner.follower import FollowerChain, TargetFollower
from aioduco.sim.planner.track_pool import JointTrack, ToolTrack, TrackPool
from aioduco.sim.refusal import illegal, mismatch

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco._wire.rpc import PointOp
    from aioduco.models.rotation import Array
    from aioduco.sim.controller.state_machine import Controller

    _Part = Callable[[Array], TargetFollower]

_JOINT_ACCELERATION = (math.radians(0.01), 12.5 * math.pi, "rad/s²")
_LINE_SPEED = (1e-5, 5.0, "m/s")
_LINE_ACCELERATION = (1e-5, math.inf, "m/s²")
_UNLIMITED_ACCELERATION = 1e4  # stands for an acceleration without a limit [m/s²]
#: the manual's defaults for an interval that is left out: degrees, seconds
_INTERVALS = {BY_POSITION: 5.0, BY_TIME: 0.25}
_LONGEST_NAME = 255  # bytes
_REPLAY_SPEED = 1.0  # speed of the tool at 100 % of the set speed: an assumption [m/s]


class TrackHandlers(HandlerSection):
    """trackEnqueue to trackCartMotion, start_record_track, stop_record_track, replay."""

    def trackEnqueue(self, track: Sequence[Sequence[float]], block: bool) -> int:  # noqa: N802
        """轨迹点入池."""

        def put(controller: Controller) -> bool:
            return controller.pool.put((_point(p), None) for p in track)

        return self._enqueue("trackEnqueue", block, put)

    def trackEnqueueOp(self, track: Sequence[PointOp], block: bool) -> int:  # noqa: N802
        """The same as trackEnqueue, with triggers at the points."""

        def put(controller: Controller) -> bool:
            return controller.pool.put(
                (_point(p.pos), point_trigger(p.op, self._signals, self._forgiving)) for p in track
            )

        return self._enqueue("trackEnqueueOp", block, put)

    def trackClearQueue(self) -> int:  # noqa: N802 - the name on the wire
        """清空轨迹池; an arm that follows the pool slows down."""

        return self._task("trackClearQueue", True, lambda c: c.pool.clear())

    def getQueueSize(self) -> int:  # noqa: N802 - the name on the wire
        """轨迹池未被提取的点位数量."""
        with self._runtime.command() as controller:
            return len(controller.pool)

    def trackJointMotion(self, speed: float, acc: float, block: bool) -> int:  # noqa: N802
        """Move through the points as joints, until the pool is empty."""

        def track(controller: Controller) -> _Part:
            v = arguments.number("speed", speed, *JOINT_SPEED)
            a = arguments.number("acc", acc, *_JOINT_ACCELERATION)
            return self._joints(controller.pool, v, a)

        return self._follow("trackJointMotion", track, block)

    def trackCartMotion(  # noqa: N802 - the name on the wire
        self, speed: float, acc: float, block: bool, tool: str, wobj: str, radius: float
    ) -> int:
        """Move through the points as poses of the tool in the work object, until none is left."""

        def track(controller: Controller) -> _Part:
            v = arguments.number("speed", speed, *_LINE_SPEED)
            a = min(arguments.number("acc", acc, *_LINE_ACCELERATION), _UNLIMITED_ACCELERATION)
            arguments.number("radius", radius, 0.0, math.inf, "m")
            return self._poses(controller.pool, v, a, tool, wobj)

        return self._follow("trackCartMotion", track, block)

    def _follow(self, name: str, track: Callable[[Controller], _Part], block: bool) -> int:
        return self._task(name, block, lambda c: c.follow(name, Following.behind(name, track(c))))

    @task(block=False)
    def start_record_track(
        self, controller: Controller, name: str, mode: int, tool: str, wobj: str, interval: float
    ) -> None:
        """轨迹记录. Returns the id of a task that is done once the recording has begun."""
        arguments.choice("mode", mode, _INTERVALS, "0 or 1")
        arguments.name_of("name", name, _LONGEST_NAME)
        if "/" in name or "\\" in name or name in (".", ".."):
            raise mismatch(f"name is {name!r}, which is no name of a file")
        step = interval or _INTERVALS[mode]
        arguments.positive("interval", step, 1e9, "degrees" if mode == BY_POSITION else "s")
        used, base = self._frames.tool(tool), self._frames.wobj(wobj)
        if controller.recorder.active:
            raise illegal("a track is being recorded")

        def pose(q: Array) -> tuple[float, ...]:
            return tuple(Pose.from_matrix(base.inverse @ self._arm.fkine(q) @ used.matrix))

        controller.recorder.start(
            RecordedTrack(used.name, base.name),
            mode,
            math.radians(step) if mode == BY_POSITION else step,
            pose,
            partial(self._cabinet.project.tracks.__setitem__, name),
        )

    def stop_record_track(self) -> int:
        """停止轨迹记录."""

        return self._task("stop_record_track", True, lambda c: c.recorder.stop())

    def replay(self, name: str, value: int, mode: int) -> int:
        """轨迹复现: move to the first point, then through all of them; `value` is the speed [%]."""

        def chain(_: Controller) -> _Part:
            share = arguments.number("value", value, 1, 100, "%") / 100.0
            arguments.choice("mode", mode, (0, 1), "0 or 1")
            track = self._cabinet.project.tracks.get(name)
            if track is None:
                raise mismatch(f"there is no track {name!r}")
            points = track.joints if mode == 0 else track.joints[:1]
            speed = share * min(self._arm.velocity)
            parts = [self._joints(_pool(points), speed, DEFAULT_JOINT_ACCELERATION)]
            if mode == 1:
                speed = share * _REPLAY_SPEED
                pool = _pool(track.poses)
                parts.append(
                    self._poses(pool, speed, DEFAULT_LINE_ACCELERATION, track.tool, track.wobj)
                )
            return lambda q: FollowerChain(self._arm, q, self._cycle, parts)

        return self._follow("replay", chain, True)

    def _joints(self, pool: TrackPool, v: float, a: float) -> _Part:
        return lambda q: JointTrack(self._arm, q, self._cycle, pool, v, a)

    def _poses(self, pool: TrackPool, v: float, a: float, tool: str, wobj: str) -> _Part:
        tip, base = self._frames.tool(tool).matrix, self._frames.wobj(wobj).matrix
        return lambda q: ToolTrack(self._arm, q, self._cycle, pool, v, a, tool=tip, wobj=base)


def _point(values: Sequence[float]) -> tuple[float, ...]:
    # The motion decides whether a point is joints or a pose; angles of both have this range.
    return arguments.six("a point", values, 2 * math.pi, "m or rad")


def _pool(points: Sequence[tuple[float, ...]]) -> TrackPool:
    """Put the points of a track into a pool; a track never has more points than fit."""
    pool = TrackPool()
    fits = pool.put((point, None) for point in points)
    assert fits
    return pool
