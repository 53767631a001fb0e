"""Followers make set-points cycle by cycle where no path is known in advance.

Servo targets, velocities, hand guiding, the realtime queue and the track pool have one thing in
common: the next target arrives while the arm moves. A follower computes one set-point per cycle
from the targets so far. It has no clock and no thread; each `tick` is one cycle.

The set-points of every follower keep these invariants: the arm brakes when the braking distance of
a joint reaches its limit; no joint is commanded faster than it can turn; and a stop decelerates
from the present speeds, whatever the target.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from typing import TYPE_CHECKING, ClassVar, Literal, TypeAlias

import numpy as np

from aioduco.models.bounds import least, most
from aioduco.sim.planner.motion_limits import STOPPING
from aioduco.sim.planner.path import JointSetPoint

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array


MAX_JUMP = 0.1
"""Largest change of a joint in one cycle that is still on the same branch [rad]."""

_FASTER = 1.02  # highest speed of a set-point as a share of the joint's largest, for rounding
Failure: TypeAlias = Literal["error", "fault"]


class FollowError(Exception):
    """There is no further set-point; the arm decelerates.

    Attributes:
        kind: "error": the task ends. "fault": it is a safety stop.
    """

    def __init__(self, message: str, kind: Failure = "error") -> None:
        super().__init__(message)
        self.kind: Failure = kind


class TargetFollower(ABC):
    """A motion whose targets arrive while it runs.

    Args:
        arm: the arm.
        q: joints at the start, where the arm stands [rad]. Shape (6,).
        cycle: time between two ticks [s].

    Attributes:
        failure: why it has failed; None if it has not.
    """

    #: kind of the failure if a joint cannot follow a set-point
    severity: ClassVar[Failure] = "error"
    #: whether it resumes from any speed; otherwise a pause goes on until it stands
    resumes_moving: ClassVar[bool] = True

    def __init__(self, arm: Arm, q: Array, cycle: float) -> None:
        self.failure: FollowError | None = None
        self._arm = arm
        self._cycle = cycle
        #: the latest set-point
        self.setpoint: JointSetPoint = JointSetPoint.at_rest(q)
        self._speed = 1.0
        #: what it does after slowing down; empty while it does not slow down
        self._after_stop: Literal["", "stand", "resume", "end"] = ""
        self._hard = np.array(arm.acceleration) * STOPPING
        self._fastest = np.array(arm.velocity) * _FASTER
        self._lower = np.array([least(bound) for bound in arm.lower])
        self._upper = np.array([most(bound) for bound in arm.upper])
        #: whether the motion stands and will not move again
        self.ended: bool = False

    @property
    def moving(self) -> bool:
        """Whether the set-point moves, or may move in the next cycle."""
        if self.ended:
            return False
        return self._after_stop != "stand" or bool(self.setpoint.qd.any())

    def set_speed(self, fraction: float) -> None:
        """Set the global speed, 0.01 to 1, which only some followers use."""
        self._speed = fraction

    def pause(self) -> None:
        """Decelerate and stand until `resume`."""
        if self._after_stop in ("", "resume"):
            self._after_stop = "stand"

    def resume(self) -> None:
        """Resume after a pause."""
        if self._after_stop != "stand":
            return
        if self.resumes_moving or not self.setpoint.qd.any():
            self._after_stop = ""
            self._resumed()
        else:
            self._after_stop = "resume"

    def stop(self) -> None:
        """Decelerate as fast as the drives can, and end."""
        self._after_stop = "end"

    def finish(self) -> None:
        """End in an orderly way: by a stop, unless the follower has a gentler way."""
        self.stop()

    def tick(self, q: Array, qd: Array) -> JointSetPoint:
        """Run one cycle.

        Args:
            q: actual joints [rad]. Shape (6,).
            qd: actual joint speeds [rad/s]. Shape (6,).
        """
        if self.ended:
            return self.setpoint
        if not self._after_stop:
            try:
                self.setpoint = self._checked(self._next(q, qd))
            except FollowError as exc:
                self._fail(exc)
        if self._after_stop:
            self._slow_down()
        return self.setpoint

    def _fail(self, why: FollowError) -> None:
        self.failure = why
        self._after_stop = "end"

    @abstractmethod
    def _next(self, q: Array, qd: Array) -> JointSetPoint:
        """Give the next set-point, towards the target.

        Raises:
            FollowError: there is none.
        """

    def _resumed(self) -> None:  # noqa: B027 - nothing to do for those who have no memory
        """Adapt to a pause, which has slowed the arm down since the last set-point."""

    def _end(self) -> None:
        self.ended = True
        self.setpoint = JointSetPoint.at_rest(self.setpoint.q)

    def _slow_down(self) -> None:
        """Decelerate all joints together, so that their motion keeps its direction."""
        self.setpoint = self.setpoint.slowed(self._hard, self._cycle)
        if self.setpoint.qd.any():
            return
        if self._after_stop == "end":
            self._end()
        elif self._after_stop == "resume":
            self._after_stop = ""
            self._resumed()

    def _checked(self, point: JointSetPoint) -> JointSetPoint:
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

    def _step(self, qd: Array) -> JointSetPoint:
        """Give the set-point after a cycle that ends with these joint speeds."""
        last = self.setpoint
        q = last.q + 0.5 * self._cycle * (last.qd + qd)
        return JointSetPoint(q, qd, (qd - last.qd) / self._cycle)


class StandingFollower(TargetFollower):
    """Commands the joints to their positions at the start, until it is stopped."""

    def _next(self, q: Array, qd: Array) -> JointSetPoint:  # noqa: ARG002 - it follows no sensors
        return self.setpoint


class FollowerChain(TargetFollower):
    """A sequence of followers: each begins where the one before it has come to rest.

    Args:
        arm: the arm.
        q: joints at the start [rad]. Shape (6,).
        cycle: time between two ticks [s].
        parts: makes each follower for the joints [rad] at which the arm stands.
    """

    failure: FollowError | None
    setpoint: JointSetPoint

    def __init__(
        self, arm: Arm, q: Array, cycle: float, parts: Sequence[Callable[[Array], TargetFollower]]
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
        return not self.ended and self._part.moving

    def pause(self) -> None:
        """Decelerate along the path, and stand until `resume`."""
        self._part.pause()

    def resume(self) -> None:
        """Resume after a pause."""
        self._part.resume()

    def stop(self) -> None:
        """Decelerate, and end: no further part begins."""
        self._parts.clear()
        self._part.stop()

    def tick(self, q: Array, qd: Array) -> JointSetPoint:
        """Run one cycle."""
        if self.ended:
            return self.setpoint
        self.setpoint = self._next(q, qd)
        if self.failure is not None or not self._part.ended:
            return self.setpoint
        if not self._parts:
            self._end()
            return self.setpoint
        self._part = self._parts.popleft()(self.setpoint.q)
        self._part.set_speed(self._speed)
        return self.setpoint

    def _next(self, q: Array, qd: Array) -> JointSetPoint:
        point = self._part.tick(q, qd)
        self.failure = self._part.failure
        return point
