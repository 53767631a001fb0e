"""Replay of a recorded track (轨迹复现, manual 1.3.5): one follower after the other."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from aioduco.sim.planner.follower import Follower

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.follower import FollowError
    from aioduco.sim.planner.mover import SetPoint

__all__ = ["Chain"]


class Chain(Follower):
    """Followers of which each begins where the one before it has come to rest.

    Args:
        arm: the arm.
        q: joints at the start [rad]. Shape (6,).
        cycle: time between two ticks [s].
        parts: makes each follower for the joints [rad] at which the arm stands.
    """

    failure: FollowError | None

    def __init__(
        self, arm: Arm, q: Array, cycle: float, parts: Sequence[Callable[[Array], Follower]]
    ) -> None:
        super().__init__(arm, q, cycle)
        self._parts = deque(parts)
        self._part = self._parts.popleft()(q)

    def set_speed(self, fraction: float) -> None:
        """Set the global speed, for all parts."""
        super().set_speed(fraction)
        self._part.set_speed(fraction)

    @property
    def moving(self) -> bool:
        """Whether the set-point moves, or may move in the next cycle."""
        return not self._ended and self._part.moving

    def pause(self) -> None:
        """Slow down along the way, and stand until `resume`."""
        self._part.pause()

    def resume(self) -> None:
        """Go on after a pause."""
        self._part.resume()

    def stop(self) -> None:
        """Slow down, and end: no further part begins."""
        self._parts.clear()
        self._part.stop()

    def tick(self, q: Array, qd: Array) -> SetPoint:
        """Go on by one cycle."""
        if self._ended:
            return self._setpoint
        self._setpoint = self._next(q, qd)
        if self.failure is not None or not self._part.ended:
            return self._setpoint
        if not self._parts:
            self._end()
            return self._setpoint
        self._part = self._parts.popleft()(self._setpoint.q)
        self._part.set_speed(self._speed)
        return self._setpoint

    def _next(self, q: Array, qd: Array) -> SetPoint:
        point = self._part.tick(q, qd)
        self.failure = self._part.failure
        return point
