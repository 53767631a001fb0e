"""The track pool and its followers (轨迹池, manual 1.3.12).

A follower moves through the points one after the other. It does not stop between them while the
pool holds enough points ahead. Its speed and acceleration are those of the joint that turns
furthest, or of the tool. Between two points it follows a cubic, whose slope at a point is the mean
slope from the previous point to the next one. (The manual says that the points are reached in
order; the curve between them is an assumption.)

Distances are along the chords from point to point. At a point j, at distance d_j, the square of the
follower's speed may be at most c_j. So at distance d the square may be at most the minimum of
c_j + 2 a (d_j - d) over all points ahead. A queue holds only the points that can be this minimum,
so a cycle costs the same for a thousand points as for ten.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeAlias, TypeVar

import numpy as np

from aioduco.errors import Unreachable
from aioduco.kinematics.forward import fkine
from aioduco.models.pose import Pose
from aioduco.models.rotation import (
    matrix_from_quaternion,
    quaternion_from_matrix,
    rotvec_from_matrix,
    transform,
)
from aioduco.sim.planner.follower import MAX_JUMP, FollowError, TargetFollower
from aioduco.sim.planner.path import JointSetPoint

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array


CAPACITY = 1000
"""Largest number of points: of the track pool by manual 1.3.12, of others by assumption."""

T = TypeVar("T")
#: six numbers, and what is done when the point is reached
TrackPoint: TypeAlias = "tuple[tuple[float, ...], Callable[[], None] | None]"
_ACROSS = 0.5  # share of the acceleration for the bends of the path; the rest is along it
_SAME = 1e-9  # points nearer than this are the same [m, rad]
_MARGIN = 0.95  # share of the joints' largest speeds, as the curve differs from the chords
_METRES = 0.5  # slope of the tool's position above which a length is in metres, not in radians
_PER_CYCLE = 8  # largest number of points that a cycle reads, so that no cycle takes long


class Fifo(Generic[T]):
    """A queue that accepts all points of a call or none."""

    def __init__(self) -> None:
        self._points: deque[T] = deque()

    def __len__(self) -> int:
        return len(self._points)

    def put(self, points: Iterable[T]) -> bool:
        """Put all points in, or none if they do not fit; return whether they did."""
        new = list(points)
        if len(self._points) + len(new) > CAPACITY:
            return False
        self._points.extend(new)
        return True

    def clear(self) -> None:
        """Drop all points."""
        self._points.clear()

    def first(self) -> T | None:
        """The next point, which stays in the queue; None if there is none."""
        return self._points[0] if self._points else None

    def take(self) -> T | None:
        """Remove the next point and give it; None if there is none."""
        return self._points.popleft() if self._points else None


class TrackPool(Fifo[TrackPoint]):
    """The track pool (轨迹池): points, each with an action, or with None.

    Attributes:
        taken: number of points that were removed from its front, or dropped.
        cleared: how often it was cleared.
    """

    def __init__(self) -> None:
        super().__init__()
        self.taken: int = 0
        self.cleared: int = 0

    def clear(self) -> None:
        """Drop all points."""
        self.taken += len(self)
        self.cleared += 1
        super().clear()

    def get(self, number: int) -> TrackPoint | None:
        """The point with a number, counted from the very first; None if there is none yet.

        Raises:
            FollowError: the point was removed or dropped.
        """
        index = number - self.taken
        if index < 0:
            raise FollowError(f"point {number} has left the track pool")
        return self._points[index] if index < len(self) else None

    def take_to(self, number: int) -> None:
        """Remove the point with a number, and all before it."""
        while self.taken <= number and self.take() is not None:
            self.taken += 1


@dataclass(slots=True, eq=False)
class _Node:
    """A point of the path.

    Attributes:
        number: number of the pool's point, counted from the very first.
        x: the interpolated quantity. Shape (n,).
        q: joints [rad]. Shape (6,).
        at: distance from the start of the path.
        action: what is done when it is reached.
        slope: slope of x, then of q, over the distance; None while the next point is not known.
        most: square of the largest speed there, for its bend and its two chords.
        cap: square of the largest speed on the way to it, for the sharpest bend of that way.
        stretch: largest ratio of lengths along the curve and along the chord, on the way to it.
    """

    number: int
    x: Array
    q: Array
    at: float
    action: Callable[[], None] | None = None
    slope: Array | None = None
    most: float = math.inf
    cap: float = math.inf
    stretch: float = 1.0

    @property
    def both(self) -> Array:
        """x, then q. Shape (n + 6,)."""
        return np.concatenate([self.x, self.q])


class _Track(TargetFollower):
    setpoint: JointSetPoint

    def __init__(
        self,
        arm: Arm,
        q: Array,
        cycle: float,
        pool: TrackPool,
        speed: float,
        acceleration: float,
    ) -> None:
        super().__init__(arm, q, cycle)
        self._pool = pool
        self._v, self._a = speed, acceleration
        self._drives = np.array(arm.acceleration)
        self._cleared = pool.cleared
        self._rate = 0.0  # speed along the path
        self._at = 0.0  # distance
        self._underrun = False  # slowing down because there are no more points
        self._here = _Node(pool.taken - 1, *self._first(q), at=0.0)
        self._nodes: deque[_Node] = deque()  # ahead; the arm is between _here and the first
        self._window: deque[_Node] = deque()  # those of the nodes that can limit the speed

    # -- differences between joints and tools -------------------------------------------------

    @abstractmethod
    def _first(self, q: Array) -> tuple[Array, Array]:
        """Give x and the joints where the arm stands."""

    @abstractmethod
    def _place(self, values: tuple[float, ...], last: _Node) -> tuple[Array, Array, float]:
        """Give x and the joints of a point of the pool, and its distance from the previous one."""

    @abstractmethod
    def _joints(self, x: Array) -> Array:
        """Give the joints for an x on the path."""

    @abstractmethod
    def _size(self, derivative: Array, way: Array) -> float:
        """Give the size of a derivative of x, in the unit of the speed and the acceleration.

        Args:
            derivative: of x over the distance. Shape (n,).
            way: x at the end of the way less x at its start, over its length. Shape (n,).
        """

    # -- looking ahead ------------------------------------------------------------------------

    def _look(self) -> None:
        """Read new points from the pool, and drop the earlier ones if the pool was cleared."""
        if self._cleared != self._pool.cleared:
            self._cleared = self._pool.cleared
            self._forget()
        last = self._nodes[-1] if self._nodes else self._here
        for _ in range(_PER_CYCLE):
            found = None if self._underrun else self._pool.get(last.number + 1)
            if found is None:
                return
            values, action = found
            x, q, length = self._place(values, last)
            node = _Node(last.number + 1, x, q, last.at + length, action)
            if length < _SAME:
                last.number += 1
                self._pool.take_to(last.number)
                if action is not None:
                    action()
                continue
            self._join(last, node, length)
            self._nodes.append(node)
            last = node

    def _join(self, last: _Node, node: _Node, length: float) -> None:
        """Compute slope and speed at a point, now that the next point is known."""
        first = self._nodes and last is self._nodes[-1]
        chord = (node.both - last.both) / length
        with np.errstate(divide="ignore"):
            joints = _MARGIN * np.array(self._arm.velocity) * length / np.abs(node.q - last.q)
        fastest = float(joints.min()) ** 2
        node.most = fastest
        last.most = min(last.most, fastest)
        if not first:
            last.slope = last.slope if last.slope is not None else chord
            self._bends(last, node, last.slope, chord)
            return
        before = self._nodes[-2] if len(self._nodes) > 1 else self._here
        if last.slope is None:
            last.slope = (node.both - before.both) / (node.at - before.at)
        slope = last.slope  # which does not change once the motion to the point has begun
        self._bends(before, last, before.slope, slope)
        last.most = min(last.most, last.cap)
        if self._window and self._window[-1] is before:
            before.most = min(before.most, last.cap)
            self._window.pop()
            self._limit(before)
        self._limit(last)
        # As far as is known the path ends at the new point; with the next one it bends otherwise.
        self._bends(last, node, slope, chord)

    def _bends(self, a: _Node, b: _Node, m: Array | None, n: Array) -> None:
        """Store the longest slope between two points, and the speed that the bends there allow."""
        length = b.at - a.at
        rise = (b.both - a.both) / length
        m = rise if m is None else m
        x = slice(-6)
        slopes = (
            m,
            1.125 * rise + 0.1875 * m - 0.3125 * n,
            1.5 * rise - 0.25 * (m + n),
            1.125 * rise - 0.3125 * m + 0.1875 * n,
            n,
        )
        b.stretch = max(1.0, *(self._size(each[x], rise[x]) for each in slopes))
        bends = (
            (6.0 * rise - 4.0 * m - 2.0 * n) / length,
            (-6.0 * rise + 2.0 * m + 4.0 * n) / length,
        )
        own = max(self._size(each[x], rise[x]) for each in bends) / self._a
        joints = max(float((np.abs(each[-6:]) / self._drives).max()) for each in bends)
        bend = max(own, joints)
        b.cap = _ACROSS / bend if bend > 0.0 else math.inf

    def _limit(self, node: _Node) -> None:
        key = self._key(node)
        while self._window and self._key(self._window[-1]) >= key:
            self._window.pop()
        self._window.append(node)

    def _key(self, node: _Node) -> float:
        return node.most + 2.0 * self._along * node.at

    @property
    def _along(self) -> float:
        return (1.0 - _ACROSS) * self._a

    def _forget(self) -> None:
        """Keep the points that the arm needs for braking, and drop the others."""
        braking = self._at + 0.5 * self._rate**2 / self._along + self._rate * self._cycle
        kept = deque[_Node]()
        for node in self._nodes:
            kept.append(node)
            if node.at >= braking:
                break
        if not self._rate:
            kept.clear()
        for node in kept:
            node.number = self._pool.taken - 1
        self._here.number = self._pool.taken - 1
        self._nodes = kept
        self._window = deque(node for node in self._window if node in kept and node is not kept[-1])

    # -- moving -------------------------------------------------------------------------------

    def _next(self, q: Array, qd: Array) -> JointSetPoint:  # noqa: ARG002 - it follows no sensors
        self._look()
        if not self._nodes:
            if not self._underrun:
                self._end()
            self._underrun = False
            return JointSetPoint.at_rest(self.setpoint.q)
        way = self._nodes[0]
        most = min(self._v * self._speed / way.stretch, math.sqrt(way.cap))
        rate = min(self._rate + self._along * self._cycle, most)
        rate = max(rate, self._rate - self._along * self._cycle)
        ahead = self._window[0] if self._window else None
        if ahead is not None:
            rate = min(rate, self._rate_before(ahead.most, ahead.at))
        last = self._nodes[-1]
        if len(self._nodes) > 1:
            rate = min(rate, self._rate_before(last.cap, self._nodes[-2].at))
        ending = self._rate_before(0.0, last.at)
        if ending < rate:
            rate = ending
            self._underrun = self._underrun or self._pool.get(last.number + 1) is None
        return self._go(rate)

    def _rate_before(self, most: float, at: float) -> float:
        """The speed for this cycle from which braking reaches a squared speed of `most` at `at`."""
        change = self._along * self._cycle
        room = most + 2.0 * self._along * max(at - self._at, 0.0)
        return math.sqrt(change * change + room) - change

    def _slow_down(self) -> None:
        if self._after_stop != "stand" or self.failure is not None or not self._nodes:
            super()._slow_down()
            return
        change = self._along * self._cycle
        try:
            self.setpoint = self._go(max(self._rate - change, 0.0))
        except FollowError as exc:
            self._fail(exc)
            super()._slow_down()

    def _go(self, rate: float) -> JointSetPoint:
        at = self._at + 0.5 * (self._rate + rate) * self._cycle
        last = self._nodes[-1]
        stands = rate < 1e-3 * self._along * self._cycle or last.at - at < 1e-3 * _SAME
        if stands and last.at - at < max(1e-6, rate * self._cycle):
            at, rate = last.at, 0.0
        self._at, self._rate = at, rate
        while self._nodes and self._at >= self._nodes[0].at - 1e-15:
            self._pass()
        if not self._nodes:
            q = self._here.q
            self._rate = 0.0
            return JointSetPoint.at_rest(q)
        self._pool.take_to(self._nodes[0].number)
        q = self._joints(self._curve())
        qd = (q - self.setpoint.q) / self._cycle if rate > 0.0 else np.zeros(6)
        return JointSetPoint(q, qd, (qd - self.setpoint.qd) / self._cycle)

    def _pass(self) -> None:
        self._here = self._nodes.popleft()
        if self._window and self._window[0] is self._here:
            self._window.popleft()
        self._pool.take_to(self._here.number)
        if self._here.action is not None:
            self._here.action()
        if not self._nodes:
            self._here.slope = None

    def _curve(self) -> Array:
        a, b = self._here, self._nodes[0]
        length = b.at - a.at
        start, end = a.slope, b.slope
        if start is None or end is None:
            chord = (b.both - a.both) / length
            if end is None and len(self._nodes) == 1:
                b.slope = chord  # the motion to it has begun: later points cannot bend it
            start, end = (chord if slope is None else slope for slope in (start, end))
        m, n = start[:-6] * length, end[:-6] * length
        t = (self._at - a.at) / length
        u = 1.0 - t
        x: Array = (
            (1.0 + 2.0 * t) * u * u * a.x + t * u * u * m + t * t * (3.0 - 2.0 * t) * b.x
        ) - t * t * u * n
        return x


class JointTrack(_Track):
    """Moves through points that are joints [rad]; speeds are of the joint that turns furthest."""

    def _first(self, q: Array) -> tuple[Array, Array]:
        return q, q

    def _place(self, values: tuple[float, ...], last: _Node) -> tuple[Array, Array, float]:
        q = np.array(values)
        return q, q, float(np.abs(q - last.q).max())

    def _joints(self, x: Array) -> Array:
        return x

    def _size(self, derivative: Array, way: Array) -> float:  # noqa: ARG002 - joints only turn
        return float(np.abs(derivative).max())


class ToolTrack(_Track):
    """Moves through poses of the tool in a work object; speeds are the tool's [m/s].

    Where the tool only turns, speeds are taken in rad/s.

    Args:
        arm: the arm.
        q: joints at the start [rad]. Shape (6,).
        cycle: time between two ticks [s].
        pool: pool of the points.
        speed: speed of the tool [m/s].
        acceleration: acceleration of the tool [m/s²].
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        wobj: work object in the base frame. Shape (4, 4).
    """

    def __init__(
        self,
        arm: Arm,
        q: Array,
        cycle: float,
        pool: TrackPool,
        speed: float,
        acceleration: float,
        *,
        tool: Array,
        wobj: Array,
    ) -> None:
        self._tool, self._untool, self._wobj = tool, np.linalg.inv(tool), wobj
        super().__init__(arm, q, cycle, pool, speed, acceleration)

    def _first(self, q: Array) -> tuple[Array, Array]:
        return _numbers(fkine(self._arm.geometry, q) @ self._tool), q

    def _place(self, values: tuple[float, ...], last: _Node) -> tuple[Array, Array, float]:
        goal = self._wobj @ Pose(*values).matrix
        x = _numbers(goal)
        if x[3:] @ last.x[3:] < 0.0:
            x[3:] = -x[3:]
        try:
            q = self._arm.ikine(goal @ self._untool, last.q)
        except Unreachable as exc:
            raise FollowError(f"a point of the track pool: {exc}") from exc
        metres = float(np.linalg.norm(x[:3] - last.x[:3]))
        if metres > 1e-6:
            return x, q, metres
        between = _rotation(last.x).T @ goal[:3, :3]
        return x, q, float(np.linalg.norm(rotvec_from_matrix(between)))

    def _joints(self, x: Array) -> Array:
        goal = transform(_rotation(x), x[:3])
        try:
            return self._arm.ikine(goal @ self._untool, self.setpoint.q, max_jump=MAX_JUMP)
        except Unreachable as exc:
            raise FollowError(f"the way through the track pool: {exc}") from exc

    def _size(self, derivative: Array, way: Array) -> float:
        if np.linalg.norm(way[:3]) > _METRES:
            return float(np.linalg.norm(derivative[:3]))
        return float(2.0 * np.linalg.norm(derivative[3:]))  # of a quaternion


def _numbers(pose: Array) -> Array:
    return np.concatenate([pose[:3, 3], quaternion_from_matrix(pose[:3, :3])])


def _rotation(x: Array) -> Array:
    rotation: Array = matrix_from_quaternion(x[3:] / np.linalg.norm(x[3:]))
    return rotation
