"""The motions of `aioduco check --motions`: what `aioduco calibrate` needs, in one recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import anyio
import numpy as np

import aioduco
from aioduco.errors import RobotStateError
from aioduco.models.enums import RobotState

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from aioduco.robot import Robot

__all__ = ["Extent", "measure"]

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
    """

    reach: float = 0.5
    poses: int = 40
    rounds: int = 2
    changes: int = 5

    @property
    def minutes(self) -> float:
        """Duration on an arm of usual speed [min]."""
        way = sum(2 * self.rounds * (self.reach * 0.6 / v + 0.3) for v in _SPEEDS) * 6
        return (self.poses * (_STILL + 2.0) + way + self.changes * 5.0 + 10.0) / 60.0


async def measure(
    host: str, port: int, path: Path, extent: Extent, progress: Callable[[str], object]
) -> None:
    """Move an enabled arm around where it is, and record what is needed to calibrate it.

    Args:
        host: address of the controller.
        port: its TCP port.
        path: the recording.
        extent: how far and how long.
        progress: called with what is done next.

    Raises:
        DucoError: the arm is not enabled, or a motion failed; the arm was stopped.
    """
    async with aioduco.connect(host, port, record=path, state_rate=_RATE) as robot:
        states = await robot.state.get_robot_state()
        if states.robot is not RobotState.ENABLE:
            raise RobotStateError("the arm is not enabled: `aioduco bring-up` enables it")
        start = np.array(await robot.state.get_actual_joints_position())
        await _poses(robot, start, extent, progress)
        await _turns(robot, start, extent, progress)
        await _updates(robot, start, extent, progress)
        await _changes(robot, extent, progress)


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

    async def act() -> None:
        nonlocal ended
        try:
            await action
        finally:
            ended = True

    async with anyio.create_task_group() as group:
        group.start_soon(act)
        due = anyio.current_time()
        while not ended:
            await read()
            due = max(due + interval, anyio.current_time())
            await anyio.sleep_until(due)
    await read()
