"""The realtime queue and its follower (实时控制, manual 1.3.15): one point per cycle.

The manual says that the first point must be where the arm is, that commands pass a filter with a
bandwidth, and that missing data are monitored. These are assumptions: how far the first point may
be off, how many points fit into the queue, that the filter is a first-order low-pass, and that the
arm continues with the last point while data are missing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import numpy as np

from aioduco.errors import Unreachable
from aioduco.kinematics.forward import fkine
from aioduco.models.realtime import RealtimeMode
from aioduco.models.rotation import Array, matrix_from_rotvec, rotvec_from_matrix
from aioduco.sim.planner.follower import MAX_JUMP, Failure, FollowError, TargetFollower
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.planner.track_pool import Fifo
from aioduco.sim.planner.velocity_follower import joint_speeds

if TYPE_CHECKING:
    from aioduco.kinematics import Arm


#: how far the first point may be from the arm
_NEAR_JOINTS, _NEAR_POINT, _NEAR_ANGLE = 2e-3, 1e-3, 2e-3  # [rad, m, rad]
_SLOW_JOINTS, _SLOW_POINT, _SLOW_ANGLE = 0.05, 0.05, 0.05  # [rad/s, m/s, rad/s]


class Follow(IntEnum):
    """The quantity of a point that is followed."""

    JOINTS = RealtimeMode.JOINT_POSITION
    JOINT_SPEEDS = RealtimeMode.JOINT_VELOCITY
    POSE = RealtimeMode.POSE
    TWIST = RealtimeMode.TWIST


@dataclass(frozen=True, slots=True)
class RealtimeCommand:
    """One point; an empty field was not given.

    Attributes:
        joints: joints [rad], six or none.
        joint_speeds: joint speeds [rad/s], six or none.
        pose: pose of the tool in the work object. Shape (4, 4), or None.
        twist: velocity of the tool, along the work object's axes [m/s, rad/s], six or none.
    """

    joints: tuple[float, ...] = ()
    joint_speeds: tuple[float, ...] = ()
    pose: Array | None = None
    twist: tuple[float, ...] = ()

    def values(self, what: Follow) -> Array | None:
        """The values of the followed quantity; None if they were not given."""
        if what is Follow.POSE:
            return self.pose
        given = {
            Follow.JOINTS: self.joints,
            Follow.JOINT_SPEEDS: self.joint_speeds,
            Follow.TWIST: self.twist,
        }[what]
        return np.array(given) if given else None


#: the queue of points for realtime control
RealtimeQueue: TypeAlias = Fifo[RealtimeCommand]


def mismatch(
    arm: Arm, q: Array, command: RealtimeCommand, what: Follow, tool: Array, wobj: Array
) -> str:
    """Text about how a first point differs from the state of the arm at rest; empty if not.

    Args:
        arm: the arm.
        q: its joints [rad]. Shape (6,).
        command: the first point.
        what: the followed quantity.
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        wobj: work object in the base frame. Shape (4, 4).
    """
    values = command.values(what)
    if values is None:
        return f"a point has no {what.name.lower().replace('_', ' ')}"
    match what:
        case Follow.JOINTS:
            off = bool(np.abs(values - q).max() > _NEAR_JOINTS)
        case Follow.JOINT_SPEEDS:
            off = bool(np.abs(values).max() > _SLOW_JOINTS)
        case Follow.TWIST:
            off = (
                float(np.linalg.norm(values[:3])) > _SLOW_POINT
                or float(np.linalg.norm(values[3:])) > _SLOW_ANGLE
            )
        case Follow.POSE:
            there = fkine(arm.geometry, q) @ tool
            step = np.linalg.inv(there) @ wobj @ values
            off = (
                float(np.linalg.norm(step[:3, 3])) > _NEAR_POINT
                or float(np.linalg.norm(rotvec_from_matrix(step[:3, :3]))) > _NEAR_ANGLE
            )
    return "the first point is not where the arm is" if off else ""


class RealtimeFollower(TargetFollower):
    """Takes a point from the queue in every cycle.

    Args:
        arm: the arm.
        q: joints at the start [rad]. Shape (6,).
        cycle: time between two ticks [s].
        queue: queue of the points.
        what: the followed quantity.
        bandwidth: bandwidth of the points' filter [Hz].
        patience: time without a point after which there is a fault [s].
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        wobj: work object in the base frame. Shape (4, 4).
    """

    severity: ClassVar[Failure] = "fault"
    resumes_moving = False

    def __init__(
        self,
        arm: Arm,
        q: Array,
        cycle: float,
        queue: RealtimeQueue,
        what: Follow,
        *,
        bandwidth: float,
        patience: float,
        tool: Array,
        wobj: Array,
    ) -> None:
        super().__init__(arm, q, cycle)
        self._queue = queue
        self._what = what
        self._share = 1.0 - math.exp(-2.0 * math.pi * bandwidth * cycle)
        self._patience = patience
        self._tool, self._untool, self._wobj = tool, np.linalg.inv(tool), wobj
        self._began = False
        self._starved = 0.0
        self._target: Array | None = None
        self._filtered = np.zeros(6)
        self._pose = np.eye(4)
        self._resumed()

    def _resumed(self) -> None:
        q = self.setpoint.q
        self._target = None
        self._began = False
        self._starved = 0.0
        self._filtered = q if self._what is Follow.JOINTS else np.zeros(6)
        self._pose = fkine(self._arm.geometry, q) @ self._tool

    def _next(self, q: Array, qd: Array) -> JointSetPoint:  # noqa: ARG002 - it follows no sensors
        self._take()
        if self._target is None:
            return JointSetPoint.at_rest(self.setpoint.q)
        if self._what is Follow.POSE:
            return self._to(self._joints(self._target))
        self._filtered = self._filtered + self._share * (self._target - self._filtered)
        if self._what is Follow.JOINTS:
            return self._to(self._filtered)
        return self._step(self._speeds())

    def _take(self) -> None:
        command = self._queue.take()
        if command is None:
            self._starved += self._cycle
            if self._starved > self._patience + 1e-9:
                raise FollowError(
                    f"realtime control: no data for {self._patience:g} s", self.severity
                )
            return
        self._starved = 0.0
        values = command.values(self._what)
        if values is None or not self._began:
            arm, q = self._arm, self.setpoint.q
            if wrong := mismatch(arm, q, command, self._what, self._tool, self._wobj):
                raise FollowError(f"realtime control: {wrong}", self.severity)
            self._began = True
        self._target = values

    def _to(self, q: Array) -> JointSetPoint:
        last = self.setpoint
        qd = (q - last.q) / self._cycle
        return JointSetPoint(q, qd, (qd - last.qd) / self._cycle)

    def _joints(self, target: Array) -> Array:
        goal, here = self._wobj @ target, self._pose
        moved = here.copy()
        moved[:3, 3] += self._share * (goal[:3, 3] - here[:3, 3])
        turn = rotvec_from_matrix(goal[:3, :3] @ here[:3, :3].T)
        moved[:3, :3] = matrix_from_rotvec(self._share * turn) @ here[:3, :3]
        self._pose = moved
        try:
            return self._arm.ikine(moved @ self._untool, self.setpoint.q, max_jump=MAX_JUMP)
        except Unreachable as exc:
            raise FollowError(f"realtime control: {exc}", self.severity) from exc

    def _speeds(self) -> Array:
        if self._what is Follow.JOINT_SPEEDS:
            return self._filtered
        rotation = self._wobj[:3, :3]
        twist = np.concatenate([rotation @ self._filtered[:3], rotation @ self._filtered[3:]])
        half = self.setpoint.q + 0.5 * self._cycle * self.setpoint.qd
        try:
            return joint_speeds(self._arm, half, twist, self._tool)
        except FollowError as exc:
            raise FollowError(f"realtime control: {exc}", self.severity) from exc
