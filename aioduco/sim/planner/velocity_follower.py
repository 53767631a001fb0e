"""Followers of a velocity: of each joint, or of the tool (manual 1.3.5, speedj, speedl, move_jog).

A velocity is ramped up and down at an acceleration, and lasts until a time is over or until the
motion is ended.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from aioduco.kinematics.forward import fkine, jacobian
from aioduco.sim.planner.follower import FollowError, TargetFollower
from aioduco.sim.planner.path import JointSetPoint

if TYPE_CHECKING:
    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array


_SINGULAR = 2e-3  # singularity measure below which a tool cannot be moved at a velocity
_LEAST = 1e-12  # change of a joint's speed that counts [rad/s]


class _Velocity(TargetFollower):
    """Common part of joint and tool velocities: six numbers that are ramped up and down."""

    def __init__(self, arm: Arm, q: Array, cycle: float) -> None:
        super().__init__(arm, q, cycle)
        self._goal = np.zeros(6)
        self._present = np.zeros(6)
        self._acceleration = 0.0
        self._left = math.inf  # time until it ends [s]
        self._ending = False
        self._most = cycle * np.array(arm.acceleration)  # change of speed in a cycle [rad/s]

    def aim(self, velocity: Array, acceleration: float, time: float = math.inf) -> None:
        """Set another velocity.

        Args:
            velocity: six numbers.
            acceleration: change per second of the joint that changes most, or of the tool.
            time: time after which the motion ends [s].
        """
        self._goal, self._acceleration, self._left = velocity, acceleration, time
        self._ending = False

    def finish(self) -> None:
        """Decelerate to rest at the given acceleration, and end."""
        self._ending = True
        if self._after_stop in ("stand", "resume"):
            self._after_stop = "end"

    def _ramp(self) -> Array:
        if self._left < 0.5 * self._cycle:
            self._ending = True
        self._left -= self._cycle
        change = (0.0 if self._ending else self._speed) * self._goal - self._present
        most, step = self._size(change), self._acceleration * self._cycle
        self._present = self._present + change * (min(1.0, step / most) if most > 0.0 else 1.0)
        return self._present

    @staticmethod
    def _size(change: Array) -> float:
        return float(np.abs(change).max())

    def _possible(self, change: Array, kept: Array) -> float:
        """Share of a change of joint speeds [rad/s] that the drives can do in a cycle.

        All of it if they cannot even do the speeds that are kept: it may be what slows down.
        """
        room = self._most - np.sign(change) * (kept - self.setpoint.qd)
        share = float((room / np.maximum(np.abs(change), _LEAST)).min())
        return min(share, 1.0) if share >= 0.0 else 1.0

    def _stands(self) -> bool:
        """End if it is to end, and the velocity has come to zero; return whether it has ended."""
        if self._ending and not self._present.any():
            self._end()
        return self.ended


class JointVelocity(_Velocity):
    """Turns each joint at a velocity [rad/s], ramped at an acceleration [rad/s²]."""

    def _resumed(self) -> None:
        self._present = self.setpoint.qd

    def _next(self, q: Array, qd: Array) -> JointSetPoint:  # noqa: ARG002 - it follows no sensors
        before = self._present
        change = self._ramp() - before
        self._present = before + self._possible(change, before) * change
        point = self._step(self._present)
        return JointSetPoint.at_rest(point.q) if self._stands() else point


class ToolVelocity(_Velocity):
    """Moves the tool at a velocity, linear [m/s] before angular [rad/s].

    Args:
        arm: the arm.
        q: joints at the start [rad]. Shape (6,).
        cycle: time between two ticks [s].
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        frame: orientation in the base of the axes of the velocity. Shape (3, 3). None for the
            tool's axes, which turn with it.
    """

    resumes_moving = False

    def __init__(
        self, arm: Arm, q: Array, cycle: float, tool: Array, frame: Array | None = None
    ) -> None:
        super().__init__(arm, q, cycle)
        self.tool = tool
        self.frame = frame

    @staticmethod
    def _size(change: Array) -> float:
        # Linear [m/s²] and angular [rad/s²] accelerations count one to one.
        return float(max(np.linalg.norm(change[:3]), np.linalg.norm(change[3:])))

    def _resumed(self) -> None:
        self._present = np.zeros(6)

    def _next(self, q: Array, qd: Array) -> JointSetPoint:  # noqa: ARG002 - it follows no sensors
        before, velocity = self._present, self._ramp()
        # The mean of the speeds at both ends of the step would need the end. The speed half a step
        # ahead is as exact.
        half = self.setpoint.q + 0.5 * self._cycle * self.setpoint.qd
        here = joint_speeds(self._arm, half, self._rotated(half, velocity), self.tool)
        last = self.setpoint
        if (np.abs(here - last.qd) > self._most).any():
            kept = joint_speeds(self._arm, half, self._rotated(half, before), self.tool)
            share = self._possible(here - kept, kept)
            self._present = before + share * (velocity - before)
            here = kept + share * (here - kept)
        if self._stands():
            return self.setpoint
        point = self._step(here)
        point.q[:] = last.q + self._cycle * here
        return point

    def _rotated(self, q: Array, velocity: Array) -> Array:
        rotation = self.frame
        if rotation is None:
            rotation = (fkine(self._arm.geometry, q) @ self.tool)[:3, :3]
        return np.concatenate([rotation @ velocity[:3], rotation @ velocity[3:]])


def joint_speeds(arm: Arm, q: Array, twist: Array, tool: Array) -> Array:
    """Give the joint speeds [rad/s] that move a tool at a velocity.

    Args:
        arm: the arm.
        q: joints [rad]. Shape (6,).
        twist: of the tool centre point in the base frame [m/s, rad/s]. Shape (6,).
        tool: tool centre point in the frame of the flange. Shape (4, 4).

    Raises:
        FollowError: the arm is at a singularity.
    """
    if not twist.any():
        return np.zeros(6)
    singularity = arm.singularity(q)
    if min(singularity) < _SINGULAR:
        raise FollowError(f"the {singularity.nearest} is at a singularity")
    flange = fkine(arm.geometry, q)
    # The flange moves with the tool, and turns about it.
    lever = flange[:3, :3] @ tool[:3, 3]
    at_flange = twist.copy()
    at_flange[:3] -= np.cross(twist[3:], lever)
    speeds: Array = np.linalg.solve(jacobian(arm.geometry, q), at_flange).astype(np.float64)
    return speeds
