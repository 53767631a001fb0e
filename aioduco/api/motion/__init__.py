"""Motions (移动控制, manual 1.3.5)."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Literal, get_args

from aioduco.api.motion.curves import Curves
from aioduco.api.motion.jog import Jogging
from aioduco.api.motion.joints import JointMotions
from aioduco.api.motion.lines import Lines
from aioduco.api.motion.servo import ServoMotions
from aioduco.api.motion.teaching import Teaching
from aioduco.api.motion.trajectory import follow
from aioduco.api.motion.velocity import Velocity
from aioduco.api.section import done
from aioduco.errors import DucoError, ParameterError, UnknownFunction
from aioduco.models import ranges
from aioduco.models.rules import Integer
from aioduco.streaming.joint_trajectory import JointTrajectory, Tolerances
from aioduco.streaming.options import Feeding, checked, per_group
from aioduco.supervision.command import MotionCommand

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.models.enums import Outcome
    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.streaming.joint_trajectory import Feedback, TrajectoryResult
    from aioduco.streaming.options import LaneOptions
    from aioduco.supervision.supervisor import Supervisor
    from aioduco.supervision.task import Task

__all__ = ["Motion", "Through"]

Through = Literal["auto", "realtime", "servoj"]

_AHEAD = Integer(1, 1000, "motions", source="this package")


class Motion(JointMotions, Lines, Curves, Velocity, ServoMotions, Jogging, Teaching):
    """Motions of the arm (移动控制, manual 1.3.5).

    Each function checks its arguments and returns a motion as a value; nothing is sent before it
    is awaited, started, or run:

        await robot.motion.movej2(home, v=1.0, a=1.0)
        move = await robot.motion.movel(target, v=0.2, a=0.5).start()
        await robot.motion.run(approach, pass_by, retreat)

    Motions at a velocity, jogs and hand guiding go on until they are told to end: they are tied
    to a block, which ends them when it is left.
    """

    __slots__ = ("_endpoint",)

    def __init__(self, supervisor: Supervisor, endpoint: StreamEndpoint) -> None:
        super().__init__(supervisor)
        self._endpoint = endpoint

    async def set_blend_ahead(self, per: int, num: int = 1) -> None:
        """Set how early the controller reads the next motion, to blend into it (融合预读取).

        Args:
            per: percent of a motion after which the next is read, 0 to 100; usually 0 or 50.
            num: how many motions are read ahead if `per` is 0, 1 to 3: more for short motions
                that follow each other fast.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.5.
        """
        per_ = ranges.BLEND_AHEAD("per", per)
        num_ = ranges.BLEND_AHEAD_MOVES("num", num)
        done("set_blend_ahead", await self._rpc.set_blend_ahead(per_, num_))

    async def run(self, *motions: MotionCommand, ahead: int = 3) -> tuple[Outcome, ...]:
        """Send motions one after another, ahead of the arm, and wait for all of them.

        The controller can blend a motion into the next only if it has that one in time. So some
        are sent ahead; the others follow as the first ones end.

        Args:
            motions: in the order in which they are to be carried out.
            ahead: how many the controller has at most, the running one included, 1 to 1000.

        Returns:
            The outcome of each: finished or blended.

        Raises:
            TaskError: one did not succeed. Those after it were stopped, or not sent.
            ParameterError: something in `motions` is no motion, or `ahead` is out of range;
                nothing was sent.

        If this is cancelled, the arm is stopped.
        """
        for number, motion in enumerate(motions):
            if not isinstance(motion, MotionCommand):
                raise ParameterError(f"motions[{number}]", motion, "a motion")
            motion.hand_over()
        _AHEAD("ahead", ahead)
        tasks: deque[Task] = deque()
        outcomes: list[Outcome] = []
        try:
            for motion in motions:
                # Where the tool will be is not known before those in front of it have ended.
                while tasks and (len(tasks) >= ahead or motion.aimed):
                    outcomes.append(await tasks.popleft())
                tasks.append(await motion.start())
            while tasks:
                outcomes.append(await tasks.popleft())
        except DucoError:
            # One was refused, or failed: those that were sent must not go on without it.
            if tasks:
                await tasks[0].cancel()
            raise
        except BaseException:
            if tasks:
                await tasks[0].forsake()
            raise
        return tuple(outcomes)

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
            options: how the worker runs; None: in a process of its own.

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
