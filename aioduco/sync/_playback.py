"""Playing recordings and running waypoints, for blocking programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.envelope import Envelope
    from aioduco.kinematics import Arm
    from aioduco.playback import PathFinding, RecordedPath, WaypointFile
    from aioduco.streaming.joint_trajectory import Feedback, Tolerances, TrajectoryResult
    from aioduco.streaming.options import LaneOptions
    from aioduco.sync._robot import Robot

__all__ = ["check_path_on", "check_waypoints_on", "play", "run_waypoints"]


def play(
    robot: Robot,
    path: RecordedPath,
    *,
    approach: float | None = None,
    outputs: bool = False,
    arm: Arm | str | None = None,
    through: str = "auto",
    tolerances: Tolerances | None = None,
    feedback: Callable[[Feedback], object] | None = None,
    options: LaneOptions | None = None,
) -> TrajectoryResult:
    """Move the arm along a recorded path, after a check: see `aioduco.playback.play`.

    An interrupt (Ctrl-C) brings the arm to rest on the path before it is raised. `feedback` is
    called on the robot's thread.
    """
    from aioduco import playback  # noqa: PLC0415 - it loads numpy, so only when it is used

    work = playback.play(
        robot._robot,
        path,
        approach=approach,
        outputs=outputs,
        arm=arm,
        through=through,
        tolerances=tolerances,
        feedback=feedback,
        options=options,
    )
    return robot._runner.call(work)


def check_path_on(
    robot: Robot,
    path: RecordedPath,
    *,
    arm: Arm | str | None = None,
    envelope: Envelope | None = None,
) -> tuple[PathFinding, ...]:
    """List the reasons against moving the arm along a path: see `aioduco.playback.check_path_on`.

    Nothing moves.
    """
    from aioduco import playback  # noqa: PLC0415

    work = playback.check_path_on(robot._robot, path, arm=arm, envelope=envelope)
    return robot._runner.call(work)


def check_waypoints_on(
    robot: Robot,
    waypoints: WaypointFile,
    *,
    arm: Arm | str | None = None,
    envelope: Envelope | None = None,
) -> list[str]:
    """List the reasons against running waypoints: see `aioduco.playback.check_waypoints_on`.

    Nothing moves.
    """
    from aioduco import playback  # noqa: PLC0415

    work = playback.check_waypoints_on(robot._robot, waypoints, arm=arm, envelope=envelope)
    return robot._runner.call(work)


def run_waypoints(
    robot: Robot, waypoints: WaypointFile, *, arm: Arm | str | None = None, speed: float = 1.0
) -> int:
    """Move the arm through the waypoints of a file: see `aioduco.playback.run_waypoints`.

    An interrupt (Ctrl-C) stops the arm.
    """
    from aioduco import playback  # noqa: PLC0415

    work = playback.run_waypoints(robot._robot, waypoints, arm=arm, speed=speed)
    return robot._runner.call(work)
