"""Lead a robot along a recorded path, and through waypoints.

Guarantees:
- A path or file is checked before anything is sent.
- A path is followed by a stream, which brings the arm to rest when the call is cancelled or the
  program dies. Waypoints are motions, which are stopped in that case. So the arm always stands
  afterwards.
- No output is set after a cancellation.
"""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import anyio
import numpy as np

from aioduco._process.threads import in_thread
from aioduco.errors import (
    DucoError,
    FirstPointTooFar,
    ParameterError,
    PathRefused,
    UnknownFunction,
)
from aioduco.kinematics.catalogue import arm_given, arm_named, model_named, same_arm
from aioduco.models.ranges import JOINT_SPEED
from aioduco.models.rules import Number
from aioduco.recording.playback.path_check import (
    PathFinding,
    check_path,
    check_waypoints,
    fastest,
    sharpest,
)
from aioduco.recording.playback.recorded_path import RecordedOutput, RecordedPath
from aioduco.recording.playback.waypoints import Waypoint, WaypointFile
from aioduco.streaming.joint_trajectory import (
    Feedback,
    Tolerances,
    TrajectoryResult,
    check_following,
)
from aioduco.streaming.shared.options import checked
from aioduco.supervision.permits import asked_at_call

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Sequence

    from aioduco.envelope import Envelope
    from aioduco.kinematics import Arm
    from aioduco.robot import Robot
    from aioduco.streaming.shared.options import WorkerOptions
    from aioduco.supervision.command import MotionCommand


_SHARE = Number(0.0, 1.0, open_low=True, source="this package")
_NEAR = 0.01  # largest distance of a joint from the begin of the path [rad]
_ROOM = 1.5  # factor on the stream's acceleration limit, so that it does not round the path
_LEAST = 0.5  # least acceleration limit of a stream [rad/s²]
_TOLERANCES = Tolerances(path=0.05, goal=0.005)


@asked_at_call
async def play(
    robot: Robot,
    path: RecordedPath,
    *,
    approach: float | None = None,
    outputs: bool = False,
    arm: Arm | str | None = None,
    through: str = "auto",
    tolerances: Tolerances | None = None,
    feedback: Callable[[Feedback], object] | None = None,
    options: WorkerOptions | None = None,
) -> TrajectoryResult:
    """Check a recorded path, and lead the arm along it to its end, under supervision.

    A cancellation brings the arm to rest on the path before it is raised.

    Args:
        robot: the robot, open and brought up.
        path: the path.
        approach: joint speed of one joint motion that first moves the arm to the begin of the path
            [rad/s]; None: the arm must already be there, within 0.01 rad for each joint.
        outputs: whether to set the cabinet's digital outputs that changed on the way, not before or
            after it, with an error of about 0.1 s. With the realtime queue they are set early, by
            the time that points are sent ahead. If an output cannot be set, the arm is brought to
            rest.
        arm: the arm, or the name of its model; None for the one that the controller reports.
        through: as for `robot.motion.follow_joint_trajectory`.
        tolerances: largest distance of the arm from the path; None: 0.05 rad, and 5 mrad at its
            end.
        feedback: called about 50 times a second with the arm's place on the path.
        options: options of the stream's worker.

    Returns:
        How accurately the arm followed the path.

    Raises:
        PathRefused: another arm was recorded, or the path is beyond a limit or the envelope, or
            something had happened to the recorded arm: nothing was sent.
        FirstPointTooFar: the arm is not at the begin of the path; nothing was sent.
        ParameterError: an argument is not allowed; nothing was sent.
        PathToleranceViolated: the arm strayed from the path; it was brought to rest.
        GoalToleranceViolated: the arm did not come close enough to the path's end.
        Refused: an output was not set; the arm was brought to rest.
        RobotStateError: something else moves the arm; nothing was sent.
        StreamError: the stream ended for another reason, which the message names.
    """
    if not isinstance(path, RecordedPath):
        raise ParameterError("path", path, "a RecordedPath")
    check_following(through, tolerances, feedback)  # before the arm moves to the begin
    options = checked(options)
    robot.permit("play")  # refused if it was stopped before it began
    found = await check_path_on(robot, path, arm=arm)
    if found:
        raise refused(path.source.name, [str(each) for each in found])
    with robot.permit("play"):
        # a pause while the arm stands ends it: nothing is paused that would go on by a resume
        with robot._permits.from_now("play"):
            here = np.asarray(await robot.state.get_actual_joints_position())
            if approach is not None and np.abs(here - path.start.array).max() > _NEAR / 10:
                await robot.motion.movej2(path.start, v=approach, a=2.0 * approach)
        with robot._permits.from_now("play"):
            async with _outputs(robot, path.outputs if outputs else (), feedback) as told:
                return await follow(
                    robot.motion,
                    robot.state.get_actual_joints_position,
                    path,
                    through=through,
                    tolerances=tolerances,
                    feedback=told,
                    options=options,
                )


async def check_path_on(
    robot: Robot,
    path: RecordedPath,
    *,
    arm: Arm | str | None = None,
    envelope: Envelope | None = None,
) -> tuple[PathFinding, ...]:
    """Find reasons against leading a robot's arm along a path. This moves nothing.

    Args:
        robot: the robot, open.
        path: the path.
        arm: the arm, or the name of its model; None for the one that the controller reports.
        envelope: the limits that the path must keep; None: those of `robot.envelope`.

    Raises:
        ParameterError: the controller reports no known model, and none is given.
    """
    told, there = await reported_arm(robot)
    found: tuple[PathFinding, ...] = ()
    if other := for_another_arm(path.arm, told):
        found += (PathFinding("arm", path.begin, other),)
    kind = there if arm is None else arm_given("arm", arm)
    if kind is None:
        raise ParameterError("arm", told or None, "given: the controller does not tell a known one")
    limits = envelope or robot.envelope
    tool = [0.0] * 6 if limits is None else list(await robot.frames.get_tcp_offset())
    # in a thread, as all that looks at each millisecond: the event loop must run meanwhile
    return found + await in_thread(
        lambda: check_path(path, kind, envelope=limits, tool=tool), abandon_on_cancel=True
    )


async def reported_arm(robot: Robot) -> tuple[str, Arm | None]:
    """The arm that a controller reports: its name, and its model if that is known."""
    try:
        name = arm_named(await robot.version.get_robot_type())
    except UnknownFunction:
        name = ""
    return name, model_named(name)


def for_another_arm(made_with: str, this: str) -> str:
    """Why what one arm has recorded or was taught is not for this one; empty if it may be."""
    if not made_with or not this or same_arm(made_with, this):
        return ""
    return f"it is for a {made_with}, and this is a {this}"


def refused(name: str, found: Sequence[str]) -> PathRefused:
    """The error for findings."""
    return PathRefused(
        f"{name} was not played, and nothing was sent: {'; '.join(found)}", tuple(found)
    )


async def follow(
    motion: Any,
    read_joints: Any,
    path: RecordedPath,
    *,
    watch: object = None,
    planner: object = None,
    tolerances: Tolerances | None = None,
    **options: Any,
) -> TrajectoryResult:
    """Follow a checked path by `robot.motion`: see `play`."""
    if watch is not None or planner is not None:
        raise ParameterError("watch", watch, "left out: no plan is made for a recorded path")
    far = np.abs(np.asarray(await read_joints()) - path.start.array)
    if far.max() > _NEAR:
        joint = int(far.argmax())
        raise FirstPointTooFar(
            f"the path begins at another place: joint {joint + 1} is {far[joint]:.4f} rad from "
            "there; nothing was sent. Move the arm to path.start, or play with approach"
        )
    trajectory, v, a = await in_thread(
        lambda: (path.trajectory, fastest(path), sharpest(path)), abandon_on_cancel=True
    )
    result: TrajectoryResult = await motion.follow_joint_trajectory(
        trajectory,
        v=min(max(1.05 * v, 0.05), JOINT_SPEED.high),
        a=max(_ROOM * a, _LEAST),
        tolerances=_TOLERANCES if tolerances is None else tolerances,
        reach=2.0 * _NEAR,
        **options,
    )
    return result


@asynccontextmanager
async def _outputs(
    robot: Robot,
    changes: Sequence[RecordedOutput],
    feedback: Callable[[Feedback], object] | None,
) -> AsyncIterator[Callable[[Feedback], object] | None]:
    """Set outputs while the path is followed; yields the callback for feedback."""
    if not changes:
        yield feedback
        return
    wake = anyio.Event()
    now = -np.inf  # nothing is due before the arm is led

    def told(at: Feedback) -> None:
        nonlocal now, wake
        now = at.time
        wake.set()
        if feedback is not None:
            feedback(at)

    error: Exception | None = None
    async with anyio.create_task_group() as tasks:

        async def watch() -> None:
            nonlocal wake, error
            try:
                for change in changes:
                    while change.time > now:
                        await wake.wait()
                        wake = anyio.Event()
                    await robot.io.set_standard_digital_out(change.num, change.value)
            except DucoError as exc:  # raised below, outside of the group
                error = exc
                tasks.cancel_scope.cancel()

        tasks.start_soon(watch)
        try:
            yield told
        except Exception as exc:
            error = exc
            tasks.cancel_scope.cancel()
        else:  # what is left is due: it is set before the group ends
            now = np.inf
            wake.set()
    if error is not None:
        raise error


# -- waypoints -----------------------------------------------------------------------------------


@asked_at_call
async def run_waypoints(
    robot: Robot, waypoints: WaypointFile, *, arm: Arm | str | None = None, speed: float = 1.0
) -> int:
    """Move the arm through the waypoints of a file, one after another.

    Waypoints with a blend radius are sent ahead, so that the arm passes them without stopping. The
    arm stops at a waypoint with a dwell time or with outputs; a pause while it stands there ends
    this, since nothing is paused that a resume would continue. A cancellation stops the arm.

    Args:
        robot: the robot, open and brought up.
        waypoints: the file.
        arm: the arm, or the name of its model; None for the one that the controller reports.
        speed: factor for the speeds of the file, above 0 to 1.

    Returns:
        Number of waypoints that were reached.

    Raises:
        PathRefused: the file is for another arm, or a waypoint is beyond a joint limit; nothing
            was sent.
        ParameterError: an argument is out of range; nothing was sent.
        EnvelopeViolated: a motion would leave `robot.envelope`: it was not sent.
        TaskError: a motion did not succeed; the arm stands.
    """
    if not isinstance(waypoints, WaypointFile):
        raise ParameterError("waypoints", waypoints, "a WaypointFile")
    speed = _SHARE("speed", speed)
    robot.permit("run_waypoints")  # refused if it was stopped before it began
    found = await check_waypoints_on(robot, waypoints, arm=arm)
    if found:
        raise refused(waypoints.title, found)
    # all motions are made first: arguments that are not allowed are found before the arm moves
    motions: list[MotionCommand] = []
    for waypoint in waypoints.waypoints:
        motions.append(await _motion(robot, waypoint, speed))
        # if it is not sent, the error that prevents it is report enough
        motions[-1].mark_used()
    # a stop ends them all from now on, also during a dwell
    with robot.permit("run_waypoints"):
        ahead: list[MotionCommand] = []
        asked = robot._permits.from_now("run_waypoints")
        for waypoint, motion in zip(waypoints.waypoints, motions, strict=True):
            ahead.append(motion)
            if waypoint.stops or motion is motions[-1]:
                with asked:
                    await robot.motion.run(*ahead)
                # so does a pause from now on: nothing is paused that would go on by a resume
                asked = robot._permits.from_now("run_waypoints")
                ahead.clear()
                for num, value in waypoint.outputs.items():
                    await robot.io.set_standard_digital_out(num, value)
                if waypoint.dwell:
                    await anyio.sleep(waypoint.dwell)
    return len(waypoints.waypoints)


async def check_waypoints_on(
    robot: Robot,
    waypoints: WaypointFile,
    *,
    arm: Arm | str | None = None,
    envelope: Envelope | None = None,
) -> list[str]:
    """Find reasons against moving a robot's arm through waypoints. This moves nothing.

    Args:
        robot: the robot, open.
        waypoints: the file.
        arm: the arm, or the name of its model; None for the one that the controller reports.
        envelope: the limits that the waypoints must keep; None: those of `robot.envelope`. The
            ways between them are checked motion by motion, when they are run.
    """
    told, there = await reported_arm(robot)
    found = []
    if other := for_another_arm(waypoints.arm, told):
        found.append(other)
    kind = there if arm is None else arm_given("arm", arm)
    limits = envelope or robot.envelope
    tool = [0.0] * 6 if limits is None else list(await robot.frames.get_tcp_offset())
    if kind is not None:
        found += check_waypoints(waypoints, kind, envelope=limits, tool=tool)
    if not waypoints.waypoints:
        found.append("there is no waypoint")
    return found


async def _motion(robot: Robot, waypoint: Waypoint, speed: float) -> MotionCommand:
    radius = 0.0 if waypoint.stops else waypoint.blend
    if waypoint.motion == "joints":
        return robot.motion.movej2(
            waypoint.joints, v=speed * waypoint.speed, a=waypoint.acceleration, r=radius
        )
    # computed by the controller: it has the measured arm, this package the designed one
    pose = await robot.kinematics.cal_fkine(waypoint.joints)
    return robot.motion.movel(
        pose,
        v=speed * waypoint.line_speed,
        a=waypoint.line_acceleration,
        r=radius,
        q_near=waypoint.joints,
    )
