"""Sections of the robot that have streams beside the functions of the wire."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

from aioduco.api import motion, ranges, realtime, track
from aioduco.errors import ParameterError, UnknownFunction
from aioduco.streaming.joint_trajectory import JointTrajectory, Tolerances
from aioduco.streaming.realtime import RealtimeStreams
from aioduco.streaming.servo import Servo
from aioduco.streaming.settings import Feeding, checked, per_group
from aioduco.streaming.speed import Speed
from aioduco.streaming.track import TrackStreams
from aioduco.streaming.trajectory import follow

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.streaming.endpoint import Endpoint
    from aioduco.streaming.joint_trajectory import Feedback, TrajectoryResult
    from aioduco.streaming.settings import LaneOptions
    from aioduco.supervision.supervisor import Supervisor

__all__ = ["Motion", "Realtime", "Servo", "Speed", "Through", "Track"]

Through = Literal["auto", "realtime", "servoj"]


class Realtime(realtime.Realtime, RealtimeStreams):
    """Realtime control (实时控制, manual 1.3.15): the arm follows a queue, point by point.

    `stream` keeps the queue filled, at its rate, from a process of its own; that is what
    programs use. The functions of the wire are there as well:

    The order that the manual asks for: empty the queue, put in the first points, the very first
    where the arm is, start the mode, and put in more before the queue runs dry. The controller
    takes a point each cycle, so that a program that calls function by function cannot keep up
    for long.

    As long as the mode is on, leaving the robot stops the arm and ends the mode; so does a stop.
    """

    def __init__(self, supervisor: Supervisor, endpoint: Endpoint) -> None:
        realtime.Realtime.__init__(self, supervisor)
        RealtimeStreams.__init__(self, endpoint)


class Track(track.Track, TrackStreams):
    """The track pool (轨迹池, manual 1.3.12): up to 1000 points, first in, first out.

    `stream` keeps the pool filled while the arm follows it. The functions of the wire are there
    as well:

        await robot.track.trackClearQueue()
        await robot.track.trackEnqueue([Joints(*q) for q in path])
        await robot.track.trackJointMotion(1.0, 2.0)

    Points are six numbers each; whether they are joints or poses is the business of the motion
    that follows them. This program remembers which of the two it put into the pool, and refuses
    a motion that would take one for the other.

    The manual asks for at least 10 points: when there is none left, the arm slows down and
    stands. Points that come after that may set it moving again.
    """

    def __init__(self, supervisor: Supervisor, endpoint: Endpoint) -> None:
        track.Track.__init__(self, supervisor)
        TrackStreams.__init__(self, endpoint)


class Motion(motion.Motion):
    """Motions of the arm (移动控制, manual 1.3.5).

    Each function checks its arguments and returns a motion as a value; nothing is sent before it
    is awaited, started, or run:

        await robot.motion.movej2(home, v=1.0, a=1.0)
        move = await robot.motion.movel(target, v=0.2, a=0.5).start()
        await robot.motion.run(approach, pass_by, retreat)

    Motions at a velocity, jogs and hand guiding go on until they are told to end: they are tied
    to a block, which ends them when it is left.
    """

    def __init__(self, supervisor: Supervisor, endpoint: Endpoint) -> None:
        super().__init__(supervisor)
        self._endpoint = endpoint

    async def follow_joint_trajectory(
        self,
        trajectory: JointTrajectory,
        *,
        v: float,
        a: float,
        tolerances: Tolerances | None = None,
        feedback: Callable[[Feedback], object] | None = None,
        through: Through = "auto",
        rate: float = 500.0,
        reach: float = 0.05,
        options: LaneOptions | None = None,
    ) -> TrajectoryResult:
        """Follow joint positions at given times to the end, and see the arm arrive.

        What ROS calls FollowJointTrajectory: tolerances on the way and at the goal, feedback on
        the way. Cancelling this brings the arm to rest on the path before it goes on.

        Args:
            trajectory: the joint positions and their times.
            v: largest speed of each joint, 0.000175 to 3.93 [rad/s]; a trajectory that is faster
                is refused.
            a: largest acceleration of each joint, from 0.000175 [rad/s²]; the corners of a
                trajectory that is sharper are rounded.
            tolerances: how far the arm may be from it; None: the defaults of `Tolerances`.
            feedback: called about 50 times a second with where the arm is on its way.
            through: "realtime" for the controller's realtime queue, "servoj" for one call per
                set-point, "auto" for the queue if this controller has one, else servoj.
            rate: set-points per second through servoj [Hz]; the queue has 1000.
            reach: how far each joint may be from the first point [rad].
            options: how the lane runs; None: in a process of its own.

        Returns:
            How it was followed, the arm being at the goal.

        Raises:
            ParameterError: the trajectory is too fast for `v`; nothing was sent.
            FirstPointTooFar: the arm is not where the trajectory begins; nothing was sent.
            PathToleranceViolated: the arm strayed from the path; it was brought to rest.
            GoalToleranceViolated: the arm did not come close enough to the last point in time.
            RobotStateError: something else moves the arm; nothing was sent.
            StreamError: the stream ended by something else; says why.

        Manual sections 1.3.5 and 1.3.15.
        """
        if not isinstance(trajectory, JointTrajectory):
            raise ParameterError("trajectory", trajectory, "a JointTrajectory")
        if through not in get_args(Through):
            raise ParameterError("through", through, f"one of {', '.join(get_args(Through))}")
        speed, acceleration = ranges.JOINT_SPEED("v", v), ranges.JOINT_ACCELERATION("a", a)
        if tolerances is not None and not isinstance(tolerances, Tolerances):
            raise ParameterError("tolerances", tolerances, "Tolerances, or None")
        if feedback is not None and not callable(feedback):
            raise ParameterError("feedback", feedback, "a function, or None")
        Feeding(rate=rate, reach=per_group("reach", reach, 6))  # checks both
        options = checked(options)
        self._supervisor.check_open("follow_joint_trajectory")
        queued = through == "realtime" or (through == "auto" and await self._has_queue())
        return await follow(
            self._endpoint,
            self._rpc.get_actual_joints_position,
            trajectory,
            realtime=queued,
            v=speed,
            a=acceleration,
            tolerances=tolerances,
            feedback=feedback,
            rate=rate,
            reach=reach,
            options=options,
        )

    async def _has_queue(self) -> bool:
        """Whether the controller has a realtime queue; older ones do not know the function."""
        try:
            await self._rpc.get_realtime_data_queue_size()
        except UnknownFunction:
            return False
        return True
