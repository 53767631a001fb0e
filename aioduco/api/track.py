"""The track pool (轨迹池, manual 1.3.12)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from aioduco._process.platform import boot_time
from aioduco._wire.rpc import WireCall, calls
from aioduco.api.points import points_with_outputs
from aioduco.api.section import Section, check_finished
from aioduco.api.streams.track import TrackStreams
from aioduco.errors import (
    ControllerError,
    DucoError,
    OutcomeUnknown,
    Refused,
    RobotStateError,
    TaskStopped,
    TrackPoolFull,
)
from aioduco.models import ranges
from aioduco.models.pose import Joints, JointsLike, Pose, PoseLike
from aioduco.supervision.gate import PermitEnding
from aioduco.supervision.motion_sources import TRACK_POOL
from aioduco.supervision.permits import asked_at_call

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from aioduco.models.op import PointOp
    from aioduco.models.rules import Real
    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.supervision.command import MotionCommand
    from aioduco.supervision.supervisor import Supervisor
    from aioduco.supervision.task_command import Command


_Kind: TypeAlias = type[Joints] | type[Pose]
_RULES = {Joints: ranges.TRACK_JOINTS, Pose: ranges.TRACK_POSES, None: ranges.TRACK_POINTS}


class Track(Section, TrackStreams):
    """The track pool (轨迹池, manual 1.3.12): up to 1000 points, first in, first out.

    `stream` keeps the pool filled while the arm follows it. The functions of the wire are available
    as well:

        await robot.track.trackClearQueue()
        await robot.track.trackEnqueue([Joints(*q) for q in path])
        await robot.track.trackJointMotion(1.0, 2.0)

    Points are six numbers each; the motion that follows them determines whether they are joints or
    poses. This package keeps a record of which of the two it put into the pool, and refuses a
    motion that would take one for the other.

    The manual asks for at least 10 points: when the pool is empty, the arm slows down and stands.
    Points that arrive after that may set it moving again.

    A stop leaves points in the pool, and the next motion through it would follow them first. So a
    stop by this program empties a pool into which it has put points. After any other stop, such as
    that of a lost heartbeat, the pool is emptied before this program's next motion or points; also
    if points were on their way when the arm was stopped. Leaving the robot's block empties it, too.

    A motion also follows points that another program has left in the pool, such as one that was
    killed: call `trackClearQueue` first.
    """

    def __init__(self, supervisor: Supervisor, endpoint: StreamEndpoint) -> None:
        Section.__init__(self, supervisor)
        TrackStreams.__init__(self, endpoint)
        self._modes = supervisor.stop_coordinator.modes
        self._streams = supervisor.stop_coordinator.streams
        #: kind of the points that this program put in since the pool was last empty; None: unknown
        self._last_kind: _Kind | None = None
        #: whether this program made the arm follow the pool: new points may then move the arm
        self._followed = False

    @asked_at_call
    async def trackEnqueue(  # noqa: N802  # the name on the wire
        self, points: Iterable[JointsLike | PoseLike] | NDArray[Any]
    ) -> None:
        """Put points into the pool (轨迹点入池).

        Args:
            points: 1 to 1000 points: all `Joints` [rad], or all `Pose` [m, rad], or six plain
                numbers each, which may be either. Shape (n, 6).

        Raises:
            ParameterError: a point is out of range; nothing was sent.
            RobotStateError: the pool holds points of the other kind, or those of a stream that is
                open; nothing was sent.
            TrackPoolFull: there is no room for them; `getQueueSize` returns the number of points in
                the pool.
            TaskStopped: the arm was stopped while they were on their way. The pool is emptied
                before anything else is sent through it.
            TaskError: they were not put in.
            EnvelopeViolated: `Joints` are beyond a limit of `robot.envelope`, or the arm that
                follows the pool is; nothing was sent.
            OutcomeUnknown: the answer was lost: empty the pool before you put in more. If the arm
                may follow the pool, it was stopped.

        Manual section 1.3.12.
        """
        given = ranges.TRACK_POINTS.listed("points", points)
        kind = _kind(given)
        points_ = _RULES[kind or self._kind]("points", given)
        joints = points_ if kind is Joints else ()
        await self._put(kind, calls.trackEnqueue(points_, True), joints)

    @asked_at_call
    async def trackEnqueueOp(self, points: Iterable[PointOp]) -> None:  # noqa: N802  # as above
        """Put points into the pool, each with outputs to set there (带 Op 的轨迹点入池).

        Args:
            points: 1 to 1000 points, all of them with `Joints`, or all with a `Pose`.

        Raises:
            ParameterError: a point is out of range; nothing was sent.
            RobotStateError: the pool holds points of the other kind, or those of a stream that is
                open; nothing was sent.
            TrackPoolFull: there is no room for them; `getQueueSize` returns the number of points in
                the pool.
            TaskStopped: the arm was stopped while they were on their way. The pool is emptied
                before anything else is sent through it.
            TaskError: they were not put in.
            EnvelopeViolated: `Joints` are beyond a limit of `robot.envelope`, or the arm that
                follows the pool is; nothing was sent.
            OutcomeUnknown: the answer was lost: empty the pool before you put in more. If the arm
                may follow the pool, it was stopped.

        Manual section 1.3.12.
        """
        given = points_with_outputs("points", points, ranges.TRACK_COUNT, Joints, Pose)
        points_ = [point.wire(f"points[{number}]") for number, point in enumerate(given)]
        kind = type(given[0].pos)
        joints = [point.pos for point in points_] if kind is Joints else ()
        await self._put(kind, calls.trackEnqueueOp(points_, True), joints)

    async def trackClearQueue(self) -> None:  # noqa: N802  # as above
        """Empty the pool (清空轨迹池).

        Raises:
            TaskError, Refused: it was not emptied.

        Manual section 1.3.12.
        """
        await self._finish(calls.trackClearQueue())
        self._emptied()

    async def getQueueSize(self) -> int:  # noqa: N802  # as above
        """Read the number of points that are left in the pool (轨迹池大小).

        Manual section 1.3.12.
        """
        size = await self._rpc.getQueueSize()
        if size == 0:
            self._emptied()
        return size

    def _emptied(self) -> None:
        if not self._streams:  # an open one may add more
            self._modes.over(TRACK_POOL)

    def trackJointMotion(self, speed: Real, acc: Real) -> MotionCommand:  # noqa: N802  # as above
        """Follow the points of the pool as joint angles (关节轨迹池跟随), until none is left.

        Args:
            speed: highest speed of the leading joint, 0.01·π/180 to 1.25·π [rad/s].
            acc: its highest acceleration, 0.01·π/180 to 12.5·π [rad/s²].

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.
            RobotStateError: the points that this program put into the pool are poses.

        Manual section 1.3.12.
        """
        speed_ = ranges.TRACK_JOINT_SPEED("speed", speed)
        acc_ = ranges.TRACK_JOINT_ACCELERATION("acc", acc)
        return self._following(calls.trackJointMotion(speed_, acc_, False), Joints)

    def trackCartMotion(  # noqa: N802  # as above
        self,
        speed: Real,
        acc: Real,
        *,
        wobj: str = "",
        tool: str = "",
        radius: Real = 0.005,
    ) -> MotionCommand:
        """Follow the points of the pool as poses (笛卡尔轨迹池跟随), until none is left.

        Args:
            speed: highest speed of the tool, 0.00001 to 5 [m/s].
            acc: its highest acceleration, from 0.00001 [m/s²].
            wobj: name of the work object; empty for the one in use.
            tool: name of the tool; empty for the one in use.
            radius: blend radius at the points, from 0 [m]. It is not in the manual; 0.005 is the
                vendor's default.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.
            RobotStateError: the points that this program put into the pool are joint angles.

        Manual section 1.3.12.
        """
        speed_ = ranges.TRACK_SPEED("speed", speed)
        acc_ = ranges.TRACK_ACCELERATION("acc", acc)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        radius_ = ranges.TRACK_RADIUS("radius", radius)
        call = calls.trackCartMotion(speed_, acc_, False, tool_, wobj_, radius_)
        return self._following(call, Pose)

    async def _put(
        self, kind: _Kind | None, call: WireCall[int], joints: Sequence[Sequence[float]] = ()
    ) -> None:
        """Put points into the pool, after a check against the envelope.

        If the arm follows the pool, they move the arm.
        """
        # beside a stream into the pool they are refused, as motions are
        moves = self._followed or (bool(self._streams) and TRACK_POOL in self._modes)
        if moves:
            self._supervisor.check_permitted(call.name)
        await self._modes.leave_overdue(call.name)
        await self._supervisor.envelope.admit(call.name, joints, moves=moves)
        # after all that is awaited: another task may have put points in meanwhile
        held = self._kind
        if kind is not None and held is not None and held is not kind:
            raise RobotStateError(
                f"points of type {kind.__name__} were not sent: this program has put points of "
                f"type {held.__name__} into the pool; call trackClearQueue first"
            )
        self._last_kind = kind or held
        gate = self._supervisor.permits.gate
        permit = gate.ask(call.name, boot_time(), moves=False)
        # Before the call is sent, since its answer may be lost.
        filled = self._modes.enter(TRACK_POOL)
        try:
            # The arm may follow the pool, without a task that reports the motion.
            answer = await (self._feed(call, TRACK_POOL) if moves else self._rpc.send(call))
            _taken(call.name, answer)
        except (OutcomeUnknown, Refused, ControllerError):
            raise  # some may be in the pool
        except DucoError:
            self._last_kind = held
            if not filled:
                self._modes.over(TRACK_POOL)
            raise
        finally:
            # A stop that came meanwhile may have emptied the pool before they were put in.
            stopped = gate.ending(permit) not in (None, PermitEnding.PAUSED)
            if stopped:
                self._modes.enter(TRACK_POOL)
                self._modes.overdue(TRACK_POOL)
        if stopped:
            raise TaskStopped(
                *(call.name, None),
                "was stopped: the points were on their way, and the pool is emptied before "
                "anything else is sent through it",
            )

    @property
    def _kind(self) -> _Kind | None:
        """Kind of the points that this program has put into the pool; None: unknown."""
        return self._last_kind if TRACK_POOL in self._modes else None

    def _following(self, call: WireCall[int], kind: _Kind) -> MotionCommand:
        """Make a motion through the pool, and check the kind of its points.

        It is checked once more when the motion is sent: others may have been put in since.
        """

        async def checked(command: Command) -> tuple[Any, ...]:
            self._check_kind(command.name, kind)
            return command.args

        self._check_kind(call.name, kind)
        self._followed = True
        return self._motion(call, aim=checked)

    def _check_kind(self, function: str, kind: _Kind) -> None:
        """Check the kind of the points, before the arm follows the pool."""
        held = self._kind
        if held is not None and held is not kind:
            raise RobotStateError(
                f"{function} was not sent: this program has put points of type "
                f"{held.__name__} into the pool, and it would take them for {kind.__name__}"
            )


def _kind(points: Sequence[object]) -> _Kind | None:
    """Return the type of the points; None if they are plain numbers."""
    for kind in (Joints, Pose):
        if any(isinstance(point, kind) for point in points):
            return kind
    return None


def _taken(function: str, answer: int) -> None:
    if answer == -1:
        raise TrackPoolFull(function, answer)
    check_finished(function, answer)
