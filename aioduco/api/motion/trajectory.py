"""Execution of joint trajectories with times: what ROS calls FollowJointTrajectory, without ROS."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import anyio.lowlevel
import numpy as np

from aioduco.api.motion.switch import SwitchPlace, TrajectorySwitch
from aioduco.api.streams.realtime import CYCLE, RealtimeStreams
from aioduco.api.streams.servo import Servo
from aioduco.errors import (
    Described,
    DucoError,
    GoalToleranceViolated,
    ParameterError,
    PathToleranceViolated,
    StreamLost,
)
from aioduco.streaming.joint_trajectory import Feedback, Tolerances, TrajectoryResult
from aioduco.streaming.sampling import Spline, instants
from aioduco.supervision.concurrency import every, first_error

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from numpy.typing import NDArray

    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.streaming.joint_trajectory import JointTrajectory
    from aioduco.streaming.shared.options import WorkerOptions
    from aioduco.streaming.stream import Stream


_LOOK = 0.02  # seconds between two reads of the arm's position
_DEPTH = 100  # points in the controller's queue: it lasts for 0.1 s without new points
_LAG = 0.3  # seconds by which the arm may lag behind its set-points without being off its path
_AHEAD = 0.4  # seconds of set-points that are sent ahead, where another trajectory may come
_ROUNDING = 1e-3  # share by which a speed may be above the limit from which it was computed
_REST = 0.01  # rad/s up to which a joint rests at the last point
_AT_ONCE = 4096  # set-points computed before the event loop runs again
_WINDOW = 60  # points of the path in that time with which the arm's position is compared


async def follow(
    endpoint: StreamEndpoint,
    read_joints: Callable[[], Awaitable[Sequence[float]]],
    trajectory: JointTrajectory,
    *,
    realtime: bool,
    v: float,
    a: float,
    tolerances: Tolerances | None = None,
    feedback: Callable[[Feedback], object] | None = None,
    rate: float = 500.0,
    reach: float = 0.05,
    switch: TrajectorySwitch | None = None,
    options: WorkerOptions | None = None,
) -> TrajectoryResult:
    """Follow a joint trajectory to its end, and wait until the arm has arrived.

    A cancellation brings the arm to rest before it propagates.

    Args:
        endpoint: the controller.
        read_joints: function that reads the joint angles [rad].
        trajectory: the trajectory.
        realtime: whether to send through the realtime queue instead of servoj.
        v: largest speed of each joint [rad/s]; a trajectory that is faster, by more than
            rounding, is refused.
        a: largest acceleration of each joint [rad/s²]; sharper corners of the trajectory are
            rounded.
        tolerances: largest distances of the arm from the trajectory; None: the defaults.
        feedback: callback that gets a `Feedback` about 50 times a second.
        rate: set-points per second of servoj [Hz]; the queue has 1000.
        reach: largest distance of each joint from the first point at the start [rad].
        switch: leads the arm into another trajectory on the way; None: none will come.
        options: how the worker runs; None: in a process of its own.

    Raises:
        ParameterError: the trajectory is too fast for `v`, or does not end at rest; nothing was
            sent.
        PathToleranceViolated: the arm strayed from the path; it was brought to rest.
        GoalToleranceViolated: the arm did not come close enough to the last point in time.
        StreamError: the stream ended for another reason.
    """
    limits = tolerances or Tolerances()
    curve = trajectory.curve(await read_joints())
    interval = CYCLE if realtime else 1 / rate
    points = await _points(curve, interval, v)
    step = max(0.2, 2 * v * interval)
    ahead = None if switch is None else max(2, round(_AHEAD / interval))
    stream: Stream
    if realtime:
        stream = RealtimeStreams(endpoint).stream(
            "joint_position", v=v, a=a, depth=_DEPTH, max_step=step, reach=reach, ahead=ahead,
            options=options,
        )  # fmt: skip
    else:
        stream = Servo(endpoint).joints(
            v=v, a=a, rate=rate, max_step=step, reach=reach, ahead=ahead, options=options
        )
    way = _Way(curve, interval, limits)
    watcher = _Watcher(way, read_joints, stream, feedback)
    start = time.monotonic()
    try:
        async with stream, anyio.create_task_group() as tasks:
            tasks.start_soon(watcher.watch)
            if switch is None:
                await stream.play(points)
            else:
                await _send(stream, points, way, switch, v)
            tasks.cancel_scope.cancel()
    except BaseExceptionGroup as group:
        if watcher.strayed is not None and endpoint.stop is not None:
            with anyio.CancelScope(shield=True):
                await endpoint.stop("")
        raise first_error(group) from None
    await watcher.arrive()
    return TrajectoryResult(
        time.monotonic() - start, watcher.worst, watcher.goal_error, stream.statistics()
    )


async def _points(curve: Spline, interval: float, v: float) -> NDArray[np.float64]:
    """The set-points of a curve, computed bit by bit: those of ten minutes take a second.

    Raises:
        ParameterError: it is too fast, or does not end at rest.
    """
    at = curve.times[0] + instants(curve.duration, interval)
    points = np.empty((len(at), 6))
    for begin in range(0, len(at), _AT_ONCE):
        points[begin : begin + _AT_ONCE] = curve.at(at[begin : begin + _AT_ONCE])
        await anyio.lowlevel.checkpoint()
    speed = np.abs(np.diff(points, axis=0)).max(initial=0.0) / interval
    if speed > v * (1 + _ROUNDING):
        raise ParameterError(
            "trajectory", Described(f"a joint at {speed:.4g} rad/s"), f"up to {v:g} rad/s"
        )
    ending = np.abs(curve.velocity(curve.times[-1:])).max()
    if ending > _REST:
        given = Described(f"a joint at {ending:.4g} rad/s at its last point")
        raise ParameterError("trajectory", given, "at rest there, or the arm would go beyond it")
    return points


async def _send(
    stream: Stream, points: NDArray[np.float64], way: _Way, switch: TrajectorySwitch, v: float
) -> None:
    """Send set-points a little ahead of the arm, and go over to others when that is asked for.

    The last one is sent as `Stream.play` does, which waits until it was taken.
    """
    index = 0
    switch.begin()
    try:
        while index < len(points) - 1:
            if switch.asked and (other := switch.made(way.place(index, stream.taken))) is not None:
                trajectory, limits = other
                curve = trajectory.curve(points[index])
                points, index = await _points(curve, way.interval, v), 0
                way.go_over(curve, limits)
            await stream.send(points[index])
            way.sent += 1
            index += 1
    finally:
        switch.end()
    await stream.play(points[-1:])


class _Part(NamedTuple):
    """A trajectory that is followed from a set-point on."""

    first: int
    curve: Spline
    tolerances: Tolerances


class _Way:
    """The trajectories that are followed one after the other, by the number of the set-point.

    Attributes:
        interval: time between two set-points [s].
        sent: set-points that were sent.
    """

    def __init__(self, curve: Spline, interval: float, tolerances: Tolerances) -> None:
        self.interval = interval
        self.sent: int = 0
        self._parts = [_Part(0, curve, tolerances)]

    def place(self, index: int, taken: int) -> SwitchPlace:
        """The place of the next set-point, which is the one of this index of its trajectory."""
        curve = self._parts[-1].curve
        at = curve.times[:1] + index * self.interval
        delay = max(0, self.sent - taken) * self.interval
        return SwitchPlace(curve.at(at)[0], curve.velocity(at)[0], delay)

    def go_over(self, curve: Spline, tolerances: Tolerances) -> None:
        """Follow another trajectory from the next set-point on."""
        self._parts.append(_Part(self.sent, curve, tolerances))

    def last(self) -> _Part:
        """The trajectory at whose end the arm arrives."""
        return self._parts[-1]

    def part(self, number: float) -> _Part:
        """The trajectory of a set-point."""
        begun = [each for each in self._parts if each.first <= number]
        return begun[-1] if begun else self._parts[0]

    def time(self, number: float) -> float:
        """The time of a set-point on the newest trajectory that was begun to be sent [s]."""
        first, curve, _ = self._parts[-1]
        since = min(max(0.0, number - first) * self.interval, curve.duration)
        return float(curve.times[0]) + since

    def at(self, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places of set-points, and between them. Shape (n, 6)."""
        places = np.empty((len(numbers), 6))
        ends = [*(each.first for each in self._parts[1:]), np.inf]
        low = -np.inf
        for (first, curve, _), end in zip(self._parts, ends, strict=True):
            here = (numbers >= low) & (numbers < end)
            places[here] = curve.at(curve.times[0] + (numbers[here] - first) * self.interval)
            low = end
        return places


class _Watcher:
    """Compares the arm's position with the trajectory."""

    def __init__(
        self,
        way: _Way,
        read: Callable[[], Awaitable[Sequence[float]]],
        stream: Stream,
        feedback: Callable[[Feedback], object] | None,
    ) -> None:
        self._way = way
        self._read = read
        self._stream = stream
        self._feedback = feedback
        self.worst = np.zeros(6)
        self.goal_error = np.zeros(6)
        self.strayed: PathToleranceViolated | None = None

    async def watch(self) -> None:
        """Read the arm's position again and again, until it is outside the path tolerance."""
        async for _ in every(_LOOK):
            taken = self._stream.taken
            if not taken:
                continue
            actual = await self._actual("the stream was ended, and the arm is brought to rest")
            error = self._compare(taken, self._stream.taken, actual)
            self.worst = np.maximum(self.worst, np.abs(error))
            path = np.broadcast_to(self._way.part(taken - 1).tolerances.path, 6)
            if self._stream.quiet:
                continue  # it has ended, as at a first point too far away: its own error says why
            beyond = np.where(path > 0.0, np.abs(error) - path, 0.0)
            if np.any(beyond > 0.0):
                joint = int(np.argmax(beyond))
                self.strayed = PathToleranceViolated(
                    f"joint {joint + 1} is {error[joint]:+.4g} rad from its trajectory, "
                    f"{path[joint]:g} allowed; the arm was brought to rest, and stopped",
                    self._stream.statistics(),
                )
                raise self.strayed

    async def _actual(self, arm: str) -> NDArray[np.float64]:
        """Read where the arm is [rad].

        Args:
            arm: what it does, for the error.

        Raises:
            StreamLost: the controller does not say.
        """
        try:
            return np.asarray(await self._read(), dtype=np.float64)
        except DucoError as exc:
            raise StreamLost(
                f"it is not known where the arm is ({exc}): {arm}", self._stream.statistics()
            ) from exc

    def _compare(self, before: int, after: int, actual: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the arm's distance from the recent part of the path, where the arm may be [rad].

        Args:
            before: set-points taken when the read of the position began.
            after: set-points taken when the read had ended: if it took long, the arm may have moved
                on by the difference.
            actual: joint angles that were read [rad].
        """
        interval = self._way.interval
        first, last = max(0.0, before - 1 - _LAG / interval), after - 1 + _LOOK / 2 / interval
        places = self._way.at(np.linspace(first, last, _WINDOW))
        errors = actual - places
        # By the sum of the distances: one joint with a large error does not shift the point.
        nearest = int(np.argmin(np.abs(errors).sum(axis=1)))
        if self._feedback is not None:
            now = self._way.time(before - 1)
            self._feedback(Feedback(now, places[nearest], actual, errors[nearest]))
        return np.asarray(errors[nearest])

    async def arrive(self) -> None:
        """Wait until the arm is at its goal."""
        _, curve, tolerances = self._way.last()
        goal, allowed = curve.at(curve.times[-1:])[0], np.broadcast_to(tolerances.goal, 6)
        until = time.monotonic() + tolerances.goal_time
        async for _ in every(_LOOK):
            actual = await self._actual("it has followed all of the trajectory")
            self.goal_error = actual - goal
            if np.all(np.abs(self.goal_error) <= allowed):
                return
            if time.monotonic() > until:
                joint = int(np.argmax(np.abs(self.goal_error) - allowed))
                raise GoalToleranceViolated(
                    f"joint {joint + 1} is {self.goal_error[joint]:+.4g} rad from its goal "
                    f"{tolerances.goal_time:g} s after the end, {allowed[joint]:g} allowed",
                    self._stream.statistics(),
                )
