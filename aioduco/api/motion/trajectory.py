"""Execution of joint trajectories with times: what ROS calls FollowJointTrajectory, without ROS."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import anyio
import numpy as np

from aioduco.errors import GoalToleranceViolated, ParameterError, PathToleranceViolated
from aioduco.streaming.joint_trajectory import Feedback, Tolerances, TrajectoryResult
from aioduco.streaming.options import per_group
from aioduco.streaming.realtime import CYCLE, RealtimeStreams
from aioduco.streaming.sampling import instants
from aioduco.streaming.servo import Servo
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from numpy.typing import NDArray

    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.streaming.joint_trajectory import JointTrajectory
    from aioduco.streaming.options import WorkerOptions
    from aioduco.streaming.sampling import Spline
    from aioduco.streaming.stream import Stream

__all__ = ["follow"]

_LOOK = 0.02  # seconds between two reads of the arm's position
_DEPTH = 100  # points in the controller's queue: it lasts for 0.1 s without new points
_LAG = 0.3  # seconds by which the arm may lag behind its set-points without being off its path
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
    options: WorkerOptions | None = None,
) -> TrajectoryResult:
    """Follow a joint trajectory to its end, and wait until the arm has arrived.

    A cancellation brings the arm to rest before it propagates.

    Args:
        endpoint: the controller.
        read_joints: function that reads the joint angles [rad].
        trajectory: the trajectory.
        realtime: whether to send through the realtime queue instead of servoj.
        v: largest speed of each joint [rad/s]; a trajectory that is faster is refused.
        a: largest acceleration of each joint [rad/s²]; sharper corners of the trajectory are
            rounded.
        tolerances: largest distances of the arm from the trajectory; None: the defaults.
        feedback: callback that gets a `Feedback` about 50 times a second.
        rate: set-points per second of servoj [Hz]; the queue has 1000.
        reach: largest distance of each joint from the first point at the start [rad].
        options: how the worker runs; None: in a process of its own.

    Raises:
        ParameterError: the trajectory is too fast for `v`; nothing was sent.
        PathToleranceViolated: the arm strayed from the path; it was brought to rest.
        GoalToleranceViolated: the arm did not come close enough to the last point in time.
        StreamError: the stream ended for another reason.
    """
    limits = tolerances or Tolerances()
    curve = trajectory.curve(await read_joints())
    interval = CYCLE if realtime else 1 / rate
    points = curve.at(curve.times[0] + instants(curve.duration, interval))
    speed = np.abs(np.diff(points, axis=0)).max(initial=0.0) / interval
    if speed > v * (1 + 1e-6):
        raise ParameterError("trajectory", f"a joint at {speed:.4g} rad/s", f"up to {v:g} rad/s")
    step = max(0.2, 2 * v * interval)
    stream: Stream
    if realtime:
        stream = RealtimeStreams(endpoint).stream(
            "joint_position", v=v, a=a, depth=_DEPTH, max_step=step, reach=reach, options=options
        )
    else:
        stream = Servo(endpoint).joints(
            v=v, a=a, rate=rate, max_step=step, reach=reach, options=options
        )
    watcher = _Watcher(curve, read_joints, stream, interval, limits, feedback)
    start = time.monotonic()
    try:
        async with stream, anyio.create_task_group() as tasks:
            tasks.start_soon(watcher.watch)
            await stream.play(points)
            tasks.cancel_scope.cancel()
    except BaseExceptionGroup as group:
        if watcher.strayed is not None and endpoint.stop is not None:
            with anyio.CancelScope(shield=True):
                await endpoint.stop("")
        raise _first(group) from None
    await watcher.arrive()
    return TrajectoryResult(
        time.monotonic() - start, watcher.worst, watcher.goal_error, stream.statistics()
    )


class _Watcher:
    """Compares the arm's position with the trajectory."""

    def __init__(
        self,
        curve: Spline,
        read: Callable[[], Awaitable[Sequence[float]]],
        stream: Stream,
        interval: float,
        tolerances: Tolerances,
        feedback: Callable[[Feedback], object] | None,
    ) -> None:
        self._curve = curve
        self._read = read
        self._stream = stream
        self._interval = interval
        self._feedback = feedback
        self._path = np.zeros(6) if not tolerances.path else _six("path", tolerances.path)
        self._goal = _six("goal", tolerances.goal)
        self._goal_time = tolerances.goal_time
        self.worst = np.zeros(6)
        self.goal_error = np.zeros(6)
        self.strayed: PathToleranceViolated | None = None

    async def watch(self) -> None:
        """Read the arm's position again and again, until it is outside the path tolerance."""
        async for _ in every(_LOOK):
            taken = self._stream.taken
            if not taken:
                continue
            actual = np.asarray(await self._read(), dtype=np.float64)
            error = self._compare(taken, self._stream.taken, actual)
            self.worst = np.maximum(self.worst, np.abs(error))
            if np.any(self._path) and np.any(np.abs(error) > self._path):
                joint = int(np.argmax(np.abs(error) - self._path))
                self.strayed = PathToleranceViolated(
                    f"joint {joint + 1} is {error[joint]:+.4g} rad from its trajectory, "
                    f"{self._path[joint]:g} allowed; the arm was brought to rest, and stopped",
                    self._stream.statistics(),
                )
                raise self.strayed

    def _compare(self, before: int, after: int, actual: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the arm's distance from the recent part of the path, where the arm may be [rad].

        Args:
            before: set-points taken when the read of the position began.
            after: set-points taken when the read had ended: if it took long, the arm may have moved
                on by the difference.
            actual: joint angles that were read [rad].
        """
        now, end = (
            self._curve.times[0] + min((taken - 1) * self._interval, self._curve.duration)
            for taken in (before, after)
        )
        times = np.linspace(max(self._curve.times[0], now - _LAG), end + _LOOK / 2, _WINDOW)
        places = self._curve.at(times)
        errors = actual - places
        # By the sum of the distances: one joint with a large error does not shift the point.
        nearest = int(np.argmin(np.abs(errors).sum(axis=1)))
        if self._feedback is not None:
            self._feedback(Feedback(now, places[nearest], actual, errors[nearest]))
        return np.asarray(errors[nearest])

    async def arrive(self) -> None:
        """Wait until the arm is at its goal."""
        goal = self._curve.at(self._curve.times[-1:])[0]
        until = time.monotonic() + self._goal_time
        async for _ in every(_LOOK):
            actual = np.asarray(await self._read(), dtype=np.float64)
            self.goal_error = actual - goal
            if np.all(np.abs(self.goal_error) <= self._goal):
                return
            if time.monotonic() > until:
                joint = int(np.argmax(np.abs(self.goal_error) - self._goal))
                raise GoalToleranceViolated(
                    f"joint {joint + 1} is {self.goal_error[joint]:+.4g} rad from its goal "
                    f"{self._goal_time:g} s after the end, {self._goal[joint]:g} allowed",
                    self._stream.statistics(),
                )


def _first(group: BaseExceptionGroup[BaseException]) -> BaseException:
    """Return the first error of a group; it caused the others."""
    error = group.exceptions[0]
    return _first(error) if isinstance(error, BaseExceptionGroup) else error


def _six(name: str, value: float | tuple[float, ...]) -> NDArray[np.float64]:
    return np.array(per_group(name, value, 6))
