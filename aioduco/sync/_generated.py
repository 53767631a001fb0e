"""The sections of the robot for programs that wait.

Generated from `aioduco/api/` and `aioduco/robot.py` by `idl/generate_sync.py`; change those, not
this.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.models.jog import JogDirections
from aioduco.models.names import ManualNames
from aioduco.sync._streams import OffsetStream, Stream, TrackStream
from aioduco.sync._tasks import MotionPath, awaitables, moves

if TYPE_CHECKING:
    from aioduco import robot as aio_robot
    from aioduco.api.bus import Bus as AioBus
    from aioduco.api.bus.can import CanFrame
    from aioduco.api.compound import Compound as AioCompound
    from aioduco.api.external_axes import ExternalAxes as AioExternalAxes
    from aioduco.api.force import Force as AioForce
    from aioduco.api.frames import Frames as AioFrames
    from aioduco.api.io import IO as AioIO
    from aioduco.api.kinematics import Kinematics as AioKinematics, Reachability
    from aioduco.api.log import Log as AioLog
    from aioduco.api.modbus import Modbus as AioModbus
    from aioduco.api.motion import Motion as AioMotion, PlannedMotion, Through
    from aioduco.api.optimization import Optimization as AioOptimization
    from aioduco.api.program import Program as AioProgram
    from aioduco.api.realtime import Realtime as AioRealtime
    from aioduco.api.registers import Registers as AioRegisters
    from aioduco.api.service import Service as AioService
    from aioduco.api.settings import Settings as AioSettings
    from aioduco.api.state import State as AioState
    from aioduco.api.system import System as AioSystem
    from aioduco.api.track import Track as AioTrack
    from aioduco.api.version import RobotType, Version as AioVersion
    from aioduco.models.enums import FileKind, OperationMode, Outcome, OutputMode, TaskState
    from aioduco.models.external_axis import ExternalAxis, ExternalAxisScheme, ExternalAxisState
    from aioduco.models.force import ForceFrame, ForceLogic, GuardedForce
    from aioduco.models.jog import Jog, JogFrame
    from aioduco.models.load import Load
    from aioduco.models.op import Op, PointOp
    from aioduco.models.pose import Joints, JointsLike, Pose, PoseLike
    from aioduco.models.realtime import RealtimeMode, RealtimePoint
    from aioduco.models.rules import BytesLike, FlagsLike, Real, VectorLike, Whole, WholesLike
    from aioduco.models.state import IOStatus, RobotStates, RobotStatus, Vector
    from aioduco.models.version import ControllerVersion
    from aioduco.models.weave import WeavePlane, WeaveShape
    from aioduco.streaming.directions import MotionFrame
    from aioduco.streaming.gains import ServoGains
    from aioduco.streaming.joint_trajectory import (
        Feedback,
        JointTrajectory,
        Tolerances,
        TrajectoryResult,
    )
    from aioduco.streaming.options import FeedingOptions, LaneOptions, PacedOptions, ServoOptions
    from aioduco.streaming.servo import Servo as AioServo
    from aioduco.streaming.speed import Speed as AioSpeed
    from aioduco.supervision import command as aio_command
    from aioduco.supervision.state_feed import Snapshot
    from aioduco.sync._runner import Runner
    from aioduco.sync._tasks import MotionCommand
    from collections.abc import Callable, Iterable, Sequence
    from numpy.typing import NDArray
    from typing import Literal, Unpack


class _Section(ManualNames):
    """A section of the manual: functions of one robot."""

    __slots__ = ("_runner", "_section")

    def __init__(self, runner: Runner, section: Any) -> None:
        self._runner = runner
        self._section = section

    def __repr__(self) -> str:
        return repr(self._section)


class System(_Section):
    """Power, brakes and the operation mode (系统控制, manual 1.3.2).

    Each function returns when the controller has finished. An interrupt while it waits cancels the
    waiting, not the controller's action. `Robot.bring_up` calls the functions that are needed
    before a motion, in the right order.
    """

    __slots__ = ()
    _section: AioSystem

    def power_on(self, *, timeout: float = 30.0) -> None:
        """Power the arm up (机器人上电).

        Args:
            timeout: seconds within which the controller must have finished.

        Raises:
            TaskError: it was not done; TaskUnknown if it took too long.

        Manual section 1.3.2.
        """
        self._runner.call(self._section.power_on(timeout=timeout))

    def power_off(self, *, timeout: float = 30.0) -> None:
        """Power the arm down (机器人下电); the brakes close.

        Args:
            timeout: seconds within which the controller must have finished.

        Raises:
            TaskError: it was not done; TaskUnknown if it took too long.

        Manual section 1.3.2.
        """
        self._runner.call(self._section.power_off(timeout=timeout))

    def enable(self, *, timeout: float = 30.0) -> None:
        """Enable the joints (机器人上使能); the brakes open.

        Args:
            timeout: seconds within which the controller must have finished.

        Raises:
            TaskError: it was not done; TaskUnknown if it took too long.

        Manual section 1.3.2.
        """
        self._runner.call(self._section.enable(timeout=timeout))

    def disable(self, *, timeout: float = 30.0) -> None:
        """Disable the joints (机器人下使能); the brakes close.

        Args:
            timeout: seconds within which the controller must have finished.

        Raises:
            TaskError: it was not done; TaskUnknown if it took too long.

        Manual section 1.3.2.
        """
        self._runner.call(self._section.disable(timeout=timeout))

    def shutdown(self) -> None:
        """Switch the controller off (机器人关机). Every connection ends soon after.

        Raises:
            Refused: the controller refuses in its present state.
            OutcomeUnknown: the connection ended before the answer came.

        Manual section 1.3.2.
        """
        self._runner.call(self._section.shutdown())

    def restart(self) -> None:
        """Start the controller anew (机器人重启). Every connection ends soon after.

        Raises:
            Refused: the controller refuses in its present state.
            OutcomeUnknown: the connection ended before the answer came.

        Manual section 1.3.2.
        """
        self._runner.call(self._section.restart())

    def switch_mode(self, mode: OperationMode | int) -> None:
        """Switch between manual and automatic mode (手自动模式切换).

        This works only if the safety settings do not assign the mode to an input. A switch may
        leave the program paused; `Robot.stop` ends the pause.

        Args:
            mode: OperationMode.MANUAL (0) or OperationMode.AUTO (1).

        Raises:
            ParameterError: the mode is another one.
            TaskError: the controller did not switch.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.switch_mode(mode))


class Motion(_Section):
    """Motions of the arm (移动控制, manual 1.3.5).

    Each function checks its arguments, sends the motion, and returns when it has ended; `.start`
    returns its task as soon as the controller has accepted it; `.prepare` sends nothing:

        robot.motion.movej2(home, v=1.0, a=1.0)
        move = robot.motion.movel.start(target, v=0.2, a=0.5)
        robot.motion.run(approach, pass_by, retreat)         # made by .prepare, blended

    A motion with a blend radius `r` blends only into one that the controller has in time: see
    `run` and `path`.

    Motions at a velocity, jogs and hand guiding go on until their time is over or they are told to
    end: they are tied to a block, which ends them when it is left:

        with robot.motion.speedl.start([0, 0, -0.02, 0, 0, 0], a=0.5, time=5.0):
            ...
    """

    __slots__ = ()
    _section: AioMotion

    def set_blend_ahead(self, per: int, num: int = 1) -> None:
        """Set how early the controller reads the next motion, to blend into it (融合预读取).

        It applies to programs of the controller and to blocking calls, which this package does not
        make: the controller has the motions that `run` and `path` send ahead as soon as they
        arrive.

        Args:
            per: share of a motion after which the next one is read, 0 to 100 [%]; usually 0 or 50.
            num: number of motions that are read ahead if `per` is 0, 1 to 3: more for short motions
                in fast succession.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.5.
        """
        self._runner.call(self._section.set_blend_ahead(per, num))

    def run(self, *motions: MotionCommand, ahead: int = 3) -> tuple[Outcome, ...]:
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
            ParameterError: an element of `motions` is not a motion, or `ahead` is out of range;
                nothing was sent.
            MotionCarriedOut: an element of `motions` is the outcome of a motion. The motion was
                carried out instead of only made: the arm has moved.

        If this is interrupted, the arm is stopped.
        """
        return self._runner.call(self._section.run(*awaitables(motions), ahead=ahead))

    def path(self, *, ahead: int = 2) -> MotionPath:
        """Make a path of motions that blend, for a program that sends them one by one.

            with robot.motion.path() as path:
                for corner in corners:
                    path.add(robot.motion.movel.prepare(corner, v=0.2, a=0.5, r=mm(30)))

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
        made = self._section.path(ahead=ahead)
        return MotionPath(self._runner, made)

    def follow_joint_trajectory(
        self,
        trajectory: JointTrajectory,
        *,
        v: float,
        a: float,
        tolerances: Tolerances | None = None,
        feedback: Callable[[Feedback], object] | None = None,
        through: Through = 'auto',
        rate: float = 500.0,
        reach: float = 0.05,
        options: LaneOptions | None = None,
    ) -> TrajectoryResult:
        """Follow joint positions at given times to the end, and wait until the arm has arrived.

        This is ROS's FollowJointTrajectory: tolerances on the path and at the goal, feedback during
        the motion. An interrupt brings the arm to rest on the path before control returns.

        Args:
            trajectory: the joint positions and their times.
            v: largest speed of each joint, 0.000175 to 3.93 [rad/s]; a trajectory that is faster
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
            options: how the worker runs; None: in a process of its own.

        Returns:
            How the trajectory was followed; the arm is at the goal.

        Raises:
            ParameterError: the trajectory is too fast for `v`; nothing was sent.
            FirstPointTooFar: the arm is not where the trajectory begins; nothing was sent.
            PathToleranceViolated: the arm strayed from the path; it was brought to rest.
            GoalToleranceViolated: the arm did not come close enough to the last point in time.
            RobotStateError: something else moves the arm; nothing was sent.
            StreamError: the stream ended for another reason; the error says which.

        Manual sections 1.3.5 and 1.3.15.
        """
        work = self._section.follow_joint_trajectory(
            trajectory, v=v, a=a, tolerances=tolerances, feedback=feedback, through=through,
            rate=rate, reach=reach, options=options
        )
        return self._runner.call(work)

    def execute(
        self,
        plan: PlannedMotion,
        *,
        watch: Any = None,
        planner: Any = None,
        through: Through | Literal['blended'] = 'auto',
        tolerances: Tolerances | None = None,
        feedback: Callable[[Feedback], object] | None = None,
        options: LaneOptions | None = None,
    ) -> TrajectoryResult | None:
        """Carry out a plan of `aioduco.planning` (执行规划), supervised to its end.

        An interrupt brings the arm to rest on the plan's path before control returns.

        Args:
            plan: the plan; its first point must be the arm's position, to 0.01 rad for each joint.
            watch: the `Scene` that the plan was made in. Each time that it changes during the
                motion, the rest of the path is checked; if that is not free any more, the arm is
                brought to rest on the path.
            planner: a `Planner`, only with `watch`: it then plans a path from there to the same
                end, which the arm follows instead.
            through: "realtime" for the controller's realtime queue, "servoj" for one call per
                set-point, "auto" for the queue if this controller has one, else servoj; "blended"
                for joint motions of the controller that blend, as fast as it makes them within
                the plan's limits, and without `watch`, `tolerances`, `feedback` and `options`.
            tolerances: largest distances of the arm from the plan; None: the defaults of
                `Tolerances`.
            feedback: callback that gets a `Feedback` about 50 times a second.
            options: how the worker runs; None: in a process of its own.

        Returns:
            How the plan was followed; None for blended motions.

        Raises:
            FirstPointTooFar: the arm is not where the plan begins; nothing was sent.
            PlanObstructed: the path is not free in the scene that is watched; the arm did not
                start, or was brought to rest on the path.
            PlanningError: no path around the change was found; the arm stands.
            ParameterError: an argument is not allowed; nothing was sent.
            PathToleranceViolated: the arm strayed from the path; it was brought to rest.
            GoalToleranceViolated: the arm did not come close enough to the end in time.
            RobotStateError: something else moves the arm; nothing was sent.
            StreamError: the stream ended for another reason; the error says which.
            TaskError: a blended motion did not succeed.
        """
        work = self._section.execute(
            plan, watch=watch, planner=planner, through=through, tolerances=tolerances,
            feedback=feedback, options=options
        )
        return self._runner.call(work)

    @moves
    def movej2(
        self,
        joints: JointsLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move to joint angles, all joints together (关节运动).

        Args:
            joints: target, six angles in [-2π, 2π] [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            op: outputs set on the way; triggers by distance have no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.movej2(joints, v, a, r=r, op=op, def_acc=def_acc)

    @moves
    def movej_pose2(
        self,
        pose: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool to a pose, all joints together, not along a line (关节运动到位姿).

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way; triggers by distance have no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.movej_pose2(
            pose, v, a, r=r, q_near=q_near, tool=tool, wobj=wobj, op=op, def_acc=def_acc
        )

    @moves
    def movej(
        self,
        joints: JointsLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move to joint angles at a speed in percent (关节运动). `movej2` takes it in rad/s.

        Args:
            joints: target, six angles in [-2π, 2π] [rad].
            v: highest joint speed in percent of what the arm can do, above 0, up to 100.
            a: highest joint acceleration in percent of what the arm can do, above 0, up to 100.
            r: blend radius into the next motion [m]; 0 to stop at the end.
            op: outputs set on the way; triggers by distance have no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Warns:
            UnitWarning: `v` looks like rad/s: it has a decimal point, and is at most 3.93.

        Not in the manual. The wire of 3.8 has it, and it is much used; the unit, percent, is what
        its users report.
        """
        return self._section.movej(joints, v, a, r=r, op=op, def_acc=def_acc)

    @moves
    def movej_pose(
        self,
        pose: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool to a pose by the joints at a speed in percent (关节运动到位姿).

        `movej_pose2` takes the speed in rad/s.

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest joint speed in percent of what the arm can do, above 0, up to 100.
            a: highest joint acceleration in percent of what the arm can do, above 0, up to 100.
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way; triggers by distance have no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Warns:
            UnitWarning: `v` looks like rad/s: it has a decimal point, and is at most 3.93.

        Not in the manual. The wire of 3.8 has it, and it is much used; the unit, percent, is what
        its users report.
        """
        return self._section.movej_pose(
            pose, v, a, r=r, q_near=q_near, tool=tool, wobj=wobj, op=op, def_acc=def_acc
        )

    @moves
    def movel(
        self,
        pose: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool to a pose along a line (直线运动). The manual prints its name as move1.

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles near the target [rad], to check its branch; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.movel(
            pose, v, a, r=r, q_near=q_near, tool=tool, wobj=wobj, op=op, def_acc=def_acc
        )

    @moves
    def tcp_move(
        self,
        offset: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        tool: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool by an offset in its own frame, along a line (沿工具坐标系直线移动).

        Args:
            offset: translation x, y, z [m] and rotation rx, ry, rz [rad], in the tool's frame.
            v: highest speed of the tool, 0.01 to 5 [m/s]; an offset without translation turns at
                a speed scaled from it.
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            tool: name of the tool; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.tcp_move(offset, v, a, r=r, tool=tool, op=op, def_acc=def_acc)

    @moves
    def tcp_move_2p(
        self,
        p1: PoseLike,
        p2: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool along a line by the offset between two poses, in the tool's frame.

        沿工具坐标系直线移动两点之差: the target is the present pose · p1⁻¹ · p2.

        Args:
            p1: the pose from which the offset is taken; x, y, z [m], rx, ry, rz [rad].
            p2: the pose to which the offset is taken; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s]; an offset without translation turns at
                a speed scaled from it.
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.tcp_move_2p(
            p1, p2, v, a, r=r, tool=tool, wobj=wobj, op=op, def_acc=def_acc
        )

    @moves
    def wobj_move(
        self,
        offset: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool by an offset in the work object's frame (沿工件坐标系直线移动), in a line.

        Args:
            offset: translation x, y, z [m] and rotation rx, ry, rz [rad], in the work object's
                frame.
            v: highest speed of the tool, 0.01 to 5 [m/s]; an offset without translation turns at
                a speed scaled from it.
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.wobj_move(offset, v, a, r=r, wobj=wobj, op=op, def_acc=def_acc)

    @moves
    def wobj_move_2p(
        self,
        p1: PoseLike,
        p2: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool along a line by the offset between two poses, in the work object's frame.

        沿工件坐标系直线移动两点之差: the offset from p1 to p2 as it is in the work object's frame.

        Args:
            p1: the pose from which the offset is taken; x, y, z [m], rx, ry, rz [rad].
            p2: the pose to which the offset is taken; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s]; an offset without translation turns at
                a speed scaled from it.
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            tool: name of the tool of the two poses; empty for the one in use.
            wobj: name of the work object of the two poses; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.wobj_move_2p(
            p1, p2, v, a, r=r, tool=tool, wobj=wobj, op=op, def_acc=def_acc
        )

    @moves
    def movec(
        self,
        via: PoseLike,
        pose: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        mode: int = 0,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool to a pose along an arc (圆弧运动).

        Args:
            via: a pose on the arc (p1): x, y, z [m], rx, ry, rz [rad].
            pose: target pose (p2) of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            mode: orientation of the tool: 0 changes to that of the end pose, 1 stays as at the
                start, 2 stays fixed to the arc's tangent.
            q_near: joint angles near the target [rad], to check its branch; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.movec(
            via, pose, v, a, r=r, mode=mode, q_near=q_near, tool=tool, wobj=wobj, op=op,
            def_acc=def_acc
        )

    @moves
    def move_circle(
        self,
        p1: PoseLike,
        p2: PoseLike,
        v: float,
        a: float,
        *,
        r: float = 0.0,
        mode: int = 1,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool along a whole circle (圆周运动), from its present pose through two poses.

        Args:
            p1: the first pose on the circle: x, y, z [m], rx, ry, rz [rad].
            p2: the second pose on the circle; the order start, p1, p2 gives the direction.
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            mode: orientation of the tool: 1 as at the start, 2 fixed to the circle's tangent.
            q_near: joint angles near the target [rad], to check its branch; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.move_circle(
            p1, p2, v, a, r=r, mode=mode, q_near=q_near, tool=tool, wobj=wobj, op=op,
            def_acc=def_acc
        )

    @moves
    def spline(
        self,
        poses: Iterable[PoseLike],
        v: float,
        a: float,
        *,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        r: float = 0.0,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool along a spline through poses (样条运动).

        If two splines follow each other, the second one must not begin with the last pose of the
        first.

        Args:
            poses: 1 to 50 poses of the tool in the work object; the first may be the present
                pose; x, y, z [m], rx, ry, rz [rad]. Shape (n, 6).
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            r: blend radius into the next motion [m]; 0 to stop at the end.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.spline(poses, v, a, tool=tool, wobj=wobj, op=op, r=r, def_acc=def_acc)

    @moves
    def spline_op(
        self,
        points: Iterable[PointOp],
        v: float,
        a: float,
        *,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        r: float = 0.0,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool along a spline, and set outputs at its points (样条运动, 触发点位 OP).

        If two splines follow each other, the second one must not begin with the last pose of the
        first.

        Args:
            points: 1 to 50 poses of the tool in the work object, each with outputs to set there.
            v: speed of the tool, 0.00001 to 5 [m/s].
            a: acceleration of the tool, from 0.00001 [m/s²].
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way along the whole spline.
            r: blend radius into the next motion [m]; 0 to stop at the end.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.spline_op(
            points, v, a, tool=tool, wobj=wobj, op=op, r=r, def_acc=def_acc
        )

    @moves
    def move_spiral(
        self,
        center: PoseLike,
        pose: PoseLike | None,
        rev: float,
        length: float,
        radius: float,
        mode: int,
        v: float,
        a: float,
        *,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool along a spiral (螺旋运动), given by parameters or by its end.

        Args:
            center: pose of the spiral's centre (p1): x, y, z [m], rx, ry, rz [rad].
            pose: target pose (p2): x, y, z [m], rx, ry, rz [rad]; None in mode 0, which ignores it.
            rev: total number of turns, negative for clockwise.
            length: distance along the axis (len) [m], signed by the right-hand rule; mode 1
                ignores it.
            radius: radius at the end (rad, once red in the manual), from 0 [m]; mode 1 ignores
                it.
            mode: 0 for a spiral given by parameters, 1 for one given by its end.
            v: highest speed of the tool, 0.01 to 5 [m/s].
            a: highest acceleration of the tool, from 0.01 [m/s²].
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range, or `pose` is missing in mode 1.

        Manual section 1.3.5.
        """
        return self._section.move_spiral(
            center, pose, rev, length, radius, mode, v, a, q_near=q_near, tool=tool, wobj=wobj,
            op=op, def_acc=def_acc
        )

    @moves
    def speedj(
        self, velocities: VectorLike, a: float, *, time: float | None = 1.0
    ) -> aio_command.MotionCommand:
        """Turn the joints, each at a velocity (关节速度运动), for a time.

        An interrupt while it waits, or an error inside its block, stops the arm. If the arm still
        moves two seconds after `time`, this program stops it.

        Args:
            velocities: velocities of the six joints (joints_list), -1.25·π to 1.25·π [rad/s].
                Shape (6,).
            a: acceleration of the leading joint, from 0.01·π/180 [rad/s²].
            time: seconds after which the controller stops the arm, from 0.001; None: the motion
                runs until the block is left or `speed_stop` is called. Then only the heartbeat
                stops the arm if the program hangs.

        Returns:
            How it ended: finished or blended. It ends when the arm stands.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.speedj(velocities, a, time=time)

    @moves
    def speedl(
        self,
        twist: VectorLike,
        a: float,
        *,
        time: float | None = 1.0,
        frame: MotionFrame = 'tool',
        wobj: str = '',
    ) -> aio_command.MotionCommand:
        """Move the tool at a velocity (末端速度运动), for a time.

        The controller takes the velocity in the tool's frame: manual 4.3 says so, manual 3.8 does
        not say. With another `frame`, this package converts it by the tool's orientation. It reads
        the orientation just before it sends the motion, so the value is a few milliseconds old.

        An interrupt while it waits, or an error inside its block, stops the arm. If the arm still
        moves two seconds after `time`, this program stops it.

        Args:
            twist: velocity of the tool (pose_list): along x, y, z of `frame`, -5 to 5 [m/s], and
                about them, -1.25·π to 1.25·π [rad/s]. Shape (6,).
            a: acceleration of the tool, from 0.00001 [m/s²].
            time: seconds after which the controller stops the arm, from 0.001; None: the motion
                runs until the block is left or `speed_stop` is called. Then only the heartbeat
                stops the arm if the program hangs.
            frame: frame of the velocity: "tool", "base" (z points up if the arm stands on a floor)
                or "wobj", a work object.
            wobj: name of the work object; empty for the one in use.

        Returns:
            How it ended: finished or blended. It ends when the arm stands. Sending it raises
            `StaleState` if the orientation cannot be read.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range; or, in another frame than the tool's, the
                tool is to turn about one direction while it moves along another. That needs a new
                velocity each time that the tool has turned: use `robot.speed.linear`.

        Manual section 1.3.5.
        """
        return self._section.speedl(twist, a, time=time, frame=frame, wobj=wobj)

    def speed_stop(self) -> None:
        """End `speedj` and `speedl` (停止 speedj 及 speedl), and wait until the arm stands.

        If a motion of this program is running and cannot be ended in this way, or if this is
        cancelled, the arm is stopped as by `Robot.stop`.

        Raises:
            TaskError: the controller did not end them.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.5.
        """
        self._runner.call(self._section.speed_stop())

    @moves
    def servoj(
        self,
        joints: JointsLike,
        v: float,
        a: float,
        *,
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> aio_command.MotionCommand:
        """Go to joint angles, each joint independently (关节伺服运动), from any state of motion.

        Args:
            joints: target, six angles in [-2π, 2π] [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            kp: proportional gain, from 0; 200 is recommended.
            kd: derivative gain, from 0; 25 is recommended.
            smooth_vel: smoothing of the speed, 1 to 100; a larger value lags more.
            smooth_acc: smoothing of the acceleration, 0 to 1; a larger value lags more.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.servoj(
            joints, v, a, kp=kp, kd=kd, smooth_vel=smooth_vel, smooth_acc=smooth_acc
        )

    @moves
    def servoj_pose(
        self,
        pose: PoseLike,
        v: float,
        a: float,
        *,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> aio_command.MotionCommand:
        """Go to a pose of the tool, each joint independently (关节伺服运动到位姿).

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            kp: proportional gain, from 0; 200 is recommended.
            kd: derivative gain, from 0; 25 is recommended.
            smooth_vel: smoothing of the speed, 1 to 100; a larger value lags more.
            smooth_acc: smoothing of the acceleration, 0 to 1; a larger value lags more.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.servoj_pose(
            pose, v, a, q_near=q_near, tool=tool, wobj=wobj, kp=kp, kd=kd, smooth_vel=smooth_vel,
            smooth_acc=smooth_acc
        )

    @moves
    def servo_tcp(
        self,
        offset: PoseLike,
        v: float,
        a: float,
        *,
        tool: str = '',
        frame: MotionFrame = 'tool',
        wobj: str = '',
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> aio_command.MotionCommand:
        """Shift the arm's present target by an offset of the tool (工具增量伺服运动).

        The controller takes the offset in the tool's frame. With another `frame`, this package
        converts it by the tool's orientation. It reads the orientation just before it sends the
        motion, so the value is a few milliseconds old. While the tool turns, its target has another
        orientation; `robot.servo.tcp_offset` takes that into account.

        Args:
            offset: translation x, y, z [m] and rotation rx, ry, rz [rad] (pose_offset) along and
                about the axes of `frame`, from the arm's present target. The tool turns about its
                tip.
            v: highest speed, 0.01·π/180 to 1.25·π: of the joints by manual 3.8 [rad/s], of the
                tool by manual 4.3 [m/s].
            a: highest acceleration, from 0.01·π/180 [rad/s² or m/s²].
            tool: name of the tool; empty for the one in use.
            frame: frame of the offset: "tool", "base" (z points up if the arm stands on a floor)
                or "wobj", a work object.
            wobj: name of the work object; empty for the one in use.
            kp: proportional gain, from 0; 200 is recommended.
            kd: derivative gain, from 0; 25 is recommended.
            smooth_vel: smoothing of the speed, 1 to 100; a larger value lags more.
            smooth_acc: smoothing of the acceleration, 0 to 1; a larger value lags more.

        Returns:
            How it ended: finished or blended. Each further use shifts the target by the offset
            again. Sending it raises `StaleState` if the orientation cannot be read.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.servo_tcp(
            offset, v, a, tool=tool, frame=frame, wobj=wobj, kp=kp, kd=kd, smooth_vel=smooth_vel,
            smooth_acc=smooth_acc
        )

    @moves
    def servol(
        self,
        pose: PoseLike,
        v: float,
        a: float,
        *,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> aio_command.MotionCommand:
        """Go to a pose of the tool, each Cartesian direction independently (笛卡尔伺服运动).

        Args:
            pose: target pose of the tool in the work object (pose_list); x, y, z [m], rx, ry, rz
                [rad].
            v: highest speed, 0.01·π/180 to 1.25·π: of the joints by manual 3.8 [rad/s], of the
                tool by manual 4.3 [m/s].
            a: highest acceleration, from 0.01·π/180 [rad/s² or m/s²].
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            kp: proportional gain, from 0; 200 is recommended.
            kd: derivative gain, from 0; 25 is recommended.
            smooth_vel: smoothing of the speed, 1 to 100; a larger value lags more.
            smooth_acc: smoothing of the acceleration, 0 to 1; a larger value lags more.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.servol(
            pose, v, a, q_near=q_near, tool=tool, wobj=wobj, kp=kp, kd=kd, smooth_vel=smooth_vel,
            smooth_acc=smooth_acc
        )

    @moves
    def move_jog(
        self,
        jog: Jog,
        *,
        time: float | None = 1.0,
        directions: JogDirections = JogDirections.MANUAL_3_8,
    ) -> aio_command.MotionCommand:
        """Jog one joint or one Cartesian direction (点动).

            robot.motion.move_jog(Jog.joint(1, 1, vel=10, step=0.01))
            with robot.motion.move_jog.start(Jog.cartesian("z", -1, vel=5), time=10.0):
                released()                # leaving the block ends the jog

        A step ends by itself. Without a step the controller jogs until a command ends the jog:
        this program sends that command when the block is left, at the latest after `time`.
        An interrupt while it waits, or an error inside its block, stops the arm.

        Args:
            jog: the jog, made by `Jog.joint` or `Jog.cartesian`.
            time: seconds after which this program ends a jog without a step, from 0.001; None: it
                runs until the block is left or `stop_manual_move` is called. The wire has no such
                time: if the program hangs, only the heartbeat stops the arm.
            directions: the controller's meaning of the two directions: the manuals contradict
                each other. Try it with a small step at a low speed.

        Returns:
            How it ended: finished or blended. Without a step, it ends when the arm stands.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        return self._section.move_jog(jog, time=time, directions=directions)

    def stop_manual_move(self) -> None:
        """End a jog (结束点动), and wait until the arm stands.

        If a jog of this program is running and cannot be ended in this way, or
        if this is interrupted, the arm is stopped as by `Robot.stop`.

        Raises:
            TaskError: the controller did not end it.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.5.
        """
        self._runner.call(self._section.stop_manual_move())

    @moves
    def teach_mode(self) -> aio_command.MotionCommand:
        """Let the arm be guided by hand (进入牵引示教模式), until a command ends it.

            with robot.motion.teach_mode.start():
                taught()                  # leaving the block ends hand guiding

        Set the right tool and load first: if the arm carries another weight than the one that was
        set, it sinks or rises by itself. An interrupt while it waits, or an error inside its block,
        stops the arm and ends hand guiding; so does leaving the robot's block.

        Returns:
            How it ended: finished or blended. It ends by `end_teach_mode` or by leaving its block.

        Manual section 1.3.5.
        """
        return self._section.teach_mode()

    def end_teach_mode(self) -> None:
        """End hand guiding (退出牵引示教模式), and wait until the arm stands.

        If this program's hand guiding cannot be ended in this way, or if this is interrupted, the
        arm is stopped as by `Robot.stop`.

        Raises:
            TaskError: the controller did not end it.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.5.
        """
        self._runner.call(self._section.end_teach_mode())

    def set_hand_teach_parameter(
        self,
        space: int,
        joint_scale: WholesLike,
        cart_scale: WholesLike,
        coord_type: JogFrame | int,
        direction: FlagsLike,
    ) -> None:
        """Set how the arm gives way to a hand (设置牵引参数).

        Args:
            space: 0 the joints give way, 1 the Cartesian directions.
            joint_scale: compliance of the six joints, whole numbers from 0. Shape (6,).
            cart_scale: compliance along and about x, y, z, whole numbers from 0. Shape (6,).
            coord_type: frame of the directions, a `JogFrame`: 0 world, 1 base, 2 tool, 3 work
                object.
            direction: whether the arm gives way in each of the six. Shape (6,).

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.5.
        """
        work = self._section.set_hand_teach_parameter(
            space, joint_scale, cart_scale, coord_type, direction
        )
        self._runner.call(work)

    def start_record_track(
        self, name: str, mode: int, *, tool: str = '', wobj: str = '', interval: float | None = None
    ) -> None:
        """Start to record joints and poses of the arm on the controller (开启轨迹记录).

        When the recording is full, the controller ends it and pauses the running program.

        Args:
            name: name of the track, for `replay`.
            mode: 0 to record a point each time that the joints have moved by `interval`, 1 at
                equal times.
            tool: name of the tool whose poses are recorded; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            interval: interval between two points, above 0: sum of the joints' travel [rad] in
                mode 0, time [s] in mode 1. None for 5° or 0.25 s, the manual's values. The manual's
                prototype lacks this argument; the wire has it.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not started.

        Manual section 1.3.7.
        """
        work = self._section.start_record_track(name, mode, tool=tool, wobj=wobj, interval=interval)
        self._runner.call(work)

    def stop_record_track(self) -> None:
        """End the recording of a track (停止轨迹记录).

        Raises:
            TaskError: it was not ended.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.stop_record_track())

    def replay(self, name: str, v: int, mode: int) -> None:
        """Run a track that was recorded (轨迹复现), and wait until it has ended.

        The wire can only start the track and wait for its end, so there is no task to follow.
        Cancelling this stops the arm.

        Args:
            name: name of the track.
            v: speed in percent of the set speed, a whole number from 1 to 100.
            mode: 0 in joint space, 1 in Cartesian space.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: the track was not run to its end.
            OutcomeUnknown: it was sent, but not answered; the arm was stopped.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.5.
        """
        self._runner.call(self._section.replay(name, v, mode))


class Servo(_Section):
    """Streams of positions to follow (servo, manual 1.3.5).

        with robot.servo.joints(v=1.0, a=5.0, rate=500) as stream:
            for tick in stream.ticks():
                stream.send(policy(tick.time))

    All of them move each joint separately to the newest set-point. Only one stream may be open on a
    robot, and no other motion may run at the same time.

    All of them take these keywords for how the program feeds the stream, here with their defaults:

        rate: set-points per second to the controller [Hz]; 500.
        source_rate: targets per second from the program [Hz]; as many as `rate`, or measured.
        latest: whether only the newest target counts, and `send` never waits; False.
        upsample: up-sampling of targets to `rate`: "none", "linear", "cubic" or "ruckig"; "none".
        hold: time without a target after which the stream ends [s]; 0.5.
        ahead: targets queued before `send` waits; those of 50 ms.

    Streams of positions (all but `tcp_offset`) also take chunks of actions, by `Stream.send_chunk`:

        chunks: whether the program sends chunks, `source_rate` actions per second; False. They need
            upsample="ruckig", which keeps the jerk limit, or "cubic".
        blend: time of the transition from an older chunk to a newer one [s]; 0.1.
    """

    __slots__ = ()
    _section: AioServo

    def joints(
        self,
        *,
        v: float,
        a: float,
        jerk: float | None = None,
        max_step: float = 0.2,
        reach: float = 0.1,
        gains: ServoGains | None = None,
        options: LaneOptions | None = None,
        **feeding: Unpack[ServoOptions]
    ) -> Stream:
        """Follow joint positions (servoj, 关节伺服).

        Args:
            v: largest speed of each joint, 0.000175 to 3.93 [rad/s].
            a: largest acceleration of each joint, from 0.000175 [rad/s²].
            jerk: largest jerk of each joint, for upsample="ruckig" [rad/s³]; None: 10 a.
            max_step: largest step of a joint between two targets [rad].
            reach: largest distance of each joint from the first target [rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the worker runs; None: in a separate process.
            feeding: how the program feeds it, see above.

        Returns:
            The stream; its set-points are six joint angles [rad], -2π to 2π.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        made = self._section.joints(
            v=v, a=a, jerk=jerk, max_step=max_step, reach=reach, gains=gains, options=options,
            **feeding
        )
        return Stream(self._runner, made)

    def pose(
        self,
        *,
        v: float,
        a: float,
        velocity: tuple[float, float] = (0.25, 1.0),
        acceleration: tuple[float, float] = (1.0, 4.0),
        jerk: tuple[float, float] | None = None,
        q_near: VectorLike | None = None,
        tool: str = '',
        wobj: str = '',
        max_step: tuple[float, float] = (0.05, 0.2),
        reach: tuple[float, float] = (0.05, 0.1),
        gains: ServoGains | None = None,
        options: LaneOptions | None = None,
        **feeding: Unpack[ServoOptions]
    ) -> Stream:
        """Follow poses of the tool in the work object (servoj_pose, 位姿伺服).

        Args:
            v: largest speed of each joint, for the controller, 0.000175 to 3.93 [rad/s].
            a: largest acceleration of each joint, for the controller, from 0.000175 [rad/s²].
            velocity: largest speed of the tool [m/s] and its largest turning speed [rad/s].
            acceleration: largest acceleration of the tool [m/s²] and of its turning [rad/s²].
            jerk: largest jerk of the tool [m/s³] and of its turning [rad/s³]; None: 10 times the
                acceleration.
            q_near: joint angles that choose the solution [rad]; None: the present ones.
            tool: name of the tool; empty: the one in use.
            wobj: name of the work object; empty: the one in use.
            max_step: largest step between two targets [m, rad].
            reach: largest distance of the tool from the first target [m, rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the worker runs; None: in a separate process.
            feeding: how the program feeds it, see above.

        Returns:
            The stream; its set-points are poses (x, y, z [m], rx, ry, rz [rad]).

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        made = self._section.pose(
            v=v, a=a, velocity=velocity, acceleration=acceleration, jerk=jerk, q_near=q_near,
            tool=tool, wobj=wobj, max_step=max_step, reach=reach, gains=gains, options=options,
            **feeding
        )
        return Stream(self._runner, made)

    def linear(
        self,
        *,
        v: float,
        a: float,
        velocity: tuple[float, float] = (0.25, 1.0),
        acceleration: tuple[float, float] = (1.0, 4.0),
        jerk: tuple[float, float] | None = None,
        q_near: VectorLike | None = None,
        tool: str = '',
        wobj: str = '',
        max_step: tuple[float, float] = (0.05, 0.2),
        reach: tuple[float, float] = (0.05, 0.1),
        gains: ServoGains | None = None,
        options: LaneOptions | None = None,
        **feeding: Unpack[ServoOptions]
    ) -> Stream:
        """Follow poses with Cartesian interpolation in the controller (servol, 直线伺服).

        Manual 3.8 gives `v` and `a` for the joints, manual 4.3 for the tool; the ranges here lie
        within both. The other arguments are those of `pose`.

        Args:
            v: speed for the controller, 0.000175 to 3.93 [rad/s or m/s].
            a: acceleration for the controller, from 0.000175 [rad/s² or m/s²].
            velocity: largest speed of the tool [m/s] and its largest turning speed [rad/s].
            acceleration: largest acceleration of the tool [m/s²] and of its turning [rad/s²].
            jerk: largest jerk of the tool [m/s³] and of its turning [rad/s³].
            q_near: joint angles that choose the solution [rad].
            tool: name of the tool.
            wobj: name of the work object.
            max_step: largest step between two targets [m, rad].
            reach: largest distance of the tool from the first target [m, rad].
            gains: how closely the controller follows.
            options: how the worker runs.
            feeding: how the program feeds it, see above.

        Returns:
            The stream; its set-points are poses (x, y, z [m], rx, ry, rz [rad]).

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        made = self._section.linear(
            v=v, a=a, velocity=velocity, acceleration=acceleration, jerk=jerk, q_near=q_near,
            tool=tool, wobj=wobj, max_step=max_step, reach=reach, gains=gains, options=options,
            **feeding
        )
        return Stream(self._runner, made)

    def tcp_offset(
        self,
        *,
        v: float,
        a: float,
        velocity: tuple[float, float] = (0.25, 1.0),
        acceleration: tuple[float, float] = (1.0, 4.0),
        jerk: tuple[float, float] | None = None,
        tool: str = '',
        frame: MotionFrame = 'tool',
        wobj: str = '',
        max_step: tuple[float, float] = (0.05, 0.2),
        gains: ServoGains | None = None,
        options: LaneOptions | None = None,
        **feeding: Unpack[PacedOptions]
    ) -> OffsetStream:
        """Move by offsets of the tool, in its frame or another (servo_tcp, 工具增量伺服).

        The controller takes offsets in the tool's frame. With another `frame` the worker rotates
        them: it reads the tool's orientation once, when the first offset is due and the arm stands
        still, and computes from there, so that no offset depends on the age of a reading.

        The controller applies an offset to its last target, so offsets add up, and each is executed
        once: when no more offsets come, the arm stops at their sum. The worker spreads them over as
        many ticks as the limits require. With `latest`, offsets that are not sent yet add up.

        Args:
            v: speed for the controller, 0.000175 to 3.93 [rad/s or m/s].
            a: acceleration for the controller, from 0.000175 [rad/s² or m/s²].
            velocity: largest speed of the tool [m/s] and its largest turning speed [rad/s].
            acceleration: largest acceleration of the tool [m/s²] and of its turning [rad/s²].
            jerk: largest jerk of the tool [m/s³] and of its turning [rad/s³]; None: 10 times the
                acceleration.
            tool: name of the tool; empty: the one in use.
            frame: frame whose axes an offset refers to: "tool", "base" (z is up if the arm stands
                on a floor) or "wobj", a work object. An offset turns the tool about its tip.
            wobj: name of the work object; empty: the one in use.
            max_step: largest translation and largest rotation of one offset [m, rad].
            gains: how closely the controller follows; None: as the manual advises.
            options: how the worker runs; None: in a separate process.
            feeding: how the program feeds it, see above.

        Returns:
            The stream; its set-points are offsets (x, y, z [m], rx, ry, rz [rad]) in `frame`.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        made = self._section.tcp_offset(
            v=v, a=a, velocity=velocity, acceleration=acceleration, jerk=jerk, tool=tool,
            frame=frame, wobj=wobj, max_step=max_step, gains=gains, options=options, **feeding
        )
        return OffsetStream(self._runner, made)


class Speed(_Section):
    """Streams of speeds (speedj, speedl, manual 1.3.5), for example from a joystick.

        with robot.speed.linear(a=0.5, frame="base", dead_man=0.2) as stream:
            for tick in stream.ticks():
                stream.send(joystick())

    Each call carries a time after which the controller ends the motion by itself, so the arm also
    stops when the program dies or the cable is pulled. At its end the stream ramps the speed to
    zero and calls speed_stop.
    """

    __slots__ = ()
    _section: AioSpeed

    def joints(
        self,
        *,
        a: float,
        v: float = 1.0,
        dead_man: float = 0.2,
        rate: float = 50.0,
        latest: bool = True,
        hold: float = 0.1,
        options: LaneOptions | None = None,
    ) -> Stream:
        """Follow joint speeds (speedj, 关节速度).

        Args:
            a: largest acceleration of each joint, from 0.000175 [rad/s²].
            v: largest speed of each joint, 0.000175 to 3.93 [rad/s]; higher speeds are limited.
            dead_man: time without a call after which the controller ends the motion [s].
            rate: calls per second [Hz].
            latest: whether only the newest speed counts, and `send` never waits.
            hold: time without a speed from the program after which the stream ends [s].
            options: how the worker runs; None: in a separate process.

        Returns:
            The stream; its set-points are six joint speeds [rad/s].

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        made = self._section.joints(
            a=a, v=v, dead_man=dead_man, rate=rate, latest=latest, hold=hold, options=options
        )
        return Stream(self._runner, made)

    def linear(
        self,
        *,
        a: float,
        turn_a: float = 2.0,
        v: float = 0.25,
        turn_v: float = 1.0,
        frame: MotionFrame = 'tool',
        wobj: str = '',
        dead_man: float = 0.2,
        rate: float = 50.0,
        latest: bool = True,
        hold: float = 0.1,
        options: LaneOptions | None = None,
    ) -> Stream:
        """Follow a speed of the tool (speedl, 末端速度).

        The controller takes the speed in the tool's frame: manual 4.3 says so, manual 3.8 says
        nothing. With another `frame` the worker rotates the speed. The orientation that it uses
        was read from the controller at most 10 ms, plus the time of that call, before the speed is
        sent.

        Args:
            a: largest acceleration of the tool, from 0.00001 [m/s²].
            turn_a: largest change of the turning speed [rad/s²]; the worker keeps this limit.
            v: largest speed, 0.00001 to 5 [m/s]; higher speeds are limited.
            turn_v: largest turning speed, up to 3.93 [rad/s]; higher speeds are limited.
            frame: frame whose axes the speed refers to: "tool", "base" (z is up if the arm stands
                on a floor) or "wobj", a work object.
            wobj: name of the work object; empty: the one in use.
            dead_man: time without a call after which the controller ends the motion [s].
            rate: calls per second [Hz].
            latest: whether only the newest speed counts, and `send` never waits.
            hold: time without a speed from the program after which the stream ends [s].
            options: how the worker runs; None: in a separate process.

        Returns:
            The stream; its set-points are speeds (x, y, z [m/s], rx, ry, rz [rad/s]) in `frame`.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        made = self._section.linear(
            a=a, turn_a=turn_a, v=v, turn_v=turn_v, frame=frame, wobj=wobj, dead_man=dead_man,
            rate=rate, latest=latest, hold=hold, options=options
        )
        return Stream(self._runner, made)


class Program(_Section):
    """Programs and files of the controller (脚本控制, manual 1.3.4).

    A program may move the arm: take the same care as for a motion when you start one.
    """

    __slots__ = ()
    _section: AioProgram

    @moves
    def run_program(self, name: str) -> aio_command.MotionCommand:
        """Run a program that is stored on the controller (运行程序脚本).

            robot.program.run_program("palletize")

        An interrupt while it waits stops the arm and all tasks. `Robot.pause` and `Robot.resume`
        act on it.

        Args:
            name: name of the program.

        Returns:
            The run of the program, not started yet. It ends when the program does.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: the name is empty.

        Manual section 1.3.4.
        """
        return self._section.run_program(name)

    def get_current_project(self) -> str:
        """Read the path of the project that is loaded (当前工程路径). Manual section 1.3.4."""
        return self._runner.call(self._section.get_current_project())

    def get_files_list(self, path: str) -> dict[str, FileKind]:
        """Read the files and folders under a path of the controller (文件列表).

            path = robot.program.get_current_project()
            files = robot.program.get_files_list(path + "program")

        Args:
            path: path on the controller; the project's path ends with a separator.

        Returns:
            The kind of each file and folder, by its name.

        Raises:
            ParameterError: the path is no text; nothing was sent.
            Refused: the controller lists an error: there is no such folder.

        Manual section 1.3.4.
        """
        return self._runner.call(self._section.get_files_list(path))


class Track(_Section):
    """The track pool (轨迹池, manual 1.3.12): up to 1000 points, first in, first out.

    `stream` keeps the pool filled while the arm follows it. The functions of the wire are available
    as well:

        robot.track.trackClearQueue()
        robot.track.trackEnqueue([Joints(*q) for q in path])
        robot.track.trackJointMotion(1.0, 2.0)

    Points are six numbers each; the motion that follows them determines whether they are joints or
    poses. This package keeps a record of which of the two it put into the pool, and refuses a
    motion that would take one for the other.

    The manual asks for at least 10 points: when the pool is empty, the arm slows down and stands.
    Points that arrive after that may set it moving again.
    """

    __slots__ = ()
    _section: AioTrack

    def trackEnqueue(self, points: Iterable[JointsLike | PoseLike] | NDArray[Any]) -> None:
        """Put points into the pool (轨迹点入池).

        Args:
            points: 1 to 1000 points: all `Joints` [rad], or all `Pose` [m, rad], or six plain
                numbers each, which may be either. Shape (n, 6).

        Raises:
            ParameterError: a point is out of range; nothing was sent.
            RobotStateError: the pool holds points of the other kind; nothing was sent.
            TrackPoolFull: there is no room for them; `getQueueSize` returns the number of points in
                the pool.
            TaskError: they were not put in.
            EnvelopeViolated: `Joints` are beyond a limit of `robot.envelope`, or the arm that
                follows the pool is; nothing was sent.
            OutcomeUnknown: the answer was lost: empty the pool before you put in more.

        Manual section 1.3.12.
        """
        self._runner.call(self._section.trackEnqueue(points))

    def trackEnqueueOp(self, points: Iterable[PointOp]) -> None:
        """Put points into the pool, each with outputs to set there (带 Op 的轨迹点入池).

        Args:
            points: 1 to 1000 points, all of them with `Joints`, or all with a `Pose`.

        Raises:
            ParameterError: a point is out of range; nothing was sent.
            RobotStateError: the pool holds points of the other kind; nothing was sent.
            TrackPoolFull: there is no room for them; `getQueueSize` returns the number of points in
                the pool.
            TaskError: they were not put in.
            EnvelopeViolated: `Joints` are beyond a limit of `robot.envelope`, or the arm that
                follows the pool is; nothing was sent.
            OutcomeUnknown: the answer was lost: empty the pool before you put in more.

        Manual section 1.3.12.
        """
        self._runner.call(self._section.trackEnqueueOp(points))

    def trackClearQueue(self) -> None:
        """Empty the pool (清空轨迹池).

        Raises:
            TaskError: it was not emptied.

        Manual section 1.3.12.
        """
        self._runner.call(self._section.trackClearQueue())

    def getQueueSize(self) -> int:
        """Read the number of points that are left in the pool (轨迹池大小).

        Manual section 1.3.12.
        """
        return self._runner.call(self._section.getQueueSize())

    @moves
    def trackJointMotion(self, speed: float, acc: float) -> aio_command.MotionCommand:
        """Follow the points of the pool as joint angles (关节轨迹池跟随), until none is left.

        Args:
            speed: highest speed of the leading joint, 0.01·π/180 to 1.25·π [rad/s].
            acc: its highest acceleration, 0.01·π/180 to 12.5·π [rad/s²].

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.
            RobotStateError: the points that this program put into the pool are poses.

        Manual section 1.3.12.
        """
        return self._section.trackJointMotion(speed, acc)

    @moves
    def trackCartMotion(
        self, speed: float, acc: float, *, wobj: str = '', tool: str = '', radius: float = 0.005
    ) -> aio_command.MotionCommand:
        """Follow the points of the pool as poses (笛卡尔轨迹池跟随), until none is left.

        Args:
            speed: highest speed of the tool, 0.00001 to 5 [m/s].
            acc: its highest acceleration, from 0.00001 [m/s²].
            wobj: name of the work object; empty for the one in use.
            tool: name of the tool; empty for the one in use.
            radius: blend radius at the points, from 0 [m]. It is not in the manual; 0.005 is the
                vendor's default.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.
            RobotStateError: the points that this program put into the pool are joint angles.

        Manual section 1.3.12.
        """
        return self._section.trackCartMotion(speed, acc, wobj=wobj, tool=tool, radius=radius)

    def stream(
        self,
        space: Literal['joints', 'pose'],
        *,
        speed: float,
        acc: float,
        radius: float = 0.005,
        tool: str = '',
        wobj: str = '',
        operations: bool = False,
        low: int = 50,
        high: int = 200,
        period: float = 0.02,
        hold: float = 5.0,
        ahead: int = 200,
        max_step: float | tuple[float, float] | None = None,
        reach: float | tuple[float, float] | None = None,
        options: LaneOptions | None = None,
    ) -> TrackStream:
        """Follow the points of a path (trackEnqueue, trackJointMotion, trackCartMotion).

        Args:
            space: "joints" for joint positions, "pose" for poses of the tool.
            speed: largest joint speed, 0.000175 to 3.93 [rad/s], or speed of the tool, 0.00001
                to 5 [m/s].
            acc: largest joint acceleration, 0.000175 to 39.3 [rad/s²], or of the tool, from
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
        made = self._section.stream(
            space, speed=speed, acc=acc, radius=radius, tool=tool, wobj=wobj, operations=operations,
            low=low, high=high, period=period, hold=hold, ahead=ahead, max_step=max_step,
            reach=reach, options=options
        )
        return TrackStream(self._runner, made)


class Compound(_Section):
    """Combined motion (复合运动, manual 1.3.13): a weave laid over the motions that follow.

        robot.compound.combine_motion_config(WeaveShape.SINE, WeavePlane.TOOL_XY, 2.0, 0.003)
        robot.compound.enable_combine_motion()
        robot.motion.movel(end_of_seam, v=0.01, a=0.1)
        robot.compound.disable_combine_motion()

    The weave can be switched on and off only while the arm stands. It stays on after the program
    has ended.
    """

    __slots__ = ()
    _section: AioCompound

    def combine_motion_config(
        self,
        type: WeaveShape | int,
        ref_plane: WeavePlane | int,
        fq: float,
        amp: float,
        *,
        el_offset: float = 0.0,
        az_offset: float = 0.0,
        up_height: float = 0.0,
        time: VectorLike = (0.0, 0.0),
        path_dwell: bool = False,
        op_list: Sequence[Op] = (),
    ) -> None:
        """Set the weave (复合运动设置); it takes effect at the next `enable_combine_motion`.

        Args:
            type: shape of the weave, a `WeaveShape`: 1 triangle, 2 sine, 3 circle, 4 trapezoid,
                5 figure of eight.
            ref_plane: plane of the weave, a `WeavePlane`: 0 to 2 XY, XZ, YZ of the tool, 3 to 5
                of the work object.
            fq: frequency, above 0 [Hz].
            amp: amplitude, from 0 [m].
            el_offset: offset in elevation [m]; reserved.
            az_offset: offset in azimuth [m]; reserved.
            up_height: rise of the middle [m]; reserved.
            time: dwell times on the left and on the right, from 0 [s]. Shape (2,).
            path_dwell: whether the motion along the path pauses during a dwell.
            op_list: outputs set on the way. The manual calls the list two-dimensional; on the
                wire it has one dimension.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.13. It prints no unit for `time`. Manual 4.3 prints milliseconds, so
        the times are sent in milliseconds.
        """
        work = self._section.combine_motion_config(
            type, ref_plane, fq, amp, el_offset=el_offset, az_offset=az_offset, up_height=up_height,
            time=time, path_dwell=path_dwell, op_list=op_list
        )
        self._runner.call(work)

    def enable_combine_motion(self) -> None:
        """Lay the weave over the motions that follow (开启复合运动); the arm must stand.

        Raises:
            TaskError: it was not switched on.

        Manual section 1.3.13, which prints its name as enable_combined_motion.
        """
        self._runner.call(self._section.enable_combine_motion())

    def disable_combine_motion(self) -> None:
        """End the weave (结束复合运动); the arm must stand.

        Raises:
            TaskError: it was not switched off.

        Manual section 1.3.13, which prints its name as disable_combined_motion.
        """
        self._runner.call(self._section.disable_combine_motion())


class ExternalAxes(_Section):
    """External axes (外部轴, manual 1.3.14): turntables, rails, in schemes of up to three values.

        robot.external_axes.enable_eaxis_scheme("rail")
        robot.external_axes.movel_eaxis(
            target, v=0.2, a=0.5, scheme_name="rail", epose=[1.5, 0, 0], eaxis_v=0.1
        )

    A stop stops the arm and these axes. But the wire does not report whether an axis stands: where
    this package says that the arm stands, that says nothing about the axes.
    """

    __slots__ = ()
    _section: AioExternalAxes

    def enable_eaxis_scheme(self, scheme_name: str, *, timeout: float = 10.0) -> None:
        """Activate a scheme of external axes (启动外部轴方案).

        Args:
            scheme_name: name of the scheme.
            timeout: seconds within which the controller must have finished.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            TaskError: it was not activated.
            OutcomeUnknown: the controller did not answer within `timeout`.

        Manual section 1.3.14.
        """
        self._runner.call(self._section.enable_eaxis_scheme(scheme_name, timeout=timeout))

    def disable_eaxis_scheme(self, scheme_name: str, *, timeout: float = 10.0) -> None:
        """Deactivate a scheme of external axes (结束外部轴方案).

        Args:
            scheme_name: name of the scheme.
            timeout: seconds within which the controller must have finished.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            TaskError: it was not deactivated.
            OutcomeUnknown: the controller did not answer within `timeout`.

        Manual section 1.3.14.
        """
        self._runner.call(self._section.disable_eaxis_scheme(scheme_name, timeout=timeout))

    def get_eaxis_info(self) -> tuple[ExternalAxisState, ...]:
        """Read the state of each scheme of external axes (外部轴反馈信息).

        The wire of 3.8 has this function, and manual 4.3 describes it. Section 1.2 of manual 3.8
        describes the struct.
        """
        return self._runner.call(self._section.get_eaxis_info())

    def set_eaxis_param(self, num: int, param: ExternalAxis) -> None:
        """Set the parameters of an external axis.

        Args:
            num: number of the axis, from 0.
            param: its parameters.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: they were not set.

        Not in the manual, only on the wire. Check what the controller's own page shows before and
        after the call.
        """
        self._runner.call(self._section.set_eaxis_param(num, param))

    def set_eaxiss_scheme_param(self, num: int, param: ExternalAxisScheme) -> None:
        """Set the parameters of a scheme of external axes.

        Args:
            num: number of the scheme, from 0.
            param: its parameters.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: they were not set.

        Not in the manual, only on the wire. Check what the controller's own page shows before and
        after the call.
        """
        self._runner.call(self._section.set_eaxiss_scheme_param(num, param))

    def add_eaxis_scheme(self, num: int) -> None:
        """Add a scheme of external axes.

        Args:
            num: number of the scheme, from 0.

        Raises:
            ParameterError: the number is out of range; nothing was sent.
            TaskError: it was not added.

        Not in the manual, only on the wire.
        """
        self._runner.call(self._section.add_eaxis_scheme(num))

    def delete_eaxis_scheme(self, num: int) -> None:
        """Delete a scheme of external axes.

        Args:
            num: number of the scheme, from 0.

        Raises:
            ParameterError: the number is out of range; nothing was sent.
            TaskError: it was not deleted.

        Not in the manual, only on the wire.
        """
        self._runner.call(self._section.delete_eaxis_scheme(num))

    @moves
    def move_eaxis(
        self, scheme_name: str, epose: VectorLike, v: float, *, op: Op | None = None
    ) -> aio_command.MotionCommand:
        """Move external axes (外部轴移动); the arm stays where it is.

        The manual has a parameter def_acc here; the wire does not.

        Args:
            scheme_name: name of the scheme.
            epose: target, three values [rad or m, as the scheme is]. Shape (3,).
            v: highest speed of the axes (vel), above 0 [rad/s or m/s].
            op: outputs set on the way; triggers by distance have no effect here.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.14.
        """
        return self._section.move_eaxis(scheme_name, epose, v, op=op)

    @moves
    def move_jog_eaxis(
        self, scheme_name: str, direction: int, vel: float, *, time: float | None = 1.0
    ) -> aio_command.MotionCommand:
        """Jog external axes (外部轴点动).

            with robot.external_axes.move_jog_eaxis.start("rail", 1, vel=5, time=10.0):
                released()                # leaving the block ends the jog

        The controller jogs until a command ends the jog. No function is documented that ends this
        one alone, so this program stops all tasks, as `Robot.stop` does, when the block is left or
        after `time`. An interrupt while it waits, or an error inside its block, stops them too.

        Args:
            scheme_name: name of the scheme.
            direction: 1 or -1; it is sent unchanged.
            vel: speed in percent, above 0, up to 100.
            time: seconds after which this program ends the jog, from 0.001; None: the jog runs
                until the block is left. Then only the heartbeat stops the axes if the program
                hangs.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.14.
        """
        return self._section.move_jog_eaxis(scheme_name, direction, vel, time=time)

    @moves
    def movej2_eaxis(
        self,
        joints: JointsLike,
        v: float,
        a: float,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: float,
        *,
        r: float = 0.0,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the joints and external axes together (外部轴关节运动), as `movej2`.

        Args:
            joints: target, six angles in [-2π, 2π] [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            op: outputs set on the way; triggers by distance have no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.14. It gives no ranges for v and a: those of `movej2` apply.
        """
        return self._section.movej2_eaxis(
            joints, v, a, scheme_name, epose, eaxis_v, r=r, op=op, def_acc=def_acc
        )

    @moves
    def movej2_pose_eaxis(
        self,
        pose: PoseLike,
        v: float,
        a: float,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: float,
        *,
        r: float = 0.0,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool to a pose by the joints, with external axes, as `movej_pose2`.

        外部轴关节运动到位姿.

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way; triggers by distance have no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.14. It gives no ranges for v and a: those of `movej_pose2` apply.
        """
        return self._section.movej2_pose_eaxis(
            pose, v, a, scheme_name, epose, eaxis_v, r=r, q_near=q_near, tool=tool, wobj=wobj,
            op=op, def_acc=def_acc
        )

    @moves
    def movel_eaxis(
        self,
        pose: PoseLike,
        v: float,
        a: float,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: float,
        *,
        r: float = 0.0,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool along a line, with external axes (外部轴直线运动), as `movel`.

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, above 0, up to 5 [m/s].
            a: highest acceleration of the tool, above 0 [m/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.14, which prints its name as move1_eaxis.
        """
        return self._section.movel_eaxis(
            pose, v, a, scheme_name, epose, eaxis_v, r=r, q_near=q_near, tool=tool, wobj=wobj,
            op=op, def_acc=def_acc
        )

    @moves
    def movec_eaxis(
        self,
        via: PoseLike,
        pose: PoseLike,
        v: float,
        a: float,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: float,
        *,
        r: float = 0.0,
        mode: int = 0,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool along an arc, with external axes (外部轴圆弧运动), as `movec`.

        Args:
            via: a pose on the arc (p1): x, y, z [m], rx, ry, rz [rad].
            pose: target pose (p2) of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, above 0, up to 5 [m/s].
            a: highest acceleration of the tool, above 0 [m/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            mode: orientation of the tool: 0 changes to that of the end pose, 1 stays as at the
                start, 2 stays fixed to the arc's tangent.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Manual section 1.3.14. It has no `mode`; the wire does.
        """
        return self._section.movec_eaxis(
            via, pose, v, a, scheme_name, epose, eaxis_v, r=r, mode=mode, q_near=q_near, tool=tool,
            wobj=wobj, op=op, def_acc=def_acc
        )

    @moves
    def move_circle_eaxis(
        self,
        p1: PoseLike,
        p2: PoseLike,
        v: float,
        a: float,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: float,
        *,
        r: float = 0.0,
        mode: int = 1,
        q_near: JointsLike | None = None,
        tool: str = '',
        wobj: str = '',
        op: Op | None = None,
        def_acc: bool = False,
    ) -> aio_command.MotionCommand:
        """Move the tool along a circle, with external axes (外部轴圆周运动), as `move_circle`.

        Args:
            p1: the first pose on the circle: x, y, z [m], rx, ry, rz [rad].
            p2: the second pose on the circle; the order start, p1, p2 gives the direction.
            v: highest speed of the tool, above 0, up to 5 [m/s].
            a: highest acceleration of the tool, above 0 [m/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            mode: orientation of the tool: 1 as at the start, 2 fixed to the circle's tangent.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            ParameterError: an argument is out of range.

        Not in the manual, only on the wire. The ranges are those of `movec_eaxis`.
        """
        return self._section.move_circle_eaxis(
            p1, p2, v, a, scheme_name, epose, eaxis_v, r=r, mode=mode, q_near=q_near, tool=tool,
            wobj=wobj, op=op, def_acc=def_acc
        )


class Realtime(_Section):
    """Realtime control (实时控制, manual 1.3.15): the arm follows a queue, point by point.

    Programs normally use `stream`: it keeps the queue filled, at its rate, from a process of its
    own. The functions of the wire are available as well.

    The manual requires this order: empty the queue, put in the first points, the very first at the
    arm's position, start the mode, and put in more points before the queue is empty. The controller
    takes a point each cycle, so a program that calls function by function cannot keep up for long.

    While the mode is on, leaving the robot's block stops the arm and ends the mode; so does a stop.
    """

    __slots__ = ()
    _section: AioRealtime

    def start_realtime_mode(
        self,
        mode: RealtimeMode | int,
        *,
        filter_bandwidth: float = 100.0,
        com_lost_time: float = 0.02,
    ) -> None:
        """Make the arm follow the queue (开启实时控制模式).

        Cancelling this stops the arm, and ends the mode.

        Args:
            mode: kind of the queue's points, a `RealtimeMode`: 0 joint positions, 1 joint
                velocities, 2 joint torques, 3 poses, 4 velocities of the tool.
            filter_bandwidth: bandwidth of the filter over the points, above 0 [Hz]. The wire
                spells it fileter_bandwidth.
            com_lost_time: time for which the queue may be empty before the controller stops the
                arm, above 0 [s].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: the mode was not started.
            OutcomeUnknown: it was sent, but not answered; the arm was stopped.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.15.
        """
        work = self._section.start_realtime_mode(
            mode, filter_bandwidth=filter_bandwidth, com_lost_time=com_lost_time
        )
        self._runner.call(work)

    def end_realtime_mode(self) -> None:
        """End realtime control (结束实时控制模式), and wait until the arm stands.

        If this program's realtime control cannot be ended in this way, or if this is interrupted,
        the arm is stopped as by `Robot.stop`.

        Raises:
            TaskError: the controller did not end it.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.15.
        """
        self._runner.call(self._section.end_realtime_mode())

    def realtime_data_enqueue(self, points: Iterable[RealtimePoint]) -> None:
        """Put points into the queue (实时数据入队).

        Args:
            points: points made by the class methods of `RealtimePoint`, all for one mode; points
                for another mode than the one that is on have no effect.

        Raises:
            ParameterError: `points` is empty, or an element is not such a point, or is of another
                mode than the first; nothing was sent.
            TaskError: the points were not put in.
            EnvelopeViolated: joint positions are beyond a limit of `robot.envelope`, or the arm is
                that follows them; nothing was sent.

        Manual section 1.3.15.
        """
        self._runner.call(self._section.realtime_data_enqueue(points))

    def clear_realtime_data_queue(self) -> None:
        """Empty the queue (清空实时数据队列).

        Raises:
            TaskError: it was not emptied.

        Manual section 1.3.15.
        """
        self._runner.call(self._section.clear_realtime_data_queue())

    def get_realtime_data_queue_size(self) -> int:
        """Read how many points wait in the queue (实时队列数据数量). Manual section 1.3.15."""
        return self._runner.call(self._section.get_realtime_data_queue_size())

    def stream(
        self,
        mode: RealtimeMode | str,
        *,
        v: float | tuple[float, float],
        a: float | tuple[float, float],
        jerk: float | tuple[float, float] | None = None,
        frame: MotionFrame | None = None,
        depth: int = 40,
        period: float = 0.004,
        filter_bandwidth: float = 100.0,
        com_lost_time: float = 0.02,
        max_step: float | tuple[float, float] | None = None,
        reach: float | tuple[float, float] | None = None,
        options: LaneOptions | None = None,
        **feeding: Unpack[FeedingOptions]
    ) -> Stream:
        """Follow positions or speeds (start_realtime_mode, realtime_data_enqueue).

        Args:
            mode: "joint_position", "joint_velocity", "pose" or "twist". Torques cannot be streamed:
                manual 3.8 calls their field reserved, and such a stream has no safe end.
            v: largest speed: of each joint [rad/s], or of the tool and its turning
                [m/s, rad/s].
            a: largest acceleration: of each joint [rad/s²], or of the tool [m/s², rad/s²].
            jerk: largest jerk, for upsample="ruckig"; None: 10 a.
            frame: only for "twist": the frame whose axes it refers to: "wobj", the work object in
                use, as the controller takes it; "base" (z is up if the arm stands on a floor); or
                "tool". None: "wobj". The worker rotates the twist when it fills the queue. The
                tool's orientation is then at most 10 ms old, and `depth` milliseconds older when
                the controller executes the twist.
            depth: points to keep in the controller's queue; each is one millisecond.
            period: time between two polls of the queue [s].
            filter_bandwidth: bandwidth of the controller's filter of the points [Hz].
            com_lost_time: time with an empty queue after which the controller faults [s].
            max_step: largest step between two set-points [rad], or [m, rad].
            reach: largest distance of the arm from the first set-point [rad], or [m, rad].
            options: how the worker runs; None: in a separate process.
            feeding: how the program feeds it: `source_rate`, set-points per second [Hz], by default
                1000, or measured with `latest`; `latest`, `upsample`, `ahead` as for `robot.servo`;
                `hold`, time without a set-point after which the stream ends [s], 0.5 for positions
                and 0.1 for speeds, which continue for that time.

        Returns:
            The stream; its set-points are those of the mode.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.15.
        """
        made = self._section.stream(
            mode, v=v, a=a, jerk=jerk, frame=frame, depth=depth, period=period,
            filter_bandwidth=filter_bandwidth, com_lost_time=com_lost_time, max_step=max_step,
            reach=reach, options=options, **feeding
        )
        return Stream(self._runner, made)


class State(_Section):
    """State of the arm and of the controller (manual 1.3.7, 1.3.8).

    Every function only reads. Vectors are read-only arrays of shape (6,). Right after its start a
    controller has no values yet: then the functions raise `StaleState`.
    """

    __slots__ = ()
    _section: AioState

    def get_robot_state(self) -> RobotStates:
        """Read the states of robot, program, safety and mode (机器人状态). Manual section 1.3.7."""
        return self._runner.call(self._section.get_robot_state())

    def getRobotStatus(self) -> RobotStatus:
        """Read positions, speeds, temperatures and faults at once (机器人位姿等信息).

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.getRobotStatus())

    def getRobotIOStatus(self) -> IOStatus:
        """Read all inputs, outputs and registers at once (IO 和寄存器信息).

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.getRobotIOStatus())

    def robotmoving(self) -> bool:
        """Tell whether the arm moves (机器人是否在运动). Manual section 1.3.8."""
        return self._runner.call(self._section.robotmoving())

    def get_last_error(self) -> tuple[str, ...]:
        """Read the controller's latest errors (错误列表), in its own words.

        Manual section 1.3.8.
        """
        return self._runner.call(self._section.get_last_error())

    def get_noneblock_taskstate(self, task_id: int) -> TaskState:
        """Read the state of a task by its id (任务状态).

        This package follows the state of its own tasks; this function is for tasks of other
        programs.

        Manual section 1.3.8, which prints its name as get_noblock_taskstate.
        """
        return self._runner.call(self._section.get_noneblock_taskstate(task_id))

    def get_actual_joints_position(self) -> Joints:
        """Read the joint angles (关节角度) [rad]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_actual_joints_position())

    def get_target_joints_position(self) -> Joints:
        """Read the planned joint angles (规划角度) [rad]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_target_joints_position())

    def get_actual_joints_speed(self) -> Vector:
        """Read the joint speeds (关节角速度) [rad/s]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_actual_joints_speed())

    def get_target_joints_speed(self) -> Vector:
        """Read the planned joint speeds (规划角速度) [rad/s]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_target_joints_speed())

    def get_actual_joints_acceleration(self) -> Vector:
        """Read the joint accelerations (关节角加速度) [rad/s²]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_actual_joints_acceleration())

    def get_target_joints_acceleration(self) -> Vector:
        """Read the planned joint accelerations (规划加速度) [rad/s²]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_target_joints_acceleration())

    def get_actual_joints_torque(self) -> Vector:
        """Read the joint torques (关节力矩) [N·m]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_actual_joints_torque())

    def get_target_joints_torque(self) -> Vector:
        """Read the planned joint torques (目标力矩) [N·m]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_target_joints_torque())

    def get_ext_torque(self) -> Vector:
        """Read the observed external joint torques (外力矩) [N·m]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_ext_torque())

    def get_tcp_pose(self) -> Pose:
        """Read the pose of the tool in the base frame (末端位姿) [m, rad]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_tcp_pose())

    def get_tcp_pose_coord(self, tool: str = '', wobj: str = '') -> Pose:
        """Read the pose of a tool in a work object (工件坐标系下的位姿) [m, rad].

        Args:
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.

        Returns:
            The pose.

        Raises:
            ParameterError: a name is too long; nothing was sent.
            Refused: the controller lists an error: it has no such tool or work object.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_tcp_pose_coord(tool, wobj))

    def get_tcp_speed(self) -> Vector:
        """Read the speed of the tool (末端速度) [m/s, rad/s]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_tcp_speed())

    def get_tcp_acceleration(self) -> Vector:
        """Read the acceleration of the tool (末端加速度) [m/s², rad/s²]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_tcp_acceleration())

    def get_tcp_force(self) -> Vector:
        """Read force and torque at the tool (末端力) [N, N·m]; needs a force sensor.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_tcp_force())

    def get_tcp_force_tool(self, tool: str = '') -> Vector:
        """Read force and torque in a tool's frame (工具坐标系下的力) [N, N·m], by a sensor.

        Args:
            tool: name of the tool; empty for the one in use.

        Raises:
            ParameterError: the name is too long; nothing was sent.
            Refused: the controller lists an error: it has no such tool.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_tcp_force_tool(tool))

    def get_flange_pose(self) -> Pose:
        """Read the pose of the flange in the base frame (法兰位姿) [m, rad].

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_flange_pose())

    def get_flange_speed(self) -> Vector:
        """Read the speed of the flange (法兰速度) [m/s, rad/s]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_flange_speed())

    def get_flange_acceleration(self) -> Vector:
        """Read the acceleration of the flange (法兰加速度) [m/s², rad/s²]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_flange_acceleration())

    def read_encoder_count(self) -> int:
        """Read the count of an external incremental encoder (外接 INC 的实际 count 值).

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.read_encoder_count())


class IO(_Section):
    """Inputs and outputs of the cabinet and of the tool (manual 1.3.7)."""

    __slots__ = ()
    _section: AioIO

    def set_standard_digital_out(self, num: int, value: bool) -> None:
        """Set a general output of the cabinet (控制柜通用 IO 输出).

        Args:
            num: number of the output, 1 to 16.
            value: true for high.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: the output was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_standard_digital_out(num, value))

    def get_standard_digital_out(self, num: int) -> bool:
        """Read a general output of the cabinet (控制柜通用 IO 输出), 1 to 16.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_standard_digital_out(num))

    def get_standard_digital_in(self, num: int) -> bool:
        """Read a general input of the cabinet (控制柜用户 IO 输入), 1 to 16.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_standard_digital_in(num))

    def set_tool_digital_out(self, num: int, value: bool) -> None:
        """Set an output at the tool (末端 IO 输出).

        Args:
            num: number of the output, 1 or 2.
            value: true for high.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: the output was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_tool_digital_out(num, value))

    def get_tool_digital_out(self, num: int) -> bool:
        """Read an output at the tool (末端 IO 输出), 1 or 2. Manual section 1.3.7."""
        return self._runner.call(self._section.get_tool_digital_out(num))

    def get_tool_digital_in(self, num: int) -> bool:
        """Read an input at the tool (末端 IO 输入), 1 or 2. Manual section 1.3.7."""
        return self._runner.call(self._section.get_tool_digital_in(num))

    def get_function_digital_in(self, num: int) -> bool:
        """Read a function input of the cabinet (功能输入 IO), 1 to 8. Manual section 1.3.7."""
        return self._runner.call(self._section.get_function_digital_in(num))

    def get_function_digital_out(self, num: int) -> bool:
        """Read a function output of the cabinet (功能输出 IO), 1 to 8. Manual section 1.3.7."""
        return self._runner.call(self._section.get_function_digital_out(num))

    def get_config_digital_in(self, num: Whole) -> bool:
        """Read a configurable input of the cabinet, a whole number from 1.

        Not in the manual: the number of these inputs is not known.
        """
        return self._runner.call(self._section.get_config_digital_in(num))

    def set_digital_output_mode(
        self, num: Whole, type: OutputMode | int, *, freq: Whole, duty_cycle: Whole
    ) -> None:
        """Set whether a general output of the cabinet gives a level or pulses (IO 输出信号类型).

        It takes effect at the next `set_standard_digital_out`, which also starts and ends the
        pulses. All pulsing outputs have the same frequency and duty cycle.

        Args:
            num: number of the output, 1 to 16.
            type: an `OutputMode`: 0 a level, 1 pulses.
            freq: frequency of the pulses, 1 to 100 [Hz].
            duty_cycle: share of the time for which a pulse is high, 1 to 100 [%]. A pulse lasts at
                least 1 ms, so at 100 Hz the duty cycle is at least 10.

        Raises:
            ParameterError: an argument is out of range, or pulses would be too short; nothing
                was sent.
            TaskError: it was not set.

        Manual section 1.3.7, which prints its name as set_digital_out_mode.
        """
        work = self._section.set_digital_output_mode(num, type, freq=freq, duty_cycle=duty_cycle)
        self._runner.call(work)

    def get_standard_analog_voltage_in(self, num: Whole) -> float:
        """Read voltage input 1 to 4 of the cabinet (模拟电压输入) [V]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_standard_analog_voltage_in(num))

    def set_standard_analog_voltage_out(self, num: Whole, value: Real) -> None:
        """Set a voltage output of the cabinet (模拟电压输出).

        Args:
            num: number of the channel, 1 to 4.
            value: voltage, 0 to 10 [V].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_standard_analog_voltage_out(num, value))

    def get_tool_analog_voltage_in(self, num: Whole) -> float:
        """Read voltage input 1 or 2 of the tool (末端模拟电压输入) [V]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_tool_analog_voltage_in(num))

    def get_standard_analog_current_in(self, num: Whole) -> float:
        """Read current input 1 to 4 of the cabinet (模拟电流输入) [mA]. Manual section 1.3.7."""
        return self._runner.call(self._section.get_standard_analog_current_in(num))

    def set_standard_analog_current_out(self, num: Whole, value: Real) -> None:
        """Set a current output of the cabinet (模拟电流输出).

        Args:
            num: number of the channel, 1 to 4.
            value: current, 4 to 20 [mA].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_standard_analog_current_out(num, value))

    def set_analog_output_mode(self, num: Whole, mode: Whole) -> None:
        """Set the mode of an analog output of the cabinet.

        Not in the manual: the meaning of the modes' numbers is not known.

        Args:
            num: number of the channel, 1 to 4.
            mode: number of the mode.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.
        """
        self._runner.call(self._section.set_analog_output_mode(num, mode))


class Registers(_Section):
    """Registers (寄存器) and global variables (系统变量) of the controller (manual 1.3.7).

        robot.registers.write_word_reg(5, 1200)
        count = robot.registers.get_system_value_double("cell.count")

    Programs of the controller, fieldbuses and this program share them. A variable within a
    domain is named "domain.variable".
    """

    __slots__ = ()
    _section: AioRegisters

    def write_bool_reg(self, num: Whole, value: bool) -> None:
        """Write an internal bool register (内部 bool 寄存器).

        Args:
            num: number of the register, 1 to 64.
            value: value to write, true or false.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not written.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.write_bool_reg(num, value))

    def read_bool_reg(self, num: Whole) -> bool:
        """Read an internal bool register (内部 bool 寄存器), 1 to 64. Manual section 1.3.7."""
        return self._runner.call(self._section.read_bool_reg(num))

    def write_word_reg(self, num: Whole, value: Whole) -> None:
        """Write an internal word register (内部 word 寄存器).

        Args:
            num: number of the register, 1 to 32.
            value: value to write, 16 bits: -32768 to 65535.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not written.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.write_word_reg(num, value))

    def read_word_reg(self, num: Whole) -> int:
        """Read an internal word register (内部 word 寄存器), 1 to 32. Manual section 1.3.7."""
        return self._runner.call(self._section.read_word_reg(num))

    def write_float_reg(self, num: Whole, value: Real) -> None:
        """Write an internal float register (内部 float 寄存器).

        Args:
            num: number of the register, 1 to 32.
            value: value to write, a finite number.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not written.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.write_float_reg(num, value))

    def read_float_reg(self, num: Whole) -> float:
        """Read an internal float register (内部 float 寄存器), 1 to 32. Manual section 1.3.7."""
        return self._runner.call(self._section.read_float_reg(num))

    def get_function_reg_in(self, num: Whole) -> bool:
        """Read a function input register (功能输入寄存器), 1 to 16. Manual section 1.3.7."""
        return self._runner.call(self._section.get_function_reg_in(num))

    def get_function_reg_out(self, num: Whole) -> bool:
        """Read a function output register (功能输出寄存器), 1 to 16. Manual section 1.3.7."""
        return self._runner.call(self._section.get_function_reg_out(num))

    def set_system_value_bool(self, name: str, value: bool) -> None:
        """Set a variable of the controller of type bool (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: new value, true or false.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_system_value_bool(name, value))

    def get_system_value_bool(self, name: str) -> bool:
        """Read a variable of the controller of type bool (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_system_value_bool(name))

    def set_system_value_double(self, name: str, value: Real) -> None:
        """Set a variable of the controller of type double (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: new value, a finite number.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_system_value_double(name, value))

    def get_system_value_double(self, name: str) -> float:
        """Read a variable of the controller of type double (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_system_value_double(name))

    def set_system_value_str(self, name: str, value: str) -> None:
        """Set a variable of the controller of type str (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: new value, a text.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_system_value_str(name, value))

    def get_system_value_str(self, name: str) -> str:
        """Read a variable of the controller of type str (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_system_value_str(name))

    def set_system_value_list(self, name: str, value: VectorLike) -> None:
        """Set a variable of the controller of type num_list (系统变量).

        Args:
            name: its name; "domain.variable" within a domain.
            value: new value, finite numbers.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: it was not set: there is no such variable, or it is of another type.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_system_value_list(name, value))

    def get_system_value_list(self, name: str) -> Vector:
        """Read a variable of the controller of type num_list (系统变量), as a read-only array.

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_system_value_list(name))

    def get_system_value_lists(self, name: str) -> tuple[Vector, ...]:
        """Read a variable of the controller that is a list of poses, each a read-only array.

        Not in manual 3.8, but on its wire; manual 4.3 describes it.

        Args:
            name: its name; "domain.variable" within a domain.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller lists an error: there is no such variable, or it is of another
                type.
        """
        return self._runner.call(self._section.get_system_value_lists(name))


class Bus(_Section):
    r"""RS-485 of the cabinet and of the tool, and CAN (can 及 485 总线, manual 1.3.6).

        robot.bus.tool_write_raw_data_485(b"\x01\x06\x01\x00\x00\x01\x49\xf6")
        answer = robot.bus.tool_read_raw_data_485(8)

    Functions take bytes as `bytes` or as numbers; 255 and -1 are the same byte. They return
    `bytes`. Data from a bus stays in the controller's buffer until it is read. Before a request
    whose answer matters, read until the buffer is empty.
    """

    __slots__ = ()
    _section: AioBus

    def set_baudrate_485(self, value: Whole) -> None:
        """Set the bit rate of the cabinet's RS-485 port (设置 485 波特率).

        This is the cabinet's port; the wire has no such function for the tool's port.

        Args:
            value: bits a second, a whole number from 1. The manual lists no rates.

        Raises:
            ParameterError: the rate is out of range; nothing was sent.
            TaskError: the rate was not set.

        Manual section 1.3.6.
        """
        self._runner.call(self._section.set_baudrate_485(value))

    def read_raw_data_485(self, len: Whole) -> bytes:
        """Take bytes out of the buffer of the cabinet's port (485 读取原生数据).

        Args:
            len: maximum number of bytes, a whole number from 1.

        Returns:
            The bytes; empty if none have arrived.

        Raises:
            ParameterError: the number is out of range; nothing was sent.
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.

        Manual section 1.3.6.
        """
        return self._runner.call(self._section.read_raw_data_485(len))

    def read_raw_data_485_h(self, head: BytesLike, len: Whole) -> bytes:
        """Take a frame that begins with a head from the cabinet's port (485 匹配头).

        On one arm this returned nothing where `read_raw_data_485` returned bytes.

        Args:
            head: the bytes that the frame begins with, at least one.
            len: length of the frame, a whole number from 1.

        Returns:
            The frame; empty if none has arrived.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.

        Manual section 1.3.6.
        """
        return self._runner.call(self._section.read_raw_data_485_h(head, len))

    def read_raw_data_485_ht(self, head: BytesLike, tail: BytesLike) -> bytes:
        """Take a frame between a head and a tail from the cabinet's port (485 匹配头和尾).

        Args:
            head: the bytes that the frame begins with, at least one.
            tail: the bytes that it ends with, at least one.

        Returns:
            The frame; empty if none has arrived.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.

        Manual section 1.3.6.
        """
        return self._runner.call(self._section.read_raw_data_485_ht(head, tail))

    def write_raw_data_485(self, data: BytesLike) -> None:
        """Write bytes to the cabinet's port (485 写原生数据).

        Args:
            data: the bytes, at least one.

        Raises:
            ParameterError: `data` is empty, or contains a value that is not a byte; nothing was
                sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        self._runner.call(self._section.write_raw_data_485(data))

    def write_raw_data_485_h(self, data: BytesLike, head: BytesLike) -> None:
        """Write bytes with a head before them to the cabinet's port (485 写原生数据, 加头).

        Args:
            data: the bytes, at least one.
            head: the bytes that are put before the data, at least one.

        Raises:
            ParameterError: an argument is empty, or contains a value that is not a byte; nothing
                was sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        self._runner.call(self._section.write_raw_data_485_h(data, head))

    def write_raw_data_485_ht(self, data: BytesLike, head: BytesLike, tail: BytesLike) -> None:
        """Write bytes between a head and a tail to the cabinet's port (485 写原生数据, 加头和尾).

        Args:
            data: the bytes, at least one.
            head: the bytes that are put before the data, at least one.
            tail: the bytes that are put behind the data, at least one.

        Raises:
            ParameterError: an argument is empty, or contains a value that is not a byte; nothing
                was sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        self._runner.call(self._section.write_raw_data_485_ht(data, head, tail))

    def read_data_485(self) -> bytes:
        """Take bytes out of the buffer of the cabinet's port.

        Not in the manual. It is not known how it differs from `read_raw_data_485`, or how many
        bytes it returns.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.
        """
        return self._runner.call(self._section.read_data_485())

    def write_data_485(self, data: BytesLike) -> None:
        """Write bytes to the cabinet's port.

        Not in the manual. It is not known how it differs from `write_raw_data_485`.

        Args:
            data: the bytes, at least one.

        Raises:
            ParameterError: `data` is empty, or contains a value that is not a byte; nothing was
                sent.
            BusError: the bytes were not written.
        """
        self._runner.call(self._section.write_data_485(data))

    def tool_read_raw_data_485(self, len: Whole) -> bytes:
        """Take bytes out of the buffer of the tool's port (末端 485 读取原生数据).

        Args:
            len: maximum number of bytes, a whole number from 1.

        Returns:
            The bytes; empty if none have arrived.

        Raises:
            ParameterError: the number is out of range; nothing was sent.
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.

        Manual section 1.3.6.
        """
        return self._runner.call(self._section.tool_read_raw_data_485(len))

    def tool_read_raw_data_485_h(self, head: BytesLike, len: Whole) -> bytes:
        """Take a frame that begins with a head from the tool's port (末端 485 匹配头).

        On one arm this returned nothing where `tool_read_raw_data_485` returned bytes.

        Args:
            head: the bytes that the frame begins with, at least one.
            len: length of the frame, a whole number from 1.

        Returns:
            The frame; empty if none has arrived.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.

        Manual section 1.3.6.
        """
        return self._runner.call(self._section.tool_read_raw_data_485_h(head, len))

    def tool_read_raw_data_485_ht(self, head: BytesLike, tail: BytesLike) -> bytes:
        """Take a frame between a head and a tail from the tool's port (末端 485 匹配头和尾).

        Args:
            head: the bytes that the frame begins with, at least one.
            tail: the bytes that it ends with, at least one.

        Returns:
            The frame; empty if none has arrived.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.

        Manual section 1.3.6.
        """
        return self._runner.call(self._section.tool_read_raw_data_485_ht(head, tail))

    def tool_write_raw_data_485(self, data: BytesLike) -> None:
        """Write bytes to the tool's port (末端 485 写原生数据).

        Args:
            data: the bytes, at least one.

        Raises:
            ParameterError: `data` is empty, or contains a value that is not a byte; nothing was
                sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        self._runner.call(self._section.tool_write_raw_data_485(data))

    def tool_write_raw_data_485_h(self, data: BytesLike, head: BytesLike) -> None:
        """Write bytes with a head before them to the tool's port (末端 485 写原生数据, 加头).

        Args:
            data: the bytes, at least one.
            head: the bytes that are put before the data, at least one.

        Raises:
            ParameterError: an argument is empty, or contains a value that is not a byte; nothing
                was sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        self._runner.call(self._section.tool_write_raw_data_485_h(data, head))

    def tool_write_raw_data_485_ht(self, data: BytesLike, head: BytesLike, tail: BytesLike) -> None:
        """Write bytes between a head and a tail to the tool's port (末端 485 写原生数据, 加头和尾).

        Args:
            data: the bytes, at least one.
            head: the bytes that are put before the data, at least one.
            tail: the bytes that are put behind the data, at least one.

        Raises:
            ParameterError: an argument is empty, or contains a value that is not a byte; nothing
                was sent.
            BusError: the bytes were not written.

        Manual section 1.3.6.
        """
        self._runner.call(self._section.tool_write_raw_data_485_ht(data, head, tail))

    def tool_read_data_485(self) -> bytes:
        """Take bytes out of the buffer of the tool's port.

        Not in the manual. It is not known how it differs from `tool_read_raw_data_485`, or how
        many bytes it returns.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.
        """
        return self._runner.call(self._section.tool_read_data_485())

    def tool_write_data_485(self, data: BytesLike) -> None:
        """Write bytes to the tool's port.

        Not in the manual. It is not known how it differs from `tool_write_raw_data_485`.

        Args:
            data: the bytes, at least one.

        Raises:
            ParameterError: `data` is empty, or contains a value that is not a byte; nothing was
                sent.
            BusError: the bytes were not written.
        """
        self._runner.call(self._section.tool_write_data_485(data))

    def set_baudrate_can(self, value: Whole) -> None:
        """Set the bit rate of the CAN bus (设置 CAN 波特率).

        Args:
            value: bits a second, a whole number from 1. The manual lists no rates.

        Raises:
            ParameterError: the rate is out of range; nothing was sent.
            TaskError: the rate was not set.

        Manual section 1.3.6.
        """
        self._runner.call(self._section.set_baudrate_can(value))

    def read_raw_data_can(self) -> CanFrame | None:
        """Take a frame out of the buffer of the CAN bus (读取一帧 CAN 数据).

        Returns:
            The frame; None if none has arrived.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: a frame may be lost.

        Manual section 1.3.6.
        """
        return self._runner.call(self._section.read_raw_data_can())

    def write_raw_data_can(self, id: Whole, data: BytesLike) -> None:
        """Write a frame to the CAN bus (CAN 写原生数据).

        Args:
            id: its identifier, 0 to 0x1FFFFFFF.
            data: its bytes, at least one.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            BusError: the frame was not written.

        Manual section 1.3.6.
        """
        self._runner.call(self._section.write_raw_data_can(id, data))

    def read_data_can(self) -> bytes:
        """Take bytes out of the buffer of the CAN bus.

        Not in the manual. It is not known how it differs from `read_raw_data_can`, or whether an
        identifier comes first. So the bytes are returned unchanged.

        Raises:
            OutcomeUnknown: the request was sent, but not answered: bytes may be lost.
        """
        return self._runner.call(self._section.read_data_can())

    def write_data_can(self, id: Whole, data: BytesLike) -> None:
        """Write a frame to the CAN bus.

        Not in the manual. It is not known how it differs from `write_raw_data_can`.

        Args:
            id: its identifier, 0 to 0x1FFFFFFF.
            data: its bytes, at least one.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            BusError: the frame was not written.
        """
        self._runner.call(self._section.write_data_can(id, data))


class Frames(_Section):
    """Tools (工具), work objects (工件坐标系) and loads (负载), manual 1.3.7.

        robot.frames.set_tool_data("grip", [0, 0, 0.12, 0, 0, 0], Load(0.8, z=0.05))
        robot.frames.set_load_data(Load(1.5))      # what the gripper holds from now on

    Motions take the names of a tool and a work object, or use those that were set last. The
    controller uses the masses to hold the arm up in hand guiding and to detect collisions: set the
    real ones.
    """

    __slots__ = ()
    _section: AioFrames

    def set_tool_data(
        self,
        name: str,
        tool_offset: PoseLike,
        payload: Load | VectorLike,
        *,
        inertia_tensor: VectorLike = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Define a tool (设置工具末端相对于法兰面坐标系的偏移), and use it from now on.

        Motions that name it, or name no tool, use it.

        Args:
            name: its name, 1 to 32 bytes of UTF-8.
            tool_offset: pose of its tip in the flange's frame [m, rad].
            payload: mass of the tool, from 0, and its centre [kg, m]. A `Load`, or shape (4,).
            inertia_tensor: xx, xy, xz, yy, yz, zz [kg·m²]. Shape (6,).

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not defined.

        Manual section 1.3.7.
        """
        work = self._section.set_tool_data(
            name, tool_offset, payload, inertia_tensor=inertia_tensor
        )
        self._runner.call(work)

    def set_load_data(self, load: Load | VectorLike) -> None:
        """Set the load that the tool holds (设置抓取负载); this works while a program runs, too.

        Args:
            load: its mass, 0 to 35, and its centre in the tool's frame [kg, m]. A `Load`, or
                shape (4,).

        Raises:
            ParameterError: a number is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_load_data(load))

    def set_wobj(self, name: str, wobj: PoseLike) -> None:
        """Define a work object (工件坐标系).

        Not in the manual, which has only `set_wobj_offset`.

        Args:
            name: its name, 1 to 32 bytes of UTF-8.
            wobj: its pose in the base frame [m, rad].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not defined.
        """
        self._runner.call(self._section.set_wobj(name, wobj))

    def set_wobj_offset(self, wobj: PoseLike, active: bool) -> None:
        """Shift the work object of all later motions (工件坐标系偏移量), or end the shift.

        The work object's pose is multiplied by the offset from the right, so the offset is along
        the work object's own axes. It holds until it is ended, also for other programs.

        Args:
            wobj: the offset [m, rad].
            active: true to apply it, false for no offset.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_wobj_offset(wobj, active))

    def get_tcp_offset(self) -> Pose:
        """Read the pose of the tool in use in the flange's frame (工具的偏移量) [m, rad].

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_tcp_offset())

    def get_tool_load(self) -> Load:
        """Read mass and centre of mass of the tool in use (工具的负载质量及质心位置) [kg, m].

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_tool_load())

    def get_wobj(self) -> Pose:
        """Read the pose of the work object in use in the base frame (工件坐标系的值) [m, rad].

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_wobj())


class Kinematics(_Section):
    """Kinematics, as the controller computes it (manual 1.3.7).

    The controller uses the arm's calibration. `aioduco.kinematics` computes on this computer,
    without a controller, for the arm as designed.
    """

    __slots__ = ()
    _section: AioKinematics

    def cal_fkine(
        self, joints: JointsLike, *, tool: PoseLike | None = None, wobj: PoseLike | None = None
    ) -> Pose:
        """Compute the tool's pose at joint angles (正运动学).

        Args:
            joints: joint angles, -2π to 2π [rad]. Shape (6,).
            tool: pose of the tool in the flange's frame [m, rad]; None for the one in use.
            wobj: pose of the work object in the base frame [m, rad]; None for the one in use.

        Returns:
            The pose of the tool in the work object [m, rad].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.cal_fkine(joints, tool=tool, wobj=wobj))

    def cal_ikine(
        self,
        pose: PoseLike,
        *,
        q_near: JointsLike | None = None,
        tool: PoseLike | None = None,
        wobj: PoseLike | None = None,
    ) -> Joints:
        """Compute joint angles for a pose (逆运动学).

        For a pose out of reach, controllers return `q_near` itself. So this function puts the
        answer through `cal_fkine` and compares the result with the pose: another pose is an error.
        If you leave out `tool` or `wobj`, do not set another one during the call.

        Args:
            pose: pose of the tool in the work object [m, rad].
            q_near: joint angles, -2π to 2π [rad], near which a solution is looked for; None for
                the arm's present ones. Shape (6,).
            tool: pose of the tool in the flange's frame [m, rad]; None for the one in use.
            wobj: pose of the work object in the base frame [m, rad]; None for the one in use.

        Returns:
            The joints [rad].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Unreachable: the controller found no joints for the pose.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.cal_ikine(pose, q_near=q_near, tool=tool, wobj=wobj))

    def reach_check(
        self,
        *,
        base: PoseLike,
        wobj: PoseLike,
        tool: PoseLike,
        ref_pos: JointsLike,
        check_points: Iterable[PoseLike],
    ) -> Reachability:
        """Check whether an arm with a given pose of its base can reach poses (可达性).

        Manual 4.3 has `tool` before `wobj`: exchange them on such a controller.

        Args:
            base: pose of the arm's base in the world [m, rad].
            wobj: pose of the work object in the world [m, rad].
            tool: pose of the tool in the flange's frame [m, rad].
            ref_pos: joint angles near which solutions are looked for, -2π to 2π [rad].
                Shape (6,).
            check_points: poses of the tool in the work object [m, rad], at least one.

        Returns:
            Whether all poses can be reached, and if so the joints for each.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            ControllerError: the controller says that all can be reached, but does not send the
                joints, as a controller of manual 4.3 does.

        Manual section 1.3.7.
        """
        work = self._section.reach_check(
            base=base, wobj=wobj, tool=tool, ref_pos=ref_pos, check_points=check_points
        )
        return self._runner.call(work)

    def get_origin_DH(self) -> Vector:
        """Read the Denavit-Hartenberg parameters of the arm as designed (原始 DH 参数).

        A read-only array of shape (6, 4): a [m], alpha [rad], d [m], theta [rad] of each joint.
        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_origin_DH())

    def get_calib_DH(self) -> Vector:
        """Read the Denavit-Hartenberg parameters of this arm, calibrated (补偿后 DH 参数).

        A read-only array of shape (6, 4): a [m], alpha [rad], d [m], theta [rad] of each joint.
        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_calib_DH())


class Settings(_Section):
    """Speeds, collision detection, simulation, pendant (manual 1.3.7).

    These settings apply to all programs, and remain after the end of this one.
    """

    __slots__ = ()
    _section: AioSettings

    def speed(self, val: Real) -> None:
        """Set the global speed (全局速度百分比), which scales all motions.

        Args:
            val: percent, 1 to 100; fractions are allowed.

        Raises:
            ParameterError: it is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.speed(val))

    def get_global_speed(self) -> int:
        """Read the global speed (全局速度的百分比), in percent.

        The wire has whole numbers here: the fraction of a speed is lost.

        Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_global_speed())

    def set_teach_speed(self, v: Whole) -> None:
        """Set the speed of jogs (示教速度的百分比), which scales the speed of each jog.

        Args:
            v: percent, a whole number from 1 to 100.

        Raises:
            ParameterError: it is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_teach_speed(v))

    def get_teach_speed(self) -> int:
        """Read the speed of jogs (示教速度的百分比), in percent. Manual section 1.3.7."""
        return self._runner.call(self._section.get_teach_speed())

    def collision_detect(self, level: Whole) -> None:
        """Set the level of the collision detection (碰撞检测等级).

        Args:
            level: 0 for no detection, or 1 to 5.

        Raises:
            ParameterError: it is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.collision_detect(level))

    def collision_detection_reset(self) -> None:
        """Clear the alarm of a collision (重置碰撞检测警告).

        `Robot.recover` includes this step.

        Raises:
            TaskError: it was not cleared.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.collision_detection_reset())

    def simulation(self, sim: bool) -> None:
        """Switch between the controller's own simulation and the real arm (仿真或者真机模式).

        The simulation is for dry runs: motions run and the states that are read change, while the
        real arm stands. The simulated arm starts at the position of the real one. After switching
        back, read the real arm's position before the next motion: it has not moved.

        The arm must be completely at rest, or it moves in an unforeseen way and stops with an
        alarm. So this is refused while the arm moves. Make sure that no other program moves it.

        Args:
            sim: true for the simulation, false for the real arm.

        Raises:
            ParameterError: it is neither; nothing was sent.
            RobotStateError: the arm moves; nothing was sent.
            TaskError: it was not switched; the message contains the controller's reason.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.simulation(sim))

    def set_teach_pendant(self, enable: bool) -> None:
        """Turn the keys of the pendant on or off (示教器的物理按键).

        Args:
            enable: true for on.

        Raises:
            ParameterError: it is neither true nor false; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.7.
        """
        self._runner.call(self._section.set_teach_pendant(enable))


class Optimization(_Section):
    """How motions are optimized (运动优化函数, manual 1.3.11).

    These settings apply to all programs, and remain after the end of this one. The controller
    avoids singularities only while vibration control is off; it is on after the controller's start.
    """

    __slots__ = ()
    _section: AioOptimization

    def enable_speed_optimization(self) -> None:
        """Let the arm move as fast as its safety limits allow (开启速度优化).

        In automatic mode the speeds given to motions then have no effect: the arm moves faster.
        This optimizes accelerations as well.

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        self._runner.call(self._section.enable_speed_optimization())

    def disable_speed_optimization(self) -> None:
        """Let the arm move at the speeds given to motions (退出速度优化).

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        self._runner.call(self._section.disable_speed_optimization())

    def enable_acc_optimization(self) -> None:
        """Let the arm accelerate as hard as its drives can (开启加速度优化).

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        self._runner.call(self._section.enable_acc_optimization())

    def disable_acc_optimization(self) -> None:
        """Let the arm accelerate at the values given to motions (退出加速度优化).

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        self._runner.call(self._section.disable_acc_optimization())

    def enable_singularity_control(self) -> None:
        """Let Cartesian motions go around singularities (开启奇异点规避).

        Near a singularity the arm changes over to a joint motion, and leaves the path a little.
        This has no effect while vibration control is on.

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        self._runner.call(self._section.enable_singularity_control())

    def disable_singularity_control(self) -> None:
        """Let Cartesian motions stop with an alarm near singularities (退出奇异点规避).

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        self._runner.call(self._section.disable_singularity_control())

    def enable_vibration_control(self) -> None:
        """Damp vibrations as motions start and end (开启振动控制), the controller's default.

        It makes each motion 200 to 400 ms longer.

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        self._runner.call(self._section.enable_vibration_control())

    def disable_vibration_control(self) -> None:
        """Do not damp vibrations as motions start and end (退出振动控制).

        This setting remains after the end of the program.

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        self._runner.call(self._section.disable_vibration_control())


class Force(_Section):
    """Force control (力控函数, manual 1.3.10): motions give way to the force at the tool.

        z = (False, False, True, False, False, False)
        robot.force.fc_config(z, ref_ft=(0, 0, -10, 0, 0, 0), damp=damping, max_vel=slow)
        robot.force.fc_start()
        robot.force.fc_wait_ft(target, tolerance, absolute=True, duration=0.2, timeout=30)
        robot.force.fc_wait_logic((0, 0, 1))
        robot.force.fc_move()                # presses until the condition holds
        robot.force.fc_stop()

    It needs a force sensor that is mounted, connected and set up: with a wrong setup the arm
    moves in an unforeseen way. Force control acts only while a motion runs, such as `fc_move`; a
    stop ends the motion, and the arm stands. Force control itself stays on until `fc_stop`: the
    next motion gives way, too. Leaving the robot's block ends it once the arm stands; if the
    program is killed, it stays on.

    Vectors have the components along x, y, z, then those about x, y, z. Shape (6,).
    """

    __slots__ = ()
    _section: AioForce

    def fc_start(self) -> None:
        """Start force control (开启机器人末端力控): motions give way from now on.

        Raises:
            TaskError: it was not started.

        Manual section 1.3.10.
        """
        self._runner.call(self._section.fc_start())

    def fc_stop(self) -> None:
        """End force control (退出机器人末端力控).

        All motions must have ended, or the arm moves in an unforeseen way and stops with an
        alarm. So this is refused while the arm moves. Make sure that no other program moves it.

        Raises:
            RobotStateError: the arm moves; nothing was sent.
            TaskError: it was not ended.

        Manual section 1.3.10.
        """
        self._runner.call(self._section.fc_stop())

    def fc_config(
        self,
        direction: FlagsLike,
        ref_ft: VectorLike,
        damp: VectorLike,
        max_vel: VectorLike,
        *,
        dead_band: VectorLike = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        tool: str = '',
        wobj: str = '',
        frame: ForceFrame | int = 0,
    ) -> None:
        """Set how motions give way (配置机器人末端力控参数).

        The speed at which the arm gives way is the difference between the force and `ref_ft`,
        divided by `damp`, and at most `max_vel`.

        Args:
            direction: whether the arm gives way in each direction. Shape (6,).
            ref_ft: force that the arm maintains, -1000 to 1000 [N, N·m]. Shape (6,).
            damp: damping, above 0 in directions that give way [N/(m/s), N·m/(rad/s)]; 1000 to
                2000 and 57 are usual. Shape (6,).
            max_vel: largest speed, -5 to 5 [m/s, rad/s]; 0.03 to 0.15 m/s are usual. Shape (6,).
            dead_band: force difference below which the arm does not give way, -1000 to 1000
                [N, N·m]. The manual calls it number_list. Shape (6,).
            tool: name of the tool about whose tip the arm gives way; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            frame: frame of the directions, a `ForceFrame`: 0 the tool's, 1 the work object's.
                The manual calls it type.

        Raises:
            ParameterError: an argument is out of range, or a direction that gives way has no
                damping; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        work = self._section.fc_config(
            direction, ref_ft, damp, max_vel, dead_band=dead_band, tool=tool, wobj=wobj, frame=frame
        )
        self._runner.call(work)

    @moves
    def fc_move(self) -> aio_command.MotionCommand:
        """Move by force control alone (仅基于末端力控产生的补偿运动).

        It ends by itself only if a condition (`fc_wait_logic`) comes to hold.
        An interrupt while it waits stops the arm.

        Returns:
            How it ended: finished or blended.

        Manual section 1.3.10.
        """
        return self._section.fc_move()

    def fc_guard_act(
        self,
        direction: FlagsLike,
        ref_ft: VectorLike,
        *,
        tool: str = '',
        wobj: str = '',
        frame: ForceFrame | int = 0,
        force_property: GuardedForce | int = 0,
    ) -> None:
        """Monitor the force in force control (力安全监控): too large a force is an emergency stop.

        Args:
            direction: whether the force is monitored in each direction. Shape (6,).
            ref_ft: largest allowed force in both senses, from 0 [N, N·m]. Shape (6,).
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            frame: frame of the directions, a `ForceFrame`: 0 the tool's, 1 the work object's.
                The manual calls it type.
            force_property: a `GuardedForce`: 0 load and external force, 1 external force alone.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: the force is not monitored.

        Manual section 1.3.10.
        """
        work = self._section.fc_guard_act(
            direction, ref_ft, tool=tool, wobj=wobj, frame=frame, force_property=force_property
        )
        self._runner.call(work)

    def fc_guard_deact(self) -> None:
        """End the monitoring of the force (禁用力安全监控).

        Raises:
            TaskError: the force is still monitored.

        Manual section 1.3.10.
        """
        self._runner.call(self._section.fc_guard_deact())

    def fc_force_set_value(self, direction: FlagsLike, ref_ft: VectorLike) -> None:
        """Set the force sensor's present reading (力传感器读数设置为指定值), to tare it.

        Args:
            direction: whether the reading is set in each direction of the sensor. Shape (6,).
            ref_ft: the new reading [N, N·m]. Shape (6,).

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        self._runner.call(self._section.fc_force_set_value(direction, ref_ft))

    def fc_wait_pos(
        self,
        middle: VectorLike,
        range: VectorLike,
        *,
        absolute: bool,
        duration: Real,
        timeout: Real,
    ) -> None:
        """Set the condition on position (位置判断条件) under which motions end in force control.

        It returns at once. When the conditions, combined as `fc_wait_logic` says, hold, the
        running motion ends. Later motions are skipped until `fc_stop` or the next `fc_wait_logic`.

        Args:
            middle: middle of the range [m, rad]. Shape (6,).
            range: width of the range [m, rad], larger than the noise; 0 takes the axis out of the
                condition. The manual does not say whether it is the half width, to each side of
                `middle`, or the full width. Shape (6,).
            absolute: true for the value itself, false for its change since the last
                `fc_wait_logic`.
            duration: time for which the condition must hold, from 0 [s].
            timeout: time after the last `fc_wait_logic` when the controller gives up, from 0 [s].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        work = self._section.fc_wait_pos(
            middle, range, absolute=absolute, duration=duration, timeout=timeout
        )
        self._runner.call(work)

    def fc_wait_vel(
        self,
        middle: VectorLike,
        range: VectorLike,
        *,
        absolute: bool,
        duration: Real,
        timeout: Real,
    ) -> None:
        """Set the condition on speed (速度判断条件) under which motions end in force control.

        It returns at once. When the conditions, combined as `fc_wait_logic` says, hold, the
        running motion ends. Later motions are skipped until `fc_stop` or the next `fc_wait_logic`.

        Args:
            middle: middle of the range, -5 to 5 and -2π to 2π [m/s, rad/s]. Shape (6,).
            range: width of the range [m/s, rad/s], larger than the noise; 0 takes the axis out of
                the condition. The manual does not say whether it is the half width, to each side
                of `middle`, or the full width. Shape (6,).
            absolute: true for the value itself, false for its change since the last
                `fc_wait_logic`.
            duration: time for which the condition must hold, from 0 [s].
            timeout: time after the last `fc_wait_logic` when the controller gives up, from 0 [s].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        work = self._section.fc_wait_vel(
            middle, range, absolute=absolute, duration=duration, timeout=timeout
        )
        self._runner.call(work)

    def fc_wait_ft(
        self,
        middle: VectorLike,
        range: VectorLike,
        *,
        absolute: bool,
        duration: Real,
        timeout: Real,
    ) -> None:
        """Set the condition on force (力判断条件) under which motions end in force control.

        It returns at once. When the conditions, combined as `fc_wait_logic` says, hold, the
        running motion ends. Later motions are skipped until `fc_stop` or the next `fc_wait_logic`.

        Args:
            middle: middle of the range, -1000 to 1000 [N, N·m]. Shape (6,).
            range: width of the range [N, N·m], larger than the noise; 0 takes the axis out of the
                condition. The manual does not say whether it is the half width, to each side of
                `middle`, or the full width. Shape (6,).
            absolute: true for the value itself, false for its change since the last
                `fc_wait_logic`.
            duration: time for which the condition must hold, from 0 [s].
            timeout: time after the last `fc_wait_logic` when the controller gives up, from 0 [s].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        work = self._section.fc_wait_ft(
            middle, range, absolute=absolute, duration=duration, timeout=timeout
        )
        self._runner.call(work)

    def fc_wait_logic(self, logic: WholesLike | tuple[ForceLogic, ...]) -> None:
        """Combine the conditions, and restart them (条件判断间的逻辑关系).

        Args:
            logic: a `ForceLogic` each for position, speed and force: 0 off, 1 and, 2 or.
                Shape (3,).

        Raises:
            ParameterError: `logic` is something else; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        self._runner.call(self._section.fc_wait_logic(logic))

    def fc_get_ft(self) -> Vector:
        """Read the force sensor (末端传感器的原始反馈读数), tared, in its own frame [N, N·m].

        A read-only array of shape (6,). The sensor is tared when the arm is enabled or disabled,
        and by `fc_force_set_value`. Manual section 1.3.10.
        """
        return self._runner.call(self._section.fc_get_ft())

    def fc_mode_is_active(self) -> bool:
        """Tell whether force control is on (末端力控功能启用状态). Manual section 1.3.10."""
        return self._runner.call(self._section.fc_mode_is_active())


class Modbus(_Section):
    """Signals that the controller exchanges over Modbus (Modbus, manual 1.3.9).

    A signal is a register or a coil of a device. It has a name in the controller, which polls it.
    For Modbus over the tool's RS-485 see `robot.bus`.
    """

    __slots__ = ()
    _section: AioModbus

    def modbus_read(self, signal_name: str) -> int:
        """Read the last value of a signal that the controller polled (读取 modbus 节点).

        Args:
            signal_name: its name.

        Returns:
            0 to 65535 for a register, 0 or 1 for a coil or an input.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            Refused: the controller answers -1: there is no such signal, or its device does not
                answer.

        Manual section 1.3.9.
        """
        return self._runner.call(self._section.modbus_read(signal_name))

    def modbus_write(self, signal_name: str, value: Whole) -> None:
        """Write a signal (modbus 节点写操作).

        Args:
            signal_name: its name.
            value: 0 to 65535 for a register, 0 or 1 for a coil.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not written.

        Manual section 1.3.9.
        """
        self._runner.call(self._section.modbus_write(signal_name, value))

    def modbus_set_frequency(self, signal_name: str, frequency: Whole) -> None:
        """Set how often the controller reads a signal (刷新频率).

        Args:
            signal_name: its name.
            frequency: polls per second, 1 to 100 [Hz]; the controller's default is 10.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Refused: the controller lists an error: there is no such signal. The wire has no answer
                to this function, so the error list is the only sign of a failure.

        Manual section 1.3.9.
        """
        self._runner.call(self._section.modbus_set_frequency(signal_name, frequency))

    def modbus_write_multiple_regs(
        self, slave_num: Whole, name: str, word_list: WholesLike
    ) -> None:
        """Write consecutive registers (多寄存器写操作).

        The name of a signal selects the device and the first address; `slave_num` selects the unit
        at that device. Registers are written whatever the signal is: the manual's examples write
        registers and coils of two units by one name. The manual does not say more.

        Args:
            slave_num: number of the unit, 0 to 255.
            name: name of a signal at the first register's address.
            word_list: values to write, at least one, each 0 to 65535, or -32768 to -1 for the
                upper half.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: the registers were not written.

        Manual section 1.3.9.
        """
        self._runner.call(self._section.modbus_write_multiple_regs(slave_num, name, word_list))

    def modbus_write_multiple_coils(
        self, slave_num: Whole, name: str, byte_list: WholesLike
    ) -> None:
        """Write consecutive coils (多线圈写操作).

        Device, unit and first address are selected as in `modbus_write_multiple_regs`.

        Args:
            slave_num: number of the unit, 0 to 255.
            name: name of a signal at the first coil's address.
            byte_list: values to write, at least one, each 0 or 1.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: the coils were not written.

        Manual section 1.3.9.
        """
        self._runner.call(self._section.modbus_write_multiple_coils(slave_num, name, byte_list))

    def modbus_add_signal(
        self,
        ip: str,
        slave_number: Whole,
        signal_address: Whole,
        signal_type: Whole,
        signal_name: str,
    ) -> None:
        """Add a signal to those that the controller exchanges.

        Not in the manual: the meaning of the types' numbers is not known.

        Args:
            ip: address of the device.
            slave_number: number of the device, 0 to 255.
            signal_address: address of the register or coil, 0 to 65535.
            signal_type: number of the type.
            signal_name: name for the signal.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not added.
        """
        work = self._section.modbus_add_signal(
            ip, slave_number, signal_address, signal_type, signal_name
        )
        self._runner.call(work)

    def modbus_delete_signal(self, signal_name: str) -> None:
        """Remove a signal from those that the controller exchanges.

        Not in the manual.

        Args:
            signal_name: its name.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            TaskError: it was not deleted.
        """
        self._runner.call(self._section.modbus_delete_signal(signal_name))


class Log(_Section):
    """The controller's log and its pendant (调试相关, manual 1.3.8)."""

    __slots__ = ()
    _section: AioLog

    def log_info(self, message: str) -> None:
        """Write a message into the controller's log (插入 log 日志).

        Args:
            message: its text.

        Raises:
            ParameterError: it is no text; nothing was sent.

        Manual section 1.3.8.
        """
        self._runner.call(self._section.log_info(message))

    def log_error(self, message: str) -> None:
        """Show a message on the pendant, and pause all tasks (产生弹窗, 并暂停当前所有任务).

        Motions of this program pause as well; `Robot.resume` resumes them.

        Args:
            message: its text.

        Raises:
            ParameterError: it is no text; nothing was sent.

        Manual section 1.3.8.
        """
        self._runner.call(self._section.log_error(message))


class Service(_Section):
    """Functions of the factory and of service technicians. None of them is in the manual.

    Warning:
        They change how the joints are driven, and the position that the controller computes for
        the arm. A wrong value can make the arm move in an unforeseen way, or damage it, and may
        persist after a restart. The meaning of the numbers is not published: use them only with the
        vendor's instructions for this arm, and keep out of its reach.
    """

    __slots__ = ()
    _section: AioService

    def set_servo_config(self, axis_num: Whole, id: Whole, value: Whole, qfmt: Whole) -> None:
        """Set a parameter of an axis' servo drive.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            axis_num: number of the axis, from 0.
            id: number of the parameter.
            value: its value.
            qfmt: format of the value.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.set_servo_config(axis_num, id, value, qfmt))

    def apply_servo_config(self, axis_num: Whole) -> None:
        """Make an axis' servo drive use its parameters.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            axis_num: number of the axis, from 0.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.apply_servo_config(axis_num))

    def set_servo_file_params(
        self, axis_num: Whole, id: Whole, name: str, value: Real, qfmt: Real
    ) -> None:
        """Set a parameter in the file of an axis' servo drive.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            axis_num: number of the axis, from 0.
            id: number of the parameter.
            name: its name.
            value: its value.
            qfmt: format of the value.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.set_servo_file_params(axis_num, id, name, value, qfmt))

    def set_dynamic_calibration_params(self, params: Iterable[VectorLike]) -> None:
        """Set the parameters of the dynamic calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            params: a table of numbers.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.set_dynamic_calibration_params(params))

    def set_kinematic_calibration_params(self, params: Iterable[VectorLike]) -> None:
        """Set the parameters of the kinematic calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            params: a table of numbers.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.set_kinematic_calibration_params(params))

    def set_dynamic_calibration_info(self, passwd: str, info: str) -> None:
        """Set the notes to the dynamic calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.
            info: the notes.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.set_dynamic_calibration_info(passwd, info))

    def set_kinematic_calibration_info(self, passwd: str, info: str) -> None:
        """Set the notes to the kinematic calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.
            info: the notes.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.set_kinematic_calibration_info(passwd, info))

    def set_vibration_calibration_info(self, passwd: str, info: str) -> None:
        """Set the notes to the vibration calibration.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.
            info: the notes.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.set_vibration_calibration_info(passwd, info))

    def save_dynamic_calibration_params(self, passwd: str) -> None:
        """Save the parameters of the dynamic calibration for good.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.save_dynamic_calibration_params(passwd))

    def save_kinematic_calibration_params(self, passwd: str) -> None:
        """Save the parameters of the kinematic calibration for good.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.save_kinematic_calibration_params(passwd))

    def upload_robot_param_to_toolboard(self, passwd: str) -> None:
        """Write the robot's parameters to the board in the tool flange.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            passwd: the password for it.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.upload_robot_param_to_toolboard(passwd))

    def set_pendant_type(self, type: Whole) -> None:
        """Set the kind of the pendant.

        Not in the manual.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.

        Args:
            type: number of the kind.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not done.
        """
        self._runner.call(self._section.set_pendant_type(type))

    def change_recipe(self) -> None:
        """Change the recipe.

        Not in the manual: it is not known what a recipe is, or which one follows.

        Warning:
            A wrong value can damage the arm, or make it move in an unforeseen way.
        """
        self._runner.call(self._section.change_recipe())

    def get_dynamic_calibration_params(self) -> tuple[Vector, ...]:
        """Read the parameters of the dynamic calibration: a read-only array for each row.

        Not in the manual.
        """
        return self._runner.call(self._section.get_dynamic_calibration_params())

    def get_vibration_calibration_params(self) -> tuple[Vector, ...]:
        """Read the parameters of the vibration calibration: a read-only array for each row.

        Not in the manual.
        """
        return self._runner.call(self._section.get_vibration_calibration_params())

    def get_axis_motor_kt(self) -> Vector:
        """Read the torque constants of the axes' motors, as a read-only array.

        Not in the manual, and neither is the unit.
        """
        return self._runner.call(self._section.get_axis_motor_kt())

    def get_axis_motor_rated_current(self) -> Vector:
        """Read the rated currents of the axes' motors, as a read-only array.

        Not in the manual, and neither is the unit.
        """
        return self._runner.call(self._section.get_axis_motor_rated_current())

    def get_pos_bias(self) -> Vector:
        """Read the biases of the positions of the axes, as a read-only array.

        Not in the manual, and neither is the unit.
        """
        return self._runner.call(self._section.get_pos_bias())

    def get_axis_ratio(self) -> tuple[int, ...]:
        """Read the gear ratios of the axes.

        Not in the manual.
        """
        return self._runner.call(self._section.get_axis_ratio())

    def get_motor_pole_pair_number(self) -> tuple[int, ...]:
        """Read the numbers of pole pairs of the axes' motors.

        Not in the manual.
        """
        return self._runner.call(self._section.get_motor_pole_pair_number())

    def get_motor_stator_slots(self) -> tuple[int, ...]:
        """Read the numbers of stator slots of the axes' motors.

        Not in the manual.
        """
        return self._runner.call(self._section.get_motor_stator_slots())


class Version(_Section):
    """Type of the arm, version of the controller's software (manual 1.3.7)."""

    __slots__ = ()
    _section: AioVersion

    @property
    def controller(self) -> ControllerVersion:
        """The version of the controller's software, which was read while connecting.

        Unknown before that, and if the controller does not report it.
        """
        return self._section.controller

    def get_robot_version(self) -> str:
        """Read the version of the controller's software (控制器版本).

        `controller` has the version already. Manual section 1.3.16.
        """
        return self._runner.call(self._section.get_robot_version())

    def get_robot_type(self) -> RobotType:
        """Read series, model, extension and serial number (机器人系列号, 型号, SN).

        A value that the controller leaves out is empty. Manual section 1.3.7.
        """
        return self._runner.call(self._section.get_robot_type())


class Sections(ManualNames):
    """The sections of a robot, and what it does.

    Attributes:
        system: power, brakes, operation mode.
        motion: motions, jogs, hand guiding, joint trajectories.
        servo: streams of positions to follow.
        speed: streams of speeds.
        program: programs and files of the controller.
        track: the track pool, and streams into it.
        compound: the weave that is superimposed on motions.
        external_axes: external axes.
        realtime: streams through the realtime queue, and the queue call by call.
        state: state of the arm and of the controller.
        io: inputs and outputs.
        registers: registers and variables of the controller.
        bus: RS-485 and CAN.
        frames: tools, work objects, loads.
        kinematics: kinematics, as the controller computes it.
        settings: speeds, collision detection, simulation, pendant.
        optimization: how motions are optimized.
        force: force control.
        modbus: signals over Modbus.
        log: the controller's log and its pendant.
        service: functions for the factory: only to be used by its instructions.
        version: type of the arm, version of the software.
    """

    def __init__(self, runner: Runner, robot: aio_robot.Robot) -> None:
        self._runner = runner
        self._robot = robot
        self.system: System = System(runner, robot.system)
        self.motion: Motion = Motion(runner, robot.motion)
        self.servo: Servo = Servo(runner, robot.servo)
        self.speed: Speed = Speed(runner, robot.speed)
        self.program: Program = Program(runner, robot.program)
        self.track: Track = Track(runner, robot.track)
        self.compound: Compound = Compound(runner, robot.compound)
        self.external_axes: ExternalAxes = ExternalAxes(runner, robot.external_axes)
        self.realtime: Realtime = Realtime(runner, robot.realtime)
        self.state: State = State(runner, robot.state)
        self.io: IO = IO(runner, robot.io)
        self.registers: Registers = Registers(runner, robot.registers)
        self.bus: Bus = Bus(runner, robot.bus)
        self.frames: Frames = Frames(runner, robot.frames)
        self.kinematics: Kinematics = Kinematics(runner, robot.kinematics)
        self.settings: Settings = Settings(runner, robot.settings)
        self.optimization: Optimization = Optimization(runner, robot.optimization)
        self.force: Force = Force(runner, robot.force)
        self.modbus: Modbus = Modbus(runner, robot.modbus)
        self.log: Log = Log(runner, robot.log)
        self.service: Service = Service(runner, robot.service)
        self.version: Version = Version(runner, robot.version)

    def bring_up(self, *, timeout: float = 30.0) -> RobotStates:
        """Bring the arm into a state in which it can move: power on, enable, clear.

        A safety stop is cleared by powering off and on, a collision by its reset, a paused
        program by a stop. Each step is taken when the controller's states require it, and has
        ended when they show its effect.

        Args:
            timeout: seconds in which the arm must be ready.

        Returns:
            The states: enabled, with no program running.

        Raises:
            RobotStateError: a person has to do something first, such as to release the emergency
                stop; or the arm is not ready in time. The message says which.
        """
        return self._runner.call(self._robot.bring_up(timeout=timeout))

    def recover(self, *, timeout: float = 30.0) -> RobotStates:
        """Bring the arm out of a stop: clear, power off and on if needed, enable.

        It works as `bring_up`. In addition, it ends a program that runs in the controller, and
        restarts a heartbeat that was withheld. It moves nothing.

        Args:
            timeout: seconds in which the arm must be ready.

        Returns:
            The states: enabled, with no program running.

        Raises:
            PersonNeeded: a person has to do something first: the message says what.
            RobotStateError: the arm is not ready in time.
            HeartbeatLost: no heartbeat was answered.
        """
        return self._runner.call(self._robot.recover(timeout=timeout))

    def wait_for(
        self, predicate: Callable[[Snapshot], bool], *, timeout: float | None = None
    ) -> Snapshot:
        """Wait for a sample of the state for which the predicate is true, and return it.

            robot.wait_for(lambda s: s.io.input(3), timeout=5.0)

        Args:
            predicate: called with each new sample.
            timeout: seconds for which to wait; None for no limit.

        Raises:
            TimeoutError: no such sample came in time.
            RobotStateError: the robot was closed meanwhile.
        """
        return self._runner.call(self._robot.wait_for(predicate, timeout=timeout))

    def stop(self) -> None:
        """Stop the arm, all tasks included (停止所有任务), and wait until it stands.

        The stop never waits behind another call. It is repeated over fresh connections until the
        controller accepts it, and continues to its end even if this is interrupted. It also applies
        to a motion that is on its way to the controller. The awaits of running motions raise
        `TaskStopped`.

        Raises:
            StopUnconfirmed: it is not known that the arm stands: press the emergency stop.

        Manual section 1.3.3.
        """
        self._runner.call(self._robot.stop())

    def pause(self) -> None:
        """Pause all tasks (暂停所有任务), and wait until the arm stands.

        Raises:
            TaskError: the controller did not pause.
            StopUnconfirmed: the arm does not stand.

        Manual section 1.3.3.
        """
        self._runner.call(self._robot.pause())

    def resume(self) -> None:
        """Resume all paused tasks (恢复所有暂停的任务).

        Raises:
            TaskError: the controller did not resume.

        Manual section 1.3.3.
        """
        self._runner.call(self._robot.resume())

    def abort(self) -> None:
        """End the running motion and those read ahead, and wait until the arm stands.

        Manual 3.8 does not have it, but its wire does; manual 4.3 describes it.

        Raises:
            TaskError: the controller did not abort.
            StopUnconfirmed: the arm does not stand.
        """
        self._runner.call(self._robot.abort())

    def rearm_heartbeat(self, *, timeout: float = 2.0) -> None:
        """Resume the heartbeat after the event loop hung and the heartbeat was withheld.

        The controller has stopped the arm by then. This moves nothing; afterwards motions may be
        started again.

        Args:
            timeout: seconds within which a beat must be answered.

        Raises:
            ParameterError: the time is not above 0.
            HeartbeatLost: no beat was answered in time.
        """
        self._runner.call(self._robot.rearm_heartbeat(timeout=timeout))
