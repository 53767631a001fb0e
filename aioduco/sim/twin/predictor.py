"""What the arm should do, and how far each sample is from it. No I/O, no clock, no limits."""

from __future__ import annotations

import heapq
import itertools
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from aioduco.kinematics.forward import frames
from aioduco.kinematics.mounting import gravity
from aioduco.models.enums import ProgramState, RobotState
from aioduco.models.pose import Pose
from aioduco.sim.twin.data import Six, TwinCommand, TwinSample
from aioduco.sim.twin.rehearsal import HALTS, PATHS, Match, Rehearsal

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array


#: time by which the rehearsal gets commands before the arm, so that it is never behind [s]
AHEAD = 0.03
#: time within which a motion that was commanded has begun, or its command has got lost [s]
_UNDERWAY = 0.1
_AT_REST = (ProgramState.STOPPED, ProgramState.STOPPING)
#: speed of the set-points above which they move [rad/s]
_MOVES = 2e-3
#: longest interval of samples over which an acceleration is derived [s]
_GAP = 0.05
#: samples from one comparison of the tool's pose to the next
_POSE_EVERY = 3


class Deviation(NamedTuple):
    """How far one sample is from what it should be.

    Attributes:
        time: time of the sample [s].
        step: time since the sample before, at most 0.05 [s].
        speeds: joint speeds [rad/s]. Shape (6,).
        expected_speeds: speeds of the set-points [rad/s]. Shape (6,).
        external: observed external torques [N m], shape (6,); None if they are not reported.
        force: force at the tool minus that at the beginning [N], shape (3,); None without a sensor.
        jacobian: of the flange's position, shape (3, 6) [m/rad].
        weight: what a kilogram at the flange weighs there, its inertia included [N/kg]. Shape (3,).
        tracking: set-points minus joints [rad]. Shape (6,).
        position, angle: distance of the tool's pose from the one computed from the joints [m, rad];
            None if the pose or the tool is not known.
        match: the set-point beside the rehearsal; None while that is blind.
        moving: whether the set-points move.
    """

    time: float
    step: float
    speeds: Array
    expected_speeds: Array
    external: Array | None
    force: Array | None
    jacobian: Array
    weight: Array
    tracking: Array
    position: float | None
    angle: float | None
    match: Match | None
    moving: bool


class Predictor:
    """Predicts samples from the program's commands and the arm's model.

    Args:
        arm: the arm.
        tool: tip of the tool in the flange's frame [m, rad]; None to take it from the first sample.
        mounting: pose of the base in the world [m, rad].

    Attributes:
        rehearsal: the commands on the simulator's controller.
    """

    def __init__(self, arm: Arm, tool: Pose | None = None, mounting: Pose | None = None) -> None:
        self._arm = arm
        self.rehearsal: Rehearsal = Rehearsal(arm)
        self._tool = None if tool is None else tool.matrix
        self._base = None if mounting is None or not any(mounting) else mounting.matrix
        self._before: tuple[float, Array] | None = None
        self._down = gravity("floor" if mounting is None else mounting)
        self._acceleration = np.zeros(3)
        self._bare: Array | None = None
        #: motions that were commanded while the rehearsal was blind
        self._waiting: list[TwinCommand] = []
        self._count = 0

    def command(self, command: TwinCommand) -> bool | None:
        """Take a command of the program; return what the rehearsal says, as `Rehearsal.command`."""
        self.rehearsal.advance(command.time - AHEAD)
        if command.function == "set_tool_data" and command.accepted:
            self._tool = Pose.of(command.arguments[1]).matrix
        if self.rehearsal.blind and command.function in PATHS and command.accepted:
            self._waiting.append(command)
        said = self.rehearsal.command(command)
        if command.function in HALTS:
            # where the arm comes to rest depends on milliseconds
            self.rehearsal.hide(f"{command.function} was called", command.time)
        return said

    def deviation(self, sample: TwinSample) -> Deviation:
        """Compare a sample with what it should be."""
        q, speeds = np.array(sample.joints), np.array(sample.speeds)
        expected_speeds = np.array(sample.expected_speeds)
        chain = frames(self._arm.geometry, q)
        lever = _lever(chain)
        moving = float(np.abs(expected_speeds).max()) > _MOVES
        self._count += 1
        position = angle = None
        if sample.pose is not None and self._count % _POSE_EVERY == 0:
            position, angle = self._apart(chain[6], sample.pose)
        self._follow(sample, moving)
        step = self._accelerate(sample.time, lever @ expected_speeds)
        force = None
        if sample.force is not None:
            force = np.array(sample.force[:3])
            if self._bare is None:
                self._bare = force
            force = force - self._bare
        return Deviation(
            sample.time,
            step,
            speeds,
            expected_speeds,
            None if sample.external is None else np.array(sample.external),
            force,
            lever,
            self._down - self._acceleration,
            np.array(sample.expected) - q,
            position,
            angle,
            self.rehearsal.match(sample.expected),
            moving,
        )

    def _follow(self, sample: TwinSample, moving: bool) -> None:
        """Keep the rehearsal beside the arm: begin, continue, or be blind."""
        rehearsal = self.rehearsal
        enabled = sample.robot == RobotState.ENABLE
        if sample.led or not enabled:
            leads = "a stream, a mode or a blocking call leads the arm"
            rehearsal.hide(leads if sample.led else "not enabled")
        if not rehearsal.blind:
            rehearsal.advance(sample.time)
            return
        at, waiting = sample.time, self._waiting
        self._waiting = waiting = [each for each in waiting if each.time > at - _UNDERWAY]
        if moving or not enabled or sample.led or sample.program not in _AT_REST:
            return
        if at < rehearsal.unknown_since + _UNDERWAY:
            return  # the arm has not begun to move yet
        if all(each.time > at for each in waiting):
            # nothing is under way to the arm: what waits was sent after this sample
            rehearsal.begin(sample.expected, at)
            self._waiting = []
            for command in waiting:
                rehearsal.command(command)

    def _accelerate(self, time: float, speed: Array) -> float:
        before, self._before = self._before, (time, speed)
        step = 0.0 if before is None else time - before[0]
        if before is None or not 0.0 < step <= _GAP:
            self._acceleration = np.zeros(3)
        else:
            # over two or three samples: their times are not exact
            share = step / (step + 0.02)
            now = (speed - before[1]) / step
            self._acceleration = self._acceleration + share * (now - self._acceleration)
        return min(max(step, 0.0), _GAP)

    def _apart(self, flange: Array, pose: Six) -> tuple[float, float]:
        there = Pose(*pose).matrix
        if self._base is not None:
            flange = self._base @ flange
        if self._tool is None:
            self._tool = np.linalg.inv(flange) @ there
        computed = flange @ self._tool
        position = float(np.linalg.norm(there[:3, 3] - computed[:3, 3]))
        turned = float(np.linalg.norm(there[:3, :3] - computed[:3, :3]))
        return position, 2.0 * np.arcsin(min(1.0, turned / 8.0**0.5))


def _lever(chain: Array) -> Array:
    """Speed of the flange for each joint's speed, by the frames of the links. Shape (3, 6)."""
    x, y, z = chain[:6, :3, 2].T
    a, b, c = chain[6, :3, 3, None] - chain[:6, :3, 3].T
    return np.array((y * c - z * b, z * a - x * c, x * b - y * a))


Item: TypeAlias = TwinSample | TwinCommand

#: time for which samples are held back, so that commands of before can arrive [s]
HELD = AHEAD + 0.03


class Timeline:
    """Holds samples and commands back for a moment, and gives them in order.

    A command counts `AHEAD` before its time: a rehearsal that is behind the arm could not say where
    the arm should be.
    """

    def __init__(self) -> None:
        self._waiting: list[tuple[float, int, Item]] = []
        self._count = itertools.count()
        self._newest = 0.0

    def put(self, item: Item) -> None:
        """Add a sample or a command, in any order."""
        at = item.time
        if isinstance(item, TwinCommand):
            at -= AHEAD
        else:
            self._newest = max(self._newest, at)
        heapq.heappush(self._waiting, (at, next(self._count), item))

    def due(self) -> Iterator[Item]:
        """Take what came so long before the newest sample that nothing earlier can arrive."""
        while self._waiting and self._waiting[0][0] <= self._newest - HELD:
            yield heapq.heappop(self._waiting)[2]

    def rest(self) -> Iterator[Item]:
        """Take all that is left, in order."""
        while self._waiting:
            yield heapq.heappop(self._waiting)[2]
