"""Follow joint positions as they arrive, for example from ros2_control or a teleoperation.

Guarantees:
- The arm does not move before a command arrives that is close to its position. The commands after
  it may move at once: what comes while the stream opens is kept, and followed faster then.
- When commands cease, the arm stands at the last one; the stream ends, unless it must be held.
- After a stop, further commands are ignored. They are followed again only after they have ceased,
  or after the arm was brought up or recovered. So are those that go on as the driver starts, unless
  the stream must be held.
"""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING

import anyio

from aioduco import RobotState
from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError, SetPointTooFar
from aioduco.integrations.ros.streamed_commands import StreamedCommands
from aioduco.integrations.ros.trajectory_goals import ErrorCode, GoalRefused, NamedLimits
from aioduco.models.bounds import clipped, least, most, shown

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco import Robot, WorkerOptions


_log = BackgroundLogger(__name__)
_LOOK = 0.1  # seconds between two polls of the arm, and between two checks whether commands ceased
_BEFORE = 2.0  # age of the oldest command with which the arm's position is compared at first [s]
_KEPT = 5000  # commands kept at most while the stream opens
_FASTER = 2.0  # factor of their speed at which these are followed then


def check_command(
    names: Sequence[str], positions: Sequence[float], profile: NamedLimits
) -> tuple[float, ...]:
    """A command in the arm's order of joints.

    Args:
        names: names of the joints; those of other arms are ignored.
        positions: positions of these joints [rad].
        profile: names and limits of the arm.

    Raises:
        GoalRefused: a joint is missing or named twice, or a position is not finite or not within
            the limits.
    """
    if len(names) != len(positions):
        raise GoalRefused(
            ErrorCode.INVALID_GOAL, f"{len(names)} names and {len(positions)} positions"
        )
    given = dict(zip(names, positions, strict=True))
    if len(given) != len(names):
        raise GoalRefused(ErrorCode.INVALID_JOINTS, "a joint is named twice")
    missing = [name for name in profile.joint_names if name not in given]
    if missing:
        raise GoalRefused(ErrorCode.INVALID_JOINTS, f"{', '.join(missing)} missing")
    found = tuple(float(given[name]) for name in profile.joint_names)
    for name, place, low, high in zip(
        profile.joint_names, found, profile.lower, profile.upper, strict=True
    ):
        if not least(low) <= place <= most(high):
            text = f"{name} at {place:.4g} rad, {shown(low, low=True)} to {shown(high)} allowed"
            raise GoalRefused(ErrorCode.INVALID_GOAL, text)
    return tuple(clipped(found, profile.lower, profile.upper).tolist())


class JointCommands(StreamedCommands):
    """Joint positions for one arm, followed by a servo stream that is open while they arrive.

    Args:
        robot: the robot, open.
        profile: names and limits of the arm.
        busy: returns whether something else uses the arm, such as a trajectory goal.
        rate: commands per second [Hz]; set-points between them are interpolated.
        timeout: time without commands after which the stream ends [s].
        hold: whether the stream is open all the time, also without commands.
        reach: largest distance of a joint from the first command [rad].
        options: options of the stream; None: in a separate process.

    Attributes:
        following: whether the stream is open.
    """

    def __init__(
        self,
        robot: Robot,
        profile: NamedLimits,
        *,
        busy: Callable[[], bool],
        rate: float,
        timeout: float,
        hold: bool,
        reach: float,
        options: WorkerOptions | None = None,
    ) -> None:
        super().__init__(robot, _log, busy=busy, timeout=timeout, options=options)
        self._profile = profile
        self._rate = rate
        self._hold = hold
        self._blocked = not hold  # ros2_control never ceases
        self._reach = reach
        #: commands that are not followed yet, with the time of each
        self._waiting: deque[tuple[float, tuple[float, ...]]] = deque(maxlen=_KEPT)
        #: whether a command was close to the arm, so that those after it are followed
        self._near = False

    def take(self, names: Sequence[str], positions: Sequence[float]) -> bool:
        """Take a command. Return whether it may be followed.

        Args:
            names: names of the joints.
            positions: positions of these joints [rad].
        """
        try:
            target = check_command(names, positions, self._profile)
        except GoalRefused as refusal:
            self._warn("refused", "joint command refused: %s", refusal)
            return False
        now = self._note_command()
        if self._refused():
            return False
        if not self.following and self._busy():
            self._warn("busy", "joint command ignored: a trajectory goal is carried out")
            return False
        self._waiting.append((now, target))
        self._changed.set()
        return True

    def leave(self) -> None:
        """The driver serves no more: as of the others, unless the stream must be held."""
        if not self._hold:  # ros2_control never ceases
            super().leave()

    def _block(self) -> None:
        super()._block()
        self._waiting.clear()

    async def run(self) -> None:
        """Follow commands until this is cancelled; the arm then comes to rest."""
        while True:
            await self._wait()
            if self._hold or self._waiting:
                try:
                    await self._begin()
                except DucoError as error:
                    self._block()
                    _log.warning("joint commands: %s", error)

    async def _wait(self) -> None:
        """Wait for a command, or until the next poll is due."""
        if not self._waiting:
            self._changed = anyio.Event()
            with anyio.move_on_after(_LOOK):
                await self._changed.wait()

    async def _begin(self) -> None:
        """Follow commands if the arm can, and one is close to where it is."""
        if not (self._blocked or self._busy()):
            states = await self._robot.state.get_robot_state()
            if states.robot is RobotState.ENABLE:
                place = tuple(await self._robot.state.get_actual_joints_position())
                # what is awaited above may have taken long enough for a stop
                if not self._blocked and (self._hold or self._is_near(place)):
                    await self._follow(place)
                    return
        await anyio.sleep_until(anyio.current_time() + _LOOK)

    def _is_near(self, place: tuple[float, ...]) -> bool:
        """Whether commands lead from a place; those before the one that is there are dropped."""
        oldest = anyio.current_time() - _BEFORE
        while not self._near and self._waiting and self._waiting[0][0] < oldest:
            self._waiting.popleft()
        if not self._near and self._waiting:
            ways = [_way(target, place) for _, target in self._waiting]
            first = next((index for index, way in enumerate(ways) if way <= self._reach), None)
            if first is None:
                self._warn(
                    "far",
                    "joint command ignored: %.3g rad from where the arm is, %.3g allowed at first",
                    *(ways[-1], self._reach),
                )
                self._waiting.clear()
                return False
            for _ in range(first):
                self._waiting.popleft()
            self._near = True
        return self._near

    async def _follow(self, target: tuple[float, ...]) -> None:
        """Follow commands in one stream, from where the arm stands, until they cease."""
        try:
            async with self._robot.servo.joints(
                v=max(self._profile.velocity),
                a=self._profile.acceleration,
                latest=True,
                upsample="linear",
                source_rate=self._rate,
                options=self._options,
            ) as stream:
                self._opened()
                await stream.send(target)
                while self._hold or anyio.current_time() - self._came < self._timeout:
                    came, newest = math.inf, target
                    if self._is_near(target) and self._waiting:
                        came, newest = self._waiting.popleft()
                    try:
                        await stream.send(newest)
                        target = newest
                    except SetPointTooFar as error:
                        self._warn("step", "joint command left out: %s", error)
                        await stream.send(target)  # it would end for want of set-points
                    if self._waiting:
                        ahead = max(self._waiting[0][0] - came, 0.0) / _FASTER
                        await anyio.sleep_until(anyio.current_time() + ahead)
                    await self._wait()
        finally:
            self._ended()
            self._near = False
            self._waiting.clear()


def _way(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    """Largest distance of a joint between two places [rad]."""
    return max(abs(a - b) for a, b in zip(one, other, strict=True))
