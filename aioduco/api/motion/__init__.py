"""Motions (移动控制, manual 1.3.5)."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, Literal, Protocol, get_args

from aioduco._wire.rpc import calls
from aioduco.api.motion.curves import Curves
from aioduco.api.motion.jog import Jogging
from aioduco.api.motion.joints import JointMotions
from aioduco.api.motion.lines import Lines
from aioduco.api.motion.servo import ServoMotions
from aioduco.api.motion.switch import TrajectorySwitch
from aioduco.api.motion.teaching import Teaching
from aioduco.api.motion.trajectory import follow
from aioduco.api.motion.velocity import Velocity
from aioduco.api.streams.arguments import per_group
from aioduco.errors import ParameterError, StopUnconfirmed, UnknownFunction
from aioduco.models import ranges
from aioduco.models.rules import Integer, Real
from aioduco.models.samples import joints as joints_of
from aioduco.models.words import one_of
from aioduco.streaming.joint_trajectory import (
    JointTrajectory,
    Through,
    Tolerances,
    check_following,
)
from aioduco.streaming.shared.options import Feeding, WorkerOptions, checked
from aioduco.supervision.command import MotionCommand, check_motions
from aioduco.supervision.envelope_keeper import fits
from aioduco.supervision.motion_path import MotionPath
from aioduco.supervision.permits import asked_at_call

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.models.enums import Outcome
    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.streaming.joint_trajectory import Feedback, TrajectoryResult
    from aioduco.supervision.supervisor import Supervisor

__all__ = ["Motion", "PlannedMotion", "Through"]

_AHEAD = Integer(1, 1000, "motions", source="this package")


class PlannedMotion(Protocol):
    """A motion for `execute`: a `Plan` of `aioduco.planning`, a `RecordedPath` of a recording."""

    @property
    def arm(self) -> Any:
        """The arm that it is for; a `RecordedPath` has its name alone, which is not checked."""
        ...

    async def run_on(
        self, motion: Any, read_joints: Any, **options: Any
    ) -> TrajectoryResult | None:
        """Carry it out with a robot's motions."""
        ...


class Motion(JointMotions, Lines, Curves, Velocity, ServoMotions, Jogging, Teaching):
    """Motions of the arm (移动控制, manual 1.3.5).

    Each function checks its arguments and returns a motion as a value; nothing is sent before it
    is awaited, started, or run:

        await robot.motion.movej2(home, v=1.0, a=1.0)
        move = await robot.motion.movel(target, v=0.2, a=0.5).start()
        await robot.motion.run(approach, pass_by, retreat)

    A motion with a blend radius `r` blends only into one that the controller receives in time: see
    `run` and `path`.

    Motions at a velocity, jogs and hand guiding run until a command ends them. Use them in a
    block: leaving it ends them.
    """

    __slots__ = ("_endpoint",)

    def __init__(self, supervisor: Supervisor, endpoint: StreamEndpoint) -> None:
        super().__init__(supervisor)
        self._endpoint = endpoint

    async def set_blend_ahead(self, per: int, num: int = 1) -> None:
        """Set how early the controller reads the next motion, to blend into it (融合预读取).

        It applies to programs of the controller and to blocking calls, such as those of
        `robot.blocking`: the controller has the motions that `run` and `path` send ahead as soon as
        they arrive.

        Args:
            per: share of a motion after which the next one is read, 0 to 100 [%]; usually 0 or 50.
            num: number of motions that are read ahead if `per` is 0, 1 to 3: more for short motions
                in fast succession.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.5.
        """
        per_ = ranges.BLEND_AHEAD("per", per)
        num_ = ranges.BLEND_AHEAD_MOVES("num", num)
        await self._finish(calls.set_blend_ahead(per_, num_))

    @asked_at_call
    async def run(self, *motions: MotionCommand, ahead: int = 3) -> tuple[Outcome, ...]:
        """Send motions one after another, ahead of the arm, and wait for all of them.

        The controller can blend a motion into the next one only if it receives that one in time.
        So the first `ahead` motions are sent at once, and one more each time that a motion ends.
        `path` does the same for motions that are not all known beforehand.

        Args:
            motions: the motions, in the order in which they are to be carried out.
            ahead: maximum number of motions in the controller, the running one included, 1 to
                1000.

        Returns:
            The outcome of each: finished or blended.

        Raises:
            TaskError: a motion did not succeed. Those after it were stopped, or not sent.
            ParameterError: an element of `motions` is not a motion, or one of another robot, or
                `ahead` is out of range; nothing was sent.
            MotionCarriedOut: an element of `motions` is the outcome of a motion. The motion was
                carried out instead of only made: the arm has moved.

        If this is cancelled, the arm is stopped.
        """
        check_motions(motions, MotionCommand, "Leave out the `await` of motions that are to be run")
        for motion in motions:
            motion.mark_used()
        for number, motion in enumerate(motions):
            if not motion.moves_arm_of(self._supervisor.dispatcher):
                raise ParameterError(f"motions[{number}]", motion, "a motion of this robot")
        async with self.path(ahead=ahead) as path:
            for motion in motions:
                await path.add(motion)
        return path.outcomes

    def path(self, *, ahead: int = 2) -> MotionPath:
        """Make a path of motions that blend, for a program that sends them one by one.

            async with robot.motion.path() as path:
                async for corner in corners:
                    await path.add(robot.motion.movel(corner, v=0.2, a=0.5, r=mm(30)))

        A motion that is awaited alone has no successor until it has ended, so it never blends.
        Here `add` returns while the arm is still moving, as the manual's blocking calls do at the
        beginning of a blend. When the block is left, all motions have ended.

        Args:
            ahead: maximum number of motions in the controller, the running one included, 1 to
                1000. With 1 nothing blends.

        Returns:
            The path; nothing is sent before its block is entered.

        Raises:
            ParameterError: `ahead` is out of range.

        Manual section 1.3.5, blend radius.
        """
        supervisor = self._supervisor
        return MotionPath(_AHEAD("ahead", ahead), supervisor.permits, supervisor.dispatcher)

    @asked_at_call
    async def follow_joint_trajectory(
        self,
        trajectory: JointTrajectory,
        *,
        v: Real,
        a: Real,
        tolerances: Tolerances | None = None,
        feedback: Callable[[Feedback], object] | None = None,
        through: Through = "auto",
        rate: float = 500.0,
        reach: float = 0.05,
        switch: TrajectorySwitch | None = None,
        options: WorkerOptions | None = None,
    ) -> TrajectoryResult:
        """Follow joint positions at given times to the end, and wait until the arm has arrived.

        This is ROS's FollowJointTrajectory: tolerances on the path and at the goal, feedback during
        the motion. Cancelling this brings the arm to rest on the path before control returns.

        Args:
            trajectory: the joint positions and their times.
            v: largest speed of each joint, 0.000175 to 3.926 [rad/s]; a trajectory that is faster
                is refused.
            a: largest acceleration of each joint, from 0.000175 [rad/s²]; sharper corners of the
                trajectory are rounded.
            tolerances: largest distances of the arm from the trajectory; None: the defaults of
                `Tolerances`.
            feedback: callback that gets a `Feedback` about 50 times a second.
            through: "realtime" for the controller's realtime queue, "servoj" for one call per
                set-point, "auto" for the queue if this controller has one, else servoj.
            rate: set-points per second through servoj [Hz]; the queue has 1000.
            reach: largest distance of each joint from the first point at the start [rad].
            switch: leads the arm into another trajectory on the way. Then set-points are sent 0.4 s
                ahead; without it, as far ahead as they fit.
            options: how the worker runs; None: in a process of its own.

        Returns:
            How the trajectory was followed; the arm is at the goal.

        Raises:
            ParameterError: the trajectory is too fast for `v`, or does not end at rest; nothing
                was sent.
            FirstPointTooFar: the arm is not where the trajectory begins; nothing was sent.
            PathToleranceViolated: the arm strayed from the path; it was brought to rest.
            GoalToleranceViolated: the arm did not come close enough to the last point in time.
            RobotStateError: something else moves the arm; nothing was sent.
            StreamError: the stream ended for another reason; the error says which.

        Manual sections 1.3.5 and 1.3.15.
        """
        if not isinstance(trajectory, JointTrajectory):
            raise ParameterError("trajectory", trajectory, "a JointTrajectory")
        check_following(through, tolerances, feedback)
        speed, acceleration = ranges.JOINT_SPEED("v", v), ranges.JOINT_ACCELERATION("a", a)
        if switch is not None and not isinstance(switch, TrajectorySwitch):
            raise ParameterError("switch", switch, "a TrajectorySwitch, or None")
        Feeding(rate=rate, reach=per_group("reach", reach, 6))  # checks both
        options = checked(options)
        self._supervisor.check_permitted("follow_joint_trajectory")
        queued = through == "realtime" or (through == "auto" and await self._has_queue())
        return await follow(
            self._endpoint,
            self._joints,
            trajectory,
            realtime=queued,
            v=speed,
            a=acceleration,
            tolerances=tolerances,
            feedback=feedback,
            rate=rate,
            reach=reach,
            switch=switch,
            options=options,
        )

    @asked_at_call
    async def execute(
        self,
        plan: PlannedMotion,
        *,
        watch: Any = None,
        planner: Any = None,
        through: Through | Literal["blended"] = "auto",
        tolerances: Tolerances | None = None,
        feedback: Callable[[Feedback], object] | None = None,
        options: WorkerOptions | None = None,
    ) -> TrajectoryResult | None:
        """Carry out a plan of `aioduco.planning` (执行规划), supervised to its end.

        Cancelling this brings the arm to rest on the plan's path before control returns.

        Args:
            plan: the plan; its first point must be the arm's position, to 0.01 rad for each joint.
            watch: the `Scene` that the plan was made in. Each time that it changes during the
                motion, the rest of the path is checked; if that is not free any more, the arm is
                brought to rest on the path.
            planner: a `Planner`, only with `watch`: it then plans a path from there to the same
                end, which the arm follows instead: upright if the plan is, and with no joint
                faster than the plan's fastest.
            through: "realtime" for the controller's realtime queue, "servoj" for one call per
                set-point, "auto" for the queue if this controller has one, else servoj; "blended"
                for joint motions of the controller that blend, nowhere faster than the plan,
                and without `watch`, `tolerances`, `feedback` and `options`.
            tolerances: largest distances of the arm from the plan; None: the defaults of
                `Tolerances`.
            feedback: callback that gets a `Feedback` about 50 times a second.
            options: how the worker runs; None: in a process of its own.

        Returns:
            How the plan was followed; None for blended motions.

        Raises:
            ParameterError: an argument is not allowed, or the plan is for another arm: the flange
                is not where that one has it. Nothing was sent.
            FirstPointTooFar: the arm is not where the plan begins; nothing was sent.
            PlanObstructed: the path is not free in the scene that is watched; the arm did not
                start, or was brought to rest on the path.
            PlanningError: no path around the change was found; the arm stands.
            PathToleranceViolated: the arm strayed from the path; it was brought to rest.
            GoalToleranceViolated: the arm did not come close enough to the end in time.
            RobotStateError: something else moves the arm; nothing was sent.
            StreamError: the stream ended for another reason; the error says which.
            TaskError: a blended motion did not succeed.
        """
        if not (callable(getattr(plan, "run_on", None)) and hasattr(plan, "arm")):
            raise ParameterError("plan", plan, "a plan of aioduco.planning")
        one_of("through", through, (*get_args(Through), "blended"))
        self._supervisor.check_permitted("execute")
        await self._require_arm(plan)
        return await plan.run_on(
            self,
            self._joints_at_rest,
            watch=watch,
            planner=planner,
            through=through,
            tolerances=tolerances,
            feedback=feedback,
            options=options,
        )

    async def _require_arm(self, plan: PlannedMotion) -> None:
        """Check that a plan was made for the arm that is there: it may be free for that one alone.

        Raises:
            ParameterError: it was made for another one; nothing was sent.
        """
        if not hasattr(plan.arm, "fits"):
            return
        await self._joints_at_rest()
        if not await fits(self._rpc, plan.arm.fits):
            expected = "one for the arm that is there, whose flange is not where this one's has it"
            raise ParameterError("plan", plan, expected)

    async def _joints_at_rest(self) -> Sequence[float]:
        """Read the joints once the arm stands: after a stop it may still be coming to rest."""
        # if the arm still moves, the plan is refused when it is sent
        with contextlib.suppress(StopUnconfirmed):
            await self._supervisor.stop_coordinator.standstill()
        return await self._joints()

    async def _joints(self) -> Sequence[float]:
        """Read where the arm is [rad].

        Raises:
            StaleState: the controller answers fewer than six angles, or some that are not finite.
        """
        return joints_of(await self._rpc.get_actual_joints_position())

    async def _has_queue(self) -> bool:
        """Whether the controller has a realtime queue; older controllers lack the function."""
        try:
            await self._rpc.get_realtime_data_queue_size()
        except UnknownFunction:
            return False
        return True
