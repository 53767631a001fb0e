"""The motions of `aioduco check --motions`: what `aioduco calibrate` needs, in one recording."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import anyio
import numpy as np

import aioduco
from aioduco._process.platform import boot_time
from aioduco._wire.rpc import calls
from aioduco.errors import (
    DucoError,
    Refused,
    RobotStateError,
    TaskFailed,
    TaskIllegal,
    TaskParameterMismatch,
    TaskStopped,
)
from aioduco.models.enums import RobotState
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from aioduco.envelope import Envelope
    from aioduco.models.pose import Pose
    from aioduco.robot import Robot


#: samples of the state per second, and reads of the torques [Hz]
_RATE: Final = 125.0
_TORQUES: Final = 60.0
#: speed and acceleration between the poses [rad/s, rad/s²]
_BETWEEN: Final = (0.6, 1.5)
#: rest before a pose is read: an arm swings on after a motion [s]
_STILL: Final = 0.5
#: reads of joints and pose at each configuration
_READS: Final = 4
#: speeds at which each joint turns there and back [rad/s], and their acceleration [rad/s²]
_SPEEDS: Final = (0.15, 0.45, 0.8)
_HARD: Final = 5.0
#: blend radii, as shares of the reach [m/rad]; length of the lines, too
_RADII: Final = (0.04, 0.055, 0.07)
_LINE: Final = 0.2
#: acceleration of motions that blend [rad/s², m/s²]: low, so that it limits them at the corners
_GENTLE: Final = 1.0
#: speeds of them, squared, as shares of the reach: each line has a part of constant speed
_JOINT_PACE, _LINE_PACE = 0.45, 0.1
#: time that the one beat announces, the motion that it stops at most, and the time at rest in which
#: the heartbeat before it runs out [s]
_ANNOUNCED: Final = 0.5
_LAPSE: Final = 8.0
_FORGOTTEN: Final = 3.0
#: seconds beyond that motion's time after which the program must have stood still
_AWAY: Final = 30.0
#: what the joints may turn at most, as a share of the reach: first the large ones of the arm
_SHARES: Final = np.array([1.0, 0.6, 0.6, 1.0, 1.2, 1.5])


@dataclass(frozen=True)
class Extent:
    """How far and how long the arm is moved.

    Attributes:
        reach: how far a joint turns from where it is; the wrist's a half more [rad].
        poses: configurations at which joints and poses are read.
        rounds: times that each joint turns there and back at each speed.
        changes: times that the arm is disabled and enabled, powered off and on; 0 for never.
        lapses: times that the heartbeat ends in a slow motion; 0 for never.
    """

    reach: float = 0.5
    poses: int = 40
    rounds: int = 2
    changes: int = 5
    lapses: int = 2

    @property
    def minutes(self) -> float:
        """Duration on an arm of usual speed [min]."""
        way = sum(2 * self.rounds * (self.reach * 0.6 / v + 0.3) for v in _SPEEDS) * 6
        corners = len(_RADII) * 16.0
        lapses = self.lapses * (_FORGOTTEN + 5.0)
        seconds = self.poses * (_STILL + 2.0) + way + corners + self.changes * 5.0 + lapses + 10.0
        return seconds / 60.0

    @property
    def line(self) -> float:
        """How far the tip moves up and aside, besides [m]."""
        return _LINE * self.reach


async def measure(
    host: str,
    port: int,
    path: Path,
    extent: Extent,
    progress: Callable[[str], object],
    limits: Envelope | None = None,
) -> Path:
    """Move an enabled arm around where it is, and record what is needed to calibrate it.

    Args:
        host: address of the controller.
        port: its TCP port.
        path: the recording.
        extent: how far and how long.
        progress: called with what is done next.
        limits: limits that each motion keeps; None for none.

    Returns:
        The recording: another one than `path` if that existed.

    Raises:
        DucoError: the arm is not enabled, or a motion failed; the arm was stopped.
    """
    # The robot that moves has no heartbeat, so that it can end in a motion while all is recorded.
    # Until then, another one beats in the same program: without the one, the other ends, too.
    moving = aioduco.connect(host, port, record=path, state_rate=_RATE, heartbeat=None)
    async with moving as robot:
        robot.envelope = limits
        # an undertaking ends when the program stood still: the arm does not go on by itself then
        with robot.permit("check --motions"):
            async with aioduco.connect(host, port):
                states = await robot.state.get_robot_state()
                if states.robot is not RobotState.ENABLE:
                    raise RobotStateError("the arm is not enabled: `aioduco bring-up` enables it")
                start = np.array(await robot.state.get_actual_joints_position())
                await _poses(robot, start, extent, progress)
                await _turns(robot, start, extent, progress)
                await _updates(robot, start, extent, progress)
                await _corners(robot, start, extent, progress)
                await _changes(robot, extent, progress)
        await _lapses(robot, start, extent, progress)
        return path if robot.recording is None else robot.recording.path


async def _poses(
    robot: Robot, start: np.ndarray, extent: Extent, progress: Callable[[str], object]
) -> None:
    """Read joints, torques and poses at configurations that differ in all joints."""
    progress(f"poses: {extent.poses} configurations")
    v, a = _BETWEEN
    await robot.frames.get_tcp_offset()
    for share in _spread(extent.poses):
        goal = start + extent.reach * _SHARES * share
        await robot.motion.movej2(goal.tolist(), v=v, a=a)
        await anyio.sleep(_STILL)
        state = robot.state
        await state.get_actual_joints_torque()
        for _ in range(_READS):
            await state.get_actual_joints_position()
            await state.get_flange_pose()
            await state.get_actual_joints_position()
        await state.get_tcp_pose()
        await state.get_actual_joints_position()
        await state.get_actual_joints_torque()
    await robot.motion.movej2(start.tolist(), v=v, a=a)


def _spread(count: int) -> np.ndarray:
    """Points that fill a cube from -1 to 1 evenly, the same ones each time. Shape (count, 6)."""
    # Additive recurrence by the root of x**7 = x + 1, the golden ratio's kin in six dimensions.
    root = 1.0
    for _ in range(40):
        root = (1.0 + root) ** (1.0 / 7.0)
    steps = root ** -np.arange(1.0, 7.0)
    points = (0.5 + np.outer(np.arange(1, count + 1), steps)) % 1.0
    spread: np.ndarray = 2.0 * points - 1.0
    return spread


async def _turns(
    robot: Robot, start: np.ndarray, extent: Extent, progress: Callable[[str], object]
) -> None:
    """Turn each joint alone, there and back, at several speeds; read the torques meanwhile."""
    for joint in range(6):
        progress(f"joint {joint + 1}: there and back at {len(_SPEEDS)} speeds")
        for speed in _SPEEDS:
            for _ in range(extent.rounds):
                for side in (0.3, -0.3):
                    goal = start.copy()
                    goal[joint] += side * extent.reach
                    motion = robot.motion.movej2(goal.tolist(), v=speed, a=_HARD)
                    await _during(motion, robot.state.get_actual_joints_torque, 1.0 / _TORQUES)
        await robot.motion.movej2(start.tolist(), v=_BETWEEN[0], a=_BETWEEN[1])


async def _updates(
    robot: Robot, start: np.ndarray, extent: Extent, progress: Callable[[str], object]
) -> None:
    """Read the joints one time after the other while all of them move."""
    progress("updates of the readings")
    for side in (0.4, 0.0):
        goal = start + side * extent.reach
        motion = robot.motion.movej2(goal.tolist(), v=0.08, a=1.0)
        await _during(motion, robot.state.get_actual_joints_position, 0.0)


async def _corners(
    robot: Robot, start: np.ndarray, extent: Extent, progress: Callable[[str], object]
) -> None:
    """Blend joint moves and lines, both ways round, with several radii."""
    progress("corners of joint motions")
    motion, reach = robot.motion, extent.reach
    pace = (math.sqrt(_JOINT_PACE * reach), _GENTLE)
    turned = [start, *(start + 0.6 * reach * np.eye(6)[way] for way in (0, 2))]
    far = turned[1] + turned[2] - start
    for radius in _RADII:
        for corner, end in ((turned[1], far), (turned[2], start)):
            await motion.run(
                motion.movej2(corner.tolist(), *pace, r=radius * reach),
                motion.movej2(end.tolist(), *pace),
            )
            await anyio.sleep(_STILL)
    progress("corners of lines")
    pace = (math.sqrt(_LINE_PACE * reach), _GENTLE)
    tip = await robot.state.get_tcp_pose()
    up, aside = tip.shifted(z=extent.line), _aside(tip, extent.line)
    both = aside.shifted(z=extent.line)
    try:
        for radius in _RADII:
            for corner, end in ((up, both), (aside, tip)):
                await motion.run(
                    motion.movel(corner, *pace, r=radius * reach), motion.movel(end, *pace)
                )
                await anyio.sleep(_STILL)
    except (Refused, TaskFailed, TaskIllegal, TaskParameterMismatch) as error:  # not a stop
        progress(f"corners of lines are left out: {error}")
    await motion.movej2(start.tolist(), v=_BETWEEN[0], a=_BETWEEN[1])


def _aside(tip: Pose, way: float) -> Pose:
    """The tip, moved horizontally and across the direction to the arm's base."""
    away = math.hypot(tip.x, tip.y) or 1.0
    return tip.shifted(x=-way * tip.y / away, y=way * tip.x / away)


async def _lapses(
    robot: Robot, start: np.ndarray, extent: Extent, progress: Callable[[str], object]
) -> None:
    """Send one beat and none after it, while the last joint turns slowly: the controller stops it.

    If it does not, the motion ends by itself at its target.
    """
    way = 1.4 * extent.reach * np.eye(6)[5]
    for i in range(extent.lapses):
        progress(f"a heartbeat that ends, {i + 1} of {extent.lapses}")
        with robot.permit("check --motions"):  # of its own: the end of the heartbeat ends it, too
            await anyio.sleep(_FORGOTTEN)
            await robot.motion.movej2((start - way).tolist(), v=_BETWEEN[0], a=_BETWEEN[1])
            goal = (start + way).tolist()
            task = await robot.motion.movej2(goal, v=2.0 * way[5] / _LAPSE, a=_BETWEEN[1]).start()
        begun = boot_time()
        await anyio.sleep(_STILL)
        beat = anyio.current_time()
        await robot._supervisor.rpc.send(calls.rpc_heartbeat(round(1000 * _ANNOUNCED)))
        try:
            await task
        except TaskStopped:
            if anyio.current_time() - beat < 0.9 * _ANNOUNCED:
                raise  # the heartbeat had not run out: another program has stopped the arm
            await anyio.sleep(_STILL)
        else:
            progress("the controller did not stop the arm")
        if (away := boot_time() - begun - _LAPSE) > _AWAY:
            raise RobotStateError(
                f"this program stood still for {away:.0f} s: nothing more was sent, and what was "
                "recorded is kept. Give the command again"
            )
        states = await robot.state.get_robot_state()
        if states.robot is not RobotState.ENABLE:
            raise RobotStateError(
                f"after the heartbeat ended the arm is {states.robot.name}: `aioduco recover` "
                "brings it back; what was recorded is kept"
            )
    if extent.lapses:
        await robot.motion.movej2(start.tolist(), v=_BETWEEN[0], a=_BETWEEN[1])


async def _changes(robot: Robot, extent: Extent, progress: Callable[[str], object]) -> None:
    """Disable and enable, power off and on; read the robot's state meanwhile."""
    system, read = robot.system, robot.state.get_robot_state
    for i in range(extent.changes):
        progress(f"brakes and power, {i + 1} of {extent.changes}")
        changes = (system.disable, system.enable, system.disable)
        for change in (*changes, system.power_off, system.power_on, system.enable):
            await anyio.sleep(_STILL)  # some changes wait for an arm that does not stand yet
            await _during(change(), read, 0.0)


async def _during(
    action: Awaitable[object], read: Callable[[], Awaitable[object]], interval: float
) -> None:
    """Call `read` again and again until an action has ended, and once more then."""
    ended = False
    error: DucoError | None = None  # raised outside of the group, which would wrap it

    async def act() -> None:
        nonlocal ended, error
        try:
            await action
        except DucoError as exc:
            error = exc
        finally:
            ended = True

    async with anyio.create_task_group() as group:
        group.start_soon(act)
        try:
            async for _ in every(interval):
                if ended:
                    break
                await read()
        except DucoError as exc:
            error = exc
            group.cancel_scope.cancel()
    if error is not None:
        raise error
    await read()
