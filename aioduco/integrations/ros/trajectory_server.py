"""Carry out goals of FollowJointTrajectory, one at a time, for any middleware.

Guarantees:
- A refused goal moves nothing, and does not disturb the running goal.
- A goal that is cancelled, superseded by a newer one, or whose client has gone, ends with the arm
  at rest. Its result is sent only after that.
- No goal can end the server: each goal gets exactly one result.
"""

from __future__ import annotations

import contextlib
import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias

import anyio

from aioduco import RobotState
from aioduco.errors import DucoError
from aioduco.integrations.ros.goal_queue import GoalQueue
from aioduco.integrations.ros.trajectory_goals import (
    ErrorCode,
    GoalRefused,
    check_goal,
    check_start,
    code_of,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from aioduco import Robot, WorkerOptions
    from aioduco.integrations.ros.trajectory_goals import (
        ArmProfile,
        CheckedGoal,
        GoalRules,
        TrajectoryGoal,
    )

__all__ = ["GoalHandle", "PathFeedback", "Through", "TrajectoryServer"]

Through: TypeAlias = Literal["auto", "realtime", "servoj"]
"""How set-points reach the controller."""

_log = logging.getLogger(__name__)
_LOOK_AT_CLIENT = 0.02  # seconds between two checks whether a goal's client is present
_MOST_FEEDBACK = 50.0  # largest rate: as often as the arm is compared with its path [Hz]


class PathFeedback(Protocol):
    """Place of the arm on its way, as `robot.motion.follow_joint_trajectory` reports it."""

    @property
    def time(self) -> float:
        """Time on the trajectory [s]."""
        ...

    @property
    def desired(self) -> NDArray[np.float64]:
        """The closest place of the path [rad]. Shape (6,)."""
        ...

    @property
    def actual(self) -> NDArray[np.float64]:
        """Position of the arm [rad]. Shape (6,)."""
        ...

    @property
    def error(self) -> NDArray[np.float64]:
        """`actual` less `desired` [rad]. Shape (6,)."""
        ...


class GoalHandle(Protocol):
    """A goal of a client, and the messages to it. All methods are called on the event loop."""

    @property
    def goal(self) -> TrajectoryGoal:
        """The requested goal."""
        ...

    def alive(self) -> bool:
        """Whether its client is present."""
        ...

    def accepted(self) -> None:
        """The arm begins to carry it out."""

    def feedback(self, feedback: PathFeedback) -> None:
        """The arm is on its way."""

    def succeeded(self) -> None:
        """The arm is at its goal."""

    def cancelled(self, text: str) -> None:
        """It was cancelled; the arm stands, or never moved."""

    def rejected(self, code: ErrorCode, text: str) -> None:
        """It was not started."""

    def aborted(self, code: ErrorCode, text: str) -> None:
        """It was started and not finished."""


@dataclass(frozen=True, slots=True, eq=False)
class _Job:
    handle: GoalHandle
    checked: CheckedGoal


class TrajectoryServer:
    """Goals of one arm.

    Args:
        robot: the robot, open.
        profile: names and limits of the arm.
        rules: rules for goals.
        wall: the middleware's clock [s].
        feedback_rate: feedback messages per second of a running goal, up to 50 [Hz].
        through: how set-points reach the controller: "realtime", "servoj", or "auto" for
            "realtime" if the controller has it.
        options: options of streams; None: in a separate process.
        stop_at_loss: whether a stop ends a goal at once when its client or middleware has gone;
            otherwise the arm comes to rest on its path, which takes a tenth of a second longer.
    """

    def __init__(
        self,
        robot: Robot,
        profile: ArmProfile,
        rules: GoalRules,
        *,
        wall: Callable[[], float],
        feedback_rate: float = 20.0,
        through: Through = "auto",
        options: WorkerOptions | None = None,
        stop_at_loss: bool = False,
    ) -> None:
        self._robot = robot
        self._stop_at_loss = stop_at_loss
        self._profile = profile
        self._rules = rules
        self._wall = wall
        self._period = 1.0 / min(feedback_rate, _MOST_FEEDBACK)
        self._through: Through = through
        self._options = options
        self._queue: GoalQueue[_Job] = GoalQueue()
        self._changed = anyio.Event()
        self._scope: anyio.CancelScope | None = None
        self._why = ""

    @property
    def busy(self) -> bool:
        """Whether a goal is running or waiting."""
        return self._queue.running is not None or self._queue.waiting is not None

    def submit(self, handle: GoalHandle) -> None:
        """Take a goal: refuse it at once, or carry it out as soon as the arm is at rest."""
        try:
            checked = check_goal(handle.goal, self._profile, self._rules, self._wall())
        except GoalRefused as refusal:
            handle.rejected(refusal.code, str(refusal))
            return
        dropped = self._queue.submit(_Job(handle, checked))
        if dropped is not None:
            dropped.handle.cancelled("a newer goal came before it began")
        if self._queue.superseded:
            self._halt("a newer goal came")
        self._changed.set()

    def cancel(self, handle: GoalHandle) -> None:
        """Cancel a goal: the arm comes to rest on its way."""
        waiting, running = self._queue.waiting, self._queue.running
        if waiting is not None and waiting.handle is handle and self._queue.withdraw(waiting):
            handle.cancelled("cancelled before it began")
        elif running is not None and running.handle is handle:
            self._halt("cancelled as asked")

    def cancel_all(self, why: str) -> None:
        """Cancel all goals.

        Args:
            why: the reason, for the clients.
        """
        waiting = self._queue.waiting
        if waiting is not None and self._queue.withdraw(waiting):
            waiting.handle.cancelled(why)
        self._halt(why)

    async def cancel_on_loss(self, why: str) -> None:
        """Cancel all goals because the middleware has gone; stop the arm if `stop_at_loss`.

        Args:
            why: the reason, for the clients.
        """
        if self._stop_at_loss and self._queue.running is not None:
            with contextlib.suppress(DucoError):
                await self._robot.stop()
        self.cancel_all(why)

    async def run(self) -> None:
        """Carry out goals until this is cancelled; the arm then comes to rest."""
        try:
            while True:
                job = self._queue.begin()
                if job is None:
                    self._changed = anyio.Event()
                    await self._changed.wait()
                    continue
                try:
                    await self._carry_out(job)
                finally:
                    self._queue.end()
        finally:
            self.cancel_all("the driver ends")

    def _halt(self, why: str) -> None:
        if self._scope is not None:
            self._why = self._why or why
            self._scope.cancel()

    async def _carry_out(self, job: _Job) -> None:
        """Carry out one goal, from its acceptance to its result."""
        handle, begun, finished = job.handle, False, False
        error: Exception | None = None
        self._why = ""
        with anyio.CancelScope() as scope:
            self._scope = scope
            try:
                await self._ready(job.checked)
                handle.accepted()
                begun = True
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(self._watch_client, handle)
                    error = await self._follow(job)
                    finished = error is None
                    tasks.cancel_scope.cancel()
            except Exception as exc:  # any kind of error: the goal has failed, the driver continues
                error = exc
            except anyio.get_cancelled_exc_class():
                self._why = self._why or "the driver ends"
                raise
            finally:
                self._scope = None
                self._tell(handle, error, begun=begun, finished=finished)

    def _tell(
        self, handle: GoalHandle, error: Exception | None, *, begun: bool, finished: bool
    ) -> None:
        """Send the client the one result of its goal."""
        if finished:
            handle.succeeded()
        elif error is None:
            handle.cancelled(self._why)
        elif begun:
            _log.warning("goal aborted: %s", error)
            handle.aborted(code_of(error), str(error) or repr(error))
        else:
            _log.warning("goal rejected: %s", error)
            code = error.code if isinstance(error, GoalRefused) else ErrorCode.INVALID_GOAL
            handle.rejected(code, str(error) or repr(error))

    async def _ready(self, checked: CheckedGoal) -> None:
        """Wait for the start time of a goal, and check that the arm is ready and at its start."""
        if checked.begin:
            await anyio.sleep(max(0.0, checked.begin - self._wall()))
        states = await self._robot.state.get_robot_state()
        if states.robot is not RobotState.ENABLE:
            raise GoalRefused(
                ErrorCode.INVALID_GOAL,
                f"the arm cannot move: {states}; call bring_up, or recover after a stop",
            )
        actual = await self._robot.state.get_actual_joints_position()
        check_start(checked, actual, self._profile, self._rules)

    async def _follow(self, job: _Job) -> Exception | None:
        """Follow a goal to its end. Return the error that ended it early, except a cancellation."""
        due = 0.0
        period = self._period

        def feedback(found: PathFeedback) -> None:
            nonlocal due
            now = anyio.current_time()
            if now >= due:
                # Keep the schedule of the first feedback; missed ones are skipped.
                due = max(due + period, now - period) if due else now + period
                job.handle.feedback(found)

        try:
            await self._robot.motion.follow_joint_trajectory(
                job.checked.trajectory,
                v=max(self._profile.velocity),
                a=self._profile.acceleration,
                tolerances=job.checked.tolerances,
                feedback=feedback,
                reach=2.0 * self._rules.start,
                through=self._through,
                options=self._options,
            )
        except DucoError as error:
            return error
        return None

    async def _watch_client(self, handle: GoalHandle) -> None:
        """End a goal whose client has gone: no client could cancel it."""
        start, number = anyio.current_time(), 0
        while handle.alive():
            number += 1
            await anyio.sleep_until(start + number * _LOOK_AT_CLIENT)
        _log.warning("the client of the goal is gone: the arm comes to rest")
        if self._stop_at_loss:
            with contextlib.suppress(DucoError):
                await self._robot.stop()
        self._halt("its client is gone")
