"""Streams through the controller's track pool (轨迹池, manual 1.3.12)."""

from __future__ import annotations

from typing import Any, Literal

from aioduco._wire import rpc
from aioduco.api.streams import StreamMaker
from aioduco.api.streams.arguments import per_group
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.op import Op, wire_op
from aioduco.models.rules import Integer, Real, VectorLike
from aioduco.models.words import one_of
from aioduco.streaming.shared.config import StreamSpec
from aioduco.streaming.shared.options import Feeding, WorkerOptions
from aioduco.streaming.shared.space import Limits
from aioduco.streaming.stream import Stream
from aioduco.streaming.worker.encoding import element_tail
from aioduco.supervision.motion_sources import TRACK_POOL

POOL = 1000  # points that fit (manual 1.3.12)
LEAST = 10  # points to keep in the pool, for a motion without a halt (manual 1.3.12)
_EXTRA = 512  # bytes for the operation of a point: 128 and three names of events
_COUNT = Integer(LEAST, POOL, "points", source="1.3.12")
_AHEAD = Integer(1, 16384, "points", source="this package")
_RATE = 100.0  # points per second, for the size of the worker's ring; not the speed of the arm


class TrackStream(Stream):
    """A stream into the track pool: points of a path, optionally with outputs to set."""

    async def send(self, point: VectorLike, op: Op | None = None) -> None:
        """Send one point of the path.

        The first points wait in the worker until there are enough of them to begin.

        Args:
            point: the point, in the stream's units. Shape (6,).
            op: outputs to set at the point; only for streams opened with `operations`.

        Raises:
            ParameterError: an argument is not allowed; nothing was sent, and the stream continues.
            StreamError: the stream has ended; the error says why.
        """
        values = tuple(self._check("point", point))
        await self._feed((values,), self._feeding.queued, self._tail(op))

    async def play(self, trajectory: Any, times: Any = None) -> None:
        """Send a whole path, and wait until the worker has taken it.

        The last points are then in the controller's pool, and the arm is on its way to them;
        leaving the stream's block waits until it stands. A path of fewer points than `low` begins
        at once, since no more of it come.

        Args:
            trajectory: the points. Shape (n, 6).
            times: not accepted: the controller plans the times, from speed and acceleration.

        Raises:
            ParameterError: the path is not allowed, or times were given; nothing was sent.
            SetPointTooFar: two successive points are too far apart; nothing was sent.
            StreamError: the stream has ended; the error says why.
        """
        if times is not None:
            raise ParameterError("times", times, "left out: the controller plans the times")
        async with self._ended_by_interrupts():
            points = await self._sampled(trajectory, None)
            await self._feed(points, self._feeding.capacity)
            await self._taken()
            # The first point is taken before it is compared with the arm's position.
            await super()._begin()

    async def _begin(self) -> None:
        """Do not wait: the worker takes the first points only when there are enough of them."""

    def _tail(self, op: Op | None) -> bytes:
        if not self._sent.extra:
            if op is not None:
                raise ParameterError("op", op, "left out, or the stream opened with operations")
            return b""
        made = wire_op("op", op, joint_motion=self._sent.in_joints)
        tail = element_tail("trackEnqueueOp", lambda q: rpc.PointOp(q, made))
        if len(tail) > _EXTRA:
            raise ParameterError("op", op, f"up to {_EXTRA} bytes on the wire, not {len(tail)}")
        return tail


class TrackStreams(StreamMaker):
    """Streams of the points of a path, through which the controller plans a motion.

        async with robot.track.stream("pose", speed=0.2, acc=0.5) as stream:
            for pose in path:
                await stream.send(pose)

    The worker keeps the pool between a low and a high mark. When the pool is empty, the controller
    comes to rest at the last point by itself; the worker restarts it when there are new points.

    Args:
        endpoint: the controller.
    """

    def stream(
        self,
        space: Literal["joints", "pose"],
        *,
        speed: Real,
        acc: Real,
        radius: Real = 0.005,
        tool: str = "",
        wobj: str = "",
        operations: bool = False,
        low: int = 50,
        high: int = 200,
        period: float = 0.02,
        hold: float = 5.0,
        ahead: int = 200,
        max_step: Real | tuple[float, float] | None = None,
        reach: Real | tuple[float, float] | None = None,
        options: WorkerOptions | None = None,
    ) -> TrackStream:
        """Follow the points of a path (trackEnqueue, trackJointMotion, trackCartMotion).

        Args:
            space: "joints" for joint positions, "pose" for poses of the tool.
            speed: largest joint speed, 0.000175 to 3.926 [rad/s], or speed of the tool, 0.00001
                to 5 [m/s].
            acc: largest joint acceleration, 0.000175 to 39.26 [rad/s²], or of the tool, from
                0.00001 [m/s²].
            radius: blend radius between the points of a Cartesian path [m].
            tool: name of the tool; empty: the one in use. Cartesian paths only.
            wobj: name of the work object; empty: the one in use. Cartesian paths only.
            operations: whether points have outputs to set (trackEnqueueOp).
            low: the worker fills the pool when it has fewer points; at least 10, as the manual
                advises.
            high: number of points to which the worker fills the pool, up to 1000.
            period: time between two polls of the pool [s].
            hold: time with an empty pool after which the stream ends [s].
            ahead: points queued in the worker before `send` waits.
            max_step: largest step between two points [rad], or [m, rad]; None: not checked.
            reach: largest distance of the arm from the first point [rad], or [m, rad]; None: 0.1
                rad, or 0.05 m and 0.1 rad.
            options: how the worker runs; None: in a separate process.

        Returns:
            The stream.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.12.
        """
        one_of("space", space, ("joints", "pose"))
        low, high = _COUNT("low", low), _COUNT("high", high)
        if low >= high:
            raise ParameterError("low", low, f"fewer than high, {high} points")
        extra = _EXTRA if ranges.FLAG("operations", operations) else 0
        joints = space == "joints"
        groups = 6 if joints else 2
        near = (0.1 if joints else (0.05, 0.1)) if reach is None else reach
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        if joints:
            speed_ = ranges.TRACK_JOINT_SPEED("speed", speed)
            acc_ = ranges.TRACK_JOINT_ACCELERATION("acc", acc)
            ranges.TRACK_RADIUS("radius", radius)
            tool_ = wobj_ = ""  # joints have none
            arguments: list[Any] = [speed_, acc_, False]
        else:
            speed_ = ranges.TRACK_SPEED("speed", speed)
            acc_ = ranges.TRACK_ACCELERATION("acc", acc)
            arguments = [speed_, acc_, False, tool_, wobj_, ranges.TRACK_RADIUS("radius", radius)]
        feeding = Feeding(
            rate=_RATE,
            hold=hold,
            ahead=max(_AHEAD("ahead", ahead), low),
            max_step=() if max_step is None else per_group("max_step", max_step, groups),
            reach=per_group("reach", near, groups),
        )
        sent = StreamSpec(
            name="track",
            in_joints=joints,
            limits=Limits((speed_,), (acc_,)),
            kind="pool",
            function="trackJointMotion" if joints else "trackCartMotion",
            arguments=arguments,
            low=low,
            high=high,
            period=ranges.TIMEOUT("period", period),
            extra=extra,
            ending=TRACK_POOL,
            tool=tool_,
            wobj=wobj_,
        )
        check = ranges.JOINTS if joints else ranges.POSE
        return TrackStream(self._endpoint, feeding, options, sent, check)
