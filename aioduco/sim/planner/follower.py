"""Followers: what makes set-points cycle by cycle, where no path is known beforehand.

Servo targets, velocities, hand guiding, the realtime queue and the track pool have one thing in
common: the next target comes while the arm moves. A follower turns what it knows into one
set-point per cycle. It has no clock and no thread; each `tick` is one cycle.

Whatever a follower does, its set-points keep these invariants: a joint whose way to its limit is
used up by braking brakes; no joint is told to turn faster than it can; and a stop decelerates
from the present speeds, whatever the target.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Literal, TypeAlias

import numpy as np

from aioduco.sim.planner.limits import STOPPING
from aioduco.sim.planner.mover import SetPoint

if TYPE_CHECKING:
    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array

__all__ = ["Failure", "FollowError", "Follower"]

_FASTER = 1.02  # share of a joint's largest speed that a set-point may have, for rounding

Failure: TypeAlias = Literal["error", "fault"]


class FollowError(Exception):
    """There is no further set-point; the arm slows down.

    Attributes:
        kind: "error": the task ends. "fault": it is a safety stop.
    """

    def __init__(self, message: str, kind: Failure = "error") -> None:
        super().__init__(message)
        self.kind: Failure = kind


class Follower(ABC):
    """One motion whose targets come while it runs.

    Args:
        arm: the arm.
        q: joints at the start, where the arm stands [rad]. Shape (6,).
        cycle: time between two ticks [s].

    Attributes:
        failure: why it ended before it was told to; None if it did not.
    """

    #: what a set-point is that a joint cannot follow
    severity: ClassVar[Failure] = "error"

    def __init__(self, arm: Arm, q: Array, cycle: float) -> None:
        self.failure: FollowError | None = None
        self._arm = arm
        self._cycle = cycle
        self._setpoint = SetPoint.at_rest(q)
        self._speed = 1.0
        self._then: Literal["", "stand", "end"] = ""  # what comes after slowing down
        self._hard = np.array(arm.acceleration) * STOPPING
        self._fastest = np.array(arm.velocity) * _FASTER
        self._lower, self._upper = np.array(arm.lower), np.array(arm.upper)
        self._ended = False

    @property
    def setpoint(self) -> SetPoint:
        """The latest set-point."""
        return self._setpoint

    @property
    def ended(self) -> bool:
        """Whether it stands and will not move again."""
        return self._ended

    @property
    def moving(self) -> bool:
        """Whether the set-point moves, or may move in the next cycle."""
        if self._ended:
            return False
        return self._then != "stand" or bool(self._setpoint.qd.any())

    def set_speed(self, fraction: float) -> None:
        """Set the global speed, 0.01 to 1, for those followers that heed it."""
        self._speed = fraction

    def pause(self) -> None:
        """Slow down and stand until `resume`."""
        if not self._then:
            self._then = "stand"

    def resume(self) -> None:
        """Go on after a pause."""
        if self._then == "stand":
            self._then = ""
            self._resumed()

    def stop(self) -> None:
        """Slow down as fast as the drives can, and end."""
        self._then = "end"

    def finish(self) -> None:
        """End in good order; by a stop unless there is a gentler way."""
        self.stop()

    def tick(self, q: Array, qd: Array) -> SetPoint:
        """Go on by one cycle.

        Args:
            q: actual joints [rad]. Shape (6,).
            qd: actual joint speeds [rad/s]. Shape (6,).
        """
        if self._ended:
            return self._setpoint
        if not self._then:
            try:
                self._setpoint = self._checked(self._next(q, qd))
            except FollowError as exc:
                self._fail(exc)
        if self._then:
            self._slow_down()
        return self._setpoint

    def _fail(self, why: FollowError) -> None:
        self.failure = why
        self._then = "end"

    @abstractmethod
    def _next(self, q: Array, qd: Array) -> SetPoint:
        """Give the next set-point, towards the target.

        Raises:
            FollowError: there is none.
        """

    def _resumed(self) -> None:  # noqa: B027 - nothing to do for those who have no memory
        """Take note that the arm was slowed down since the last set-point."""

    def _end(self) -> None:
        self._ended = True
        self._setpoint = SetPoint.at_rest(self._setpoint.q)

    def _slow_down(self) -> None:
        """Slow all joints down together, so that their way keeps its direction."""
        last = self._setpoint
        left = float((np.abs(last.qd) / self._hard).max())
        if left <= self._cycle:
            self._setpoint = SetPoint.at_rest(last.q + 0.5 * left * last.qd)
            if self._then == "end":
                self._end()
            return
        qd = last.qd * (1.0 - self._cycle / left)
        q = last.q + 0.5 * self._cycle * (last.qd + qd)
        self._setpoint = SetPoint(q, qd, -last.qd / left)

    def _checked(self, point: SetPoint) -> SetPoint:
        """Refuse a set-point that a joint cannot follow, or from which it cannot stop in time."""
        speeds = np.abs(point.qd)
        if (speeds > self._fastest).any():
            joint = int((speeds / self._fastest).argmax())
            raise FollowError(
                f"joint {joint + 1} would have to turn at {speeds[joint]:.3f} rad/s, "
                f"faster than {self._arm.velocity[joint]:.3f} rad/s",
                self.severity,
            )
        rest = point.q + 0.5 * point.qd * speeds / self._hard
        beyond = np.maximum(rest - self._upper, self._lower - rest)
        joint = int(beyond.argmax())
        if beyond[joint] > 0.0 and speeds[joint] > 0.0:
            raise FollowError(f"joint {joint + 1} comes to its limit", self.severity)
        return point

    def _step(self, qd: Array) -> SetPoint:
        """Give the set-point after a cycle that ends with these joint speeds."""
        last = self._setpoint
        q = last.q + 0.5 * self._cycle * (last.qd + qd)
        return SetPoint(q, qd, (qd - last.qd) / self._cycle)
