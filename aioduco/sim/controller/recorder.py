"""Tracks that are recorded while the arm moves (轨迹记录, manual 1.3.7): a pure state machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.models.rotation import Array
    from aioduco.sim.cabinet.project import RecordedTrack


BY_POSITION, BY_TIME = 0, 1


@dataclass(slots=True, eq=False)
class _Recording:
    track: RecordedTrack
    mode: int
    interval: float
    pose: Callable[[Array], tuple[float, ...]]
    on_finished: Callable[[RecordedTrack], None]
    last: Array | None = None
    due: float = 0.0


class Recorder:
    """Records at most one track at a time.

    Attributes:
        active: whether a track is being recorded.
    """

    def __init__(self) -> None:
        self._recording: _Recording | None = None
        self.active: bool = False

    def start(
        self,
        track: RecordedTrack,
        mode: int,
        interval: float,
        pose: Callable[[Array], tuple[float, ...]],
        on_finished: Callable[[RecordedTrack], None],
    ) -> None:
        """Record from the next cycle on. No other recording may be active.

        Args:
            track: track to fill.
            mode: BY_POSITION or BY_TIME.
            interval: interval of the points: sum of the joints' movements [rad], or time [s].
            pose: gives the pose that is recorded for joints [rad].
            on_finished: called with the track when its recording ends.
        """
        assert self._recording is None
        self._recording = _Recording(track, mode, interval, pose, on_finished)
        self.active = True

    def stop(self) -> None:
        """End the recording, if there is one."""
        recording, self._recording = self._recording, None
        self.active = False
        if recording is not None:
            recording.on_finished(recording.track)

    def tick(self, time: float, q: Array) -> bool:
        """Record a point if one is due.

        Args:
            time: simulated time [s].
            q: actual joints [rad]. Shape (6,).

        Returns:
            Whether the recording has ended because the track is full.
        """
        now = self._recording
        if now is None:
            return False
        if now.last is None:
            now.due = time
        elif now.mode == BY_POSITION and float(np.abs(q - now.last).sum()) < now.interval:
            return False
        # A tolerance of a nanosecond for the rounding of a sum of cycles.
        if now.mode == BY_TIME and time < now.due - 1e-9:
            return False
        now.last = q
        # One tick may stand for many idle cycles: missed points are not made up for.
        now.due = max(now.due, time - now.interval) + now.interval
        now.track.joints.append(tuple(q.tolist()))
        now.track.poses.append(now.pose(q))
        if not now.track.full:
            return False
        self.stop()
        return True
