"""Directions that are rotated when they are sent, by the tool's present orientation."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

from aioduco.errors import ControllerError
from aioduco.streaming.shared.turning import composed, turned

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.connection import Connection
    from aioduco.streaming.shared.config import FrameRotation
    from aioduco.streaming.shared.space import Config

__all__ = ["Directions"]

_FRESH = 10_000_000  # ns for which a pose is used after it was read


class Directions:
    """Rotates velocities into the frame of the wire, by a pose that was read at most 10 ms ago.

    Args:
        connection: connection over which poses are read.
        turning: how directions are rotated; None: not at all.
        timeout: time-out of each call [s].
    """

    def __init__(
        self, connection: Connection, turning: FrameRotation | None, timeout: float
    ) -> None:
        self._connection = connection
        self._turning = turning
        self._timeout = timeout
        self._place: Config = ()
        self._read_at = 0

    def turned(self, twist: tuple[float, ...]) -> tuple[float, ...]:
        """A velocity, rotated into the frame of the wire [m/s, rad/s]."""
        if self._turning is None:
            return twist
        now = time.monotonic_ns()
        if not self._place or now - self._read_at > _FRESH:
            self._place, self._read_at = self.place(self._turning), now
        return turned(twist, self._place, back=self._turning.back)

    def place(self, turning: FrameRotation) -> Config:
        """Read the pose of one frame in the other.

        Raises:
            ControllerError: the controller gives no pose, or has no such frame.
        """
        poses: list[Sequence[float]] = []
        for name, *args in turning.reads:
            pose: Sequence[float] = self._connection.call(name, tuple(args), self._timeout)
            if len(pose) != 6 or not all(map(math.isfinite, pose)):
                asked = f"of {args} " if any(args) else ""
                raise ControllerError(
                    name, f"it answered {list(pose)}: the orientation {asked}is not known"
                )
            poses.append(pose)
        return composed(poses)
