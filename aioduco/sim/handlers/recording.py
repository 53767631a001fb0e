"""Tracks that are recorded and replayed (manual 1.3.5 and 1.3.7)."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

from aioduco.models.enums import TaskState
from aioduco.models.pose import Pose
from aioduco.sim.following import Following
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import Section, mismatch
from aioduco.sim.handlers.paths import DEFAULT_JOINT_ACCELERATION, DEFAULT_LINE_ACCELERATION
from aioduco.sim.planner.fifo import Pool
from aioduco.sim.planner.replaying import Chain
from aioduco.sim.planner.track import JointTrack, ToolTrack
from aioduco.sim.recording import BY_POSITION, BY_TIME, Track
from aioduco.sim.refusal import Rejected

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from aioduco.sim.controller import Controller
    from aioduco.sim.planner.follower import Follower

    Vector = NDArray[np.float64]
    _Part = Callable[[Vector], Follower]

#: what the manual gives for an interval that is left out: degrees, seconds
_INTERVALS = {BY_POSITION: 5.0, BY_TIME: 0.25}
_LONGEST_NAME = 255  # bytes
_LINE_SPEED = 1.0  # what 100 % of the set speed are for the tool: an assumption [m/s]


class RecordingHandlers(Section):
    """start_record_track, stop_record_track, replay."""

    def start_record_track(
        self, name: str, mode: int, tool: str, wobj: str, interval: float
    ) -> int:
        """轨迹记录. The id of a task, which is done once the recording has begun."""

        def command(controller: Controller) -> int:
            if mode not in _INTERVALS:
                raise mismatch(f"mode is {mode}, but must be 0 or 1")
            arguments.name_of("name", name, _LONGEST_NAME)
            if "/" in name or "\\" in name or name in (".", ".."):
                raise mismatch(f"name is {name!r}, which is no name of a file")
            step = interval or _INTERVALS[mode]
            arguments.positive("interval", step, 1e9, "degrees" if mode == BY_POSITION else "s")
            used, base = arguments.tool(self._frames, tool), arguments.wobj(self._frames, wobj)
            if controller.recorder.active:
                raise Rejected(TaskState.ILLEGAL, "a track is being recorded")

            def pose(q: Vector) -> tuple[float, ...]:
                return tuple(Pose.from_matrix(base.inverse @ self._arm.fkine(q) @ used.matrix))

            controller.recorder.start(
                Track(used.name, base.name),
                mode,
                math.radians(step) if mode == BY_POSITION else step,
                pose,
                partial(self._cabinet.project.tracks.__setitem__, name),
            )
            return controller.finish("start_record_track")

        return self._task("start_record_track", False, command)

    def stop_record_track(self) -> int:
        """停止轨迹记录."""

        def command(controller: Controller) -> int:
            controller.recorder.stop()
            return controller.finish("stop_record_track")

        return self._task("stop_record_track", True, command)

    def replay(self, name: str, value: int, mode: int) -> int:
        """轨迹复现: to the first point, then through all of them; `value` is the speed [%]."""

        def command(controller: Controller) -> int:
            share = arguments.number("value", value, 1, 100, "%") / 100.0
            if mode not in (0, 1):
                raise mismatch(f"mode is {mode}, but must be 0 or 1")
            track = self._cabinet.project.tracks.get(name)
            if track is None:
                raise mismatch(f"there is no track {name!r}")
            speed = share * min(self._arm.velocity)
            if mode == 0:
                parts = [self._joints(track.joints, speed)]
            else:
                parts = [self._joints(track.joints[:1], speed), self._poses(track, share)]
            cycle = self._runtime.cycle
            return controller.follow(
                "replay",
                Following.behind("replay", lambda q: Chain(self._arm, q, cycle, parts)),
            )

        return self._task("replay", True, command)

    def _joints(self, points: Sequence[tuple[float, ...]], speed: float) -> _Part:
        pool = _pool(points)
        return lambda q: JointTrack(
            self._arm, q, self._runtime.cycle, pool, speed, DEFAULT_JOINT_ACCELERATION, _passed
        )

    def _poses(self, track: Track, share: float) -> _Part:
        pool = _pool(track.poses)
        tool = arguments.tool(self._frames, track.tool)
        wobj = arguments.wobj(self._frames, track.wobj)
        return lambda q: ToolTrack(
            self._arm,
            q,
            self._runtime.cycle,
            pool,
            share * _LINE_SPEED,
            DEFAULT_LINE_ACCELERATION,
            _passed,
            tool=tool.matrix,
            wobj=wobj.matrix,
            matrix=lambda values: Pose(*values).matrix,
        )


def _pool(points: Sequence[tuple[float, ...]]) -> Pool:
    """The points of a track, which are no more than fit."""
    pool = Pool()
    fits = pool.put((point, None) for point in points)
    assert fits
    return pool


def _passed(_event: object) -> None:
    """Nothing is triggered at a recorded point."""
