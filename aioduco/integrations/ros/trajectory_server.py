"""Carry out goals of FollowJointTrajectory, one at a time, for any middleware.

Guarantees:
- A refused goal moves nothing, and does not disturb the running goal.
- A goal that is cancelled, late, or whose client has gone, ends with the arm at rest. Its result is
  sent only after that.
- A newer goal that begins where the arm is or was on its way takes over without a stop, if it can
  within the arm's limits. Otherwise the arm comes to rest, and follows it from there.
- A goal that succeeded was there within its own times, stretched by the global speed, and its
  goal time tolerance.
- After a stop no goal begins or goes on that was sent before it, whether it waited for another one,
  for its time, or for the next part of its path.
- No goal can end the server: each goal gets exactly one result.
"""

from __future__ import annotations

import contextlib
import math
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, TypeAlias

import anyio
import anyio.lowlevel
import numpy as np

from aioduco import RobotState, TrajectorySwitch
from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError
from aioduco.integrations.ros.goal_queue import GoalQueue
from aioduco.integrations.ros.path_parts import (
    PathPart,
    nearest_time,
    path_from_motion,
    rest_of_path,
    whole_path,
)
from aioduco.integrations.ros.trajectory_goals import (
    CheckedGoal,
    ErrorCode,
    GoalEnded,
    GoalRefused,
    GoalRules,
    NamedLimits,
    TrajectoryGoal,
    check_goal,
    check_start,
    code_of,
    said,
)
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from aioduco import JointTrajectory, Robot, SwitchPlace, Tolerances, WorkerOptions


Through: TypeAlias = Literal["auto", "realtime", "servoj"]
"""How set-points reach the controller."""

_log = BackgroundLogger(__name__)
_LOOK = 0.02  # seconds between two checks of a goal's client, time and speed
_LOOK_PAUSED = 0.1  # seconds between two checks of an arm that is paused
_MOST_FEEDBACK = 50.0  # largest rate: as often as the arm is compared with its path [Hz]
_LAG = 0.3  # seconds by which the arm may lag behind its set-points
_RECENT = 0.5  # age of a measured position from which a newer goal may begin [s]


class GoalProgress(NamedTuple):
    """Place of the arm on the path of its goal.

    Attributes:
        time: time on the goal's trajectory [s].
        desired: the closest place of the path [rad]. Shape (6,).
        actual: position of the arm [rad]. Shape (6,).
    """

    time: float
    desired: NDArray[np.float64]
    actual: NDArray[np.float64]

    @property
    def error(self) -> NDArray[np.float64]:
        """What is missing to `desired`, the sign that control_msgs states [rad]. Shape (6,)."""
        return self.desired - self.actual


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

    def feedback(self, feedback: GoalProgress) -> None:
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
    """A goal.

    Attributes:
        handle: messages to its client.
        checked: the goal, checked.
        arrived: when it arrived, on the event loop's clock [s].
        begin: when it begins, on the same clock, which nobody sets; None: at once.
        joins: whether its first point was a position of the arm on the way of an earlier goal.
        permit: the permit of all that moves the arm for it, asked for when it arrived.
    """

    handle: GoalHandle
    checked: CheckedGoal
    arrived: float
    begin: float | None
    joins: bool
    permit: contextlib.AbstractContextManager[None]


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
        profile: NamedLimits,
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
        self._ended = False
        self._changed = anyio.Event()
        self._scope: anyio.CancelScope | None = None
        self._why = ""
        self._error: GoalEnded | None = None
        #: the part of the goal that the arm follows; a pause, or another speed, ends it
        self._part: anyio.CancelScope | None = None
        self._switch: TrajectorySwitch | None = None
        #: what the arm follows, of the path of the running goal
        self._followed: PathPart | None = None
        #: factor of their speed at which goals are followed, above 0 to 1
        self.factor: float = 1.0
        self._paused = False
        #: whether the arm has come to rest at the early end of that part
        self._at_rest = anyio.Event()
        self._resumed = anyio.Event()
        #: when the arm has to be at its goal at the latest, on the event loop's clock [s]
        self._due = math.inf
        #: where the arm is on the path of the running goal; None without one
        self.progress: GoalProgress | None = None
        self._path: Any = None
        self._rising = False  # whether the arm gains the path's speed from rest
        #: positions of the arm on its way, with the time of each
        self._recent: deque[tuple[float, NDArray[np.float64]]] = deque(
            maxlen=round(_RECENT * _MOST_FEEDBACK)
        )

    @property
    def busy(self) -> bool:
        """Whether a goal is running or waiting."""
        return self._queue.running is not None or self._queue.waiting is not None

    @property
    def following(self) -> bool:
        """Whether the arm follows a goal, or is paused on its path."""
        return self._part is not None

    def submit(self, handle: GoalHandle) -> None:
        """Take a goal: refuse it at once, or carry it out as soon as the arm is at rest."""
        wall = self._wall()
        try:
            if self._ended:  # the rest of the driver still ends
                raise GoalRefused(ErrorCode.INVALID_GOAL, "the driver is not active")
            checked = check_goal(handle.goal, self._profile, self._rules, wall)
            self._check_begin(checked)
            permit = self._robot.permit("the goal")
        except DucoError as error:
            _reject(handle, error)
            return
        now, first = anyio.current_time(), checked.trajectory.positions[0]
        supersedes = self._queue.running is not None and checked.trajectory.times[0] == 0.0
        joins = supersedes and any(
            now - at < _RECENT and np.abs(first - place).max() <= self._rules.start
            for at, place in self._recent
        )
        begin = now + checked.begin - wall if checked.begin else None
        dropped = self._queue.submit(_Job(handle, checked, now, begin, joins, permit))
        if dropped is not None:
            dropped.handle.cancelled("a newer goal came before it began")
        if self._queue.superseded:
            self._replace()
        self._changed.set()

    def scale(self, factor: float) -> None:
        """Follow goals at a factor of their speed: a running one comes to rest, and goes on.

        Args:
            factor: above 0 to 1.
        """
        if factor != self.factor:
            self.factor = factor
            self._end_part()

    async def pause(self) -> bool:
        """Bring the arm to rest on the path of the running goal, which goes on by `resume`.

        So is a newer goal that comes in its place meanwhile.

        Returns:
            Whether a goal is paused; otherwise it has ended, or goes on again.
        """
        while self.busy:
            if self._queue.running is None:
                await anyio.lowlevel.checkpoint()  # it begins at once
                continue
            if not self._paused:
                self._paused, self._resumed = True, anyio.Event()
                self._end_part()
            resumed = self._resumed
            if self._part is not None:
                await self._at_rest.wait()  # an earlier pause may still bring it to rest
            if self._paused or resumed.is_set():
                break
        return self._paused

    def resume(self) -> bool:
        """Go on with a paused goal. Return whether there was one."""
        was, self._paused = self._paused, False
        self._resumed.set()
        return was

    def stopped(self) -> None:
        """The arm was stopped: a goal that does not move it has ended, too."""
        self._withdraw("the arm was stopped before it began")
        if self._part is None or self._part.cancel_called:
            why = "stopped while the goal waited, or was paused"
            self._halt("", GoalEnded(ErrorCode.PATH_TOLERANCE_VIOLATED, why))

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
        self._withdraw(why)
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
        self._ended = False
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
            self._ended = True
            self.cancel_all("the driver ends")

    def _check_begin(self, checked: CheckedGoal) -> None:
        """Check that a goal which is to replace the running one begins near it.

        Raises:
            GoalRefused: it begins where the arm neither was lately nor soon will be.
        """
        progress, first = self.progress, checked.trajectory.positions[0]
        if checked.begin or checked.trajectory.times[0] > 0.0 or progress is None:
            return  # another time decides, it leads from anywhere, or the arm stands
        now = anyio.current_time()
        ahead = progress.time + np.linspace(-_LAG, _RECENT, round(_RECENT * _MOST_FEEDBACK))
        places = [*self._path.at(np.clip(ahead, 0.0, self._path.times[-1])), progress.actual]
        places += [place for at, place in self._recent if now - at < _RECENT]
        away = np.abs(np.array(places) - first).max(axis=1).min()
        if not away <= self._rules.start:
            raise GoalRefused(
                ErrorCode.INVALID_GOAL,
                f"the trajectory begins elsewhere: {away:.4f} rad from the way of the arm, which "
                f"follows another goal; {self._rules.start:g} allowed",
            )

    def _replace(self) -> None:
        """Let the waiting goal take over from the moving arm, or else bring the arm to rest."""
        job = self._queue.waiting
        assert job is not None

        def rest() -> None:
            if self._queue.superseded:
                self._halt("a newer goal came")

        def take_over(place: SwitchPlace) -> tuple[JointTrajectory, Tolerances] | None:
            if self._queue.waiting is not job:
                return None  # it was withdrawn, or a newer one asks for itself
            path = job.checked.trajectory.curve(place.joints.tolist())
            late = anyio.current_time() + place.delay - job.arrived if job.joins else 0.0
            part = path_from_motion(
                *(path, place.joints, place.speeds),
                begin=late * self.factor,
                factor=self.factor,
                profile=self._profile,
            )
            if part is None:
                rest()
                return None
            running = self._queue.running
            assert running is not None
            self._queue.take_over()
            running.handle.cancelled("a newer goal took over")
            job.handle.accepted()
            self._path, self._followed, self.progress, self._rising = path, part, None, True
            tolerances = job.checked.tolerances
            end = place.delay + part.trajectory.duration
            self._due = anyio.current_time() + end + tolerances.goal_time
            return part.trajectory, tolerances

        leads = job.joins or job.checked.trajectory.times[0] > 0.0
        moving = self._part is not None and not (self._part.cancel_called or self._paused)
        if leads and moving and job.begin is None and self._switch is not None:
            self._switch.ask(take_over, rest)
        else:
            rest()

    def _withdraw(self, why: str) -> None:
        """Drop the waiting goal, if there is one."""
        waiting = self._queue.waiting
        if waiting is not None and self._queue.withdraw(waiting):
            waiting.handle.cancelled(why)

    def _halt(self, why: str, error: GoalEnded | None = None) -> None:
        """End the running goal, with an error or, without one, as cancelled."""
        if self._scope is not None:
            if not self._scope.cancel_called:
                self._why, self._error = why, error
            self._scope.cancel()

    def _end_part(self) -> None:
        if self._part is not None:
            self._part.cancel()

    async def _carry_out(self, job: _Job) -> None:
        """Carry out a goal and those that take over from it, from acceptance to the last result."""
        begun, finished = False, False
        error: Exception | None = None
        self._why, self._error = "", None
        with anyio.CancelScope() as scope, job.permit:
            self._scope = scope
            try:
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(self._watch_client)
                    try:
                        actual = await self._ready(job)
                    except Exception as refusal:
                        error = refusal
                    else:
                        job.handle.accepted()
                        begun = True
                        tasks.start_soon(self._watch_time)
                        tasks.start_soon(self._watch_speed)
                        error = await self._follow(job, actual)
                        finished = error is None
                    tasks.cancel_scope.cancel()
            except Exception as exc:  # any kind of error: the goal has failed, the driver continues
                error = exc
            except anyio.get_cancelled_exc_class():
                self._why = self._why or "the driver ends"
                raise
            finally:
                self._scope = self._part = self.progress = self._switch = None
                self._due = math.inf
                self._paused = False
                self._at_rest.set()
                handle = self._running.handle
                self._tell(handle, error or self._error, begun=begun, finished=finished)

    @property
    def _running(self) -> _Job:
        assert self._queue.running is not None
        return self._queue.running

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
            handle.aborted(code_of(error), said(error))
        else:
            _log.warning("goal rejected: %s", error)
            _reject(handle, error)

    async def _ready(self, job: _Job) -> Sequence[float]:
        """Wait for the start time of a goal, and check that the arm is ready and at its start.

        Returns:
            Position of the arm [rad]. Shape (6,).
        """
        if job.begin is not None:
            await anyio.sleep_until(job.begin)
        actual = await self._standing()
        if not job.joins:
            check_start(job.checked, actual, self._profile, self._rules)
        return actual

    async def _standing(self) -> Sequence[float]:
        """The position of an arm that can move [rad]. Shape (6,)."""
        states = await self._robot.state.get_robot_state()
        if states.robot is not RobotState.ENABLE:
            raise GoalRefused(
                ErrorCode.INVALID_GOAL,
                f"the arm cannot move: {states}; call bring_up, or recover after a stop",
            )
        return await self._robot.state.get_actual_joints_position()

    async def _follow(self, job: _Job, actual: Sequence[float]) -> Exception | None:
        """Follow a goal to its end. Return the error that ended it early, except a cancellation."""
        path = job.checked.trajectory.curve(actual)
        away = float(np.abs(path.at(path.times[:1])[0] - np.asarray(actual)).max())
        part, self._rising = whole_path(job.checked.trajectory, self.factor), False
        if job.joins and away > self._rules.start:
            # the arm went on while the earlier goal came to rest
            since = job.arrived if job.begin is None else job.begin
            passed = anyio.current_time() - since + _LAG
            part = self._rest(path, actual, nearest_time(path, actual, 0.0, passed))
        self._path = path
        begin = anyio.current_time() if job.begin is None else job.begin
        while True:
            tolerances = self._running.checked.tolerances
            self._due = begin + part.trajectory.duration + tolerances.goal_time
            try:
                if await self._follow_part(part, tolerances):
                    await self._come_to_rest()
                    return None
                reached = 0.0 if self.progress is None else self.progress.time
                if self._paused:
                    self._due = math.inf
                    # an arm that was switched off meanwhile goes on by no resume
                    while not self._resumed.is_set():
                        self._note_rest(await self._standing(), reached)
                        with anyio.move_on_after(_LOOK_PAUSED):
                            await self._resumed.wait()
                actual = await self._standing()
            except DucoError as error:
                return error
            begin = anyio.current_time()
            path, tolerances = self._path, self._running.checked.tolerances
            at, off = self._note_rest(actual, reached)
            if tolerances.path and np.any(off > tolerances.path):
                text = f"a joint is {off.max():.4g} rad from the path on which it paused"
                return GoalEnded(ErrorCode.PATH_TOLERANCE_VIOLATED, text)
            part = self._rest(path, actual, at)

    def _note_rest(
        self, actual: Sequence[float], reached: float
    ) -> tuple[float, NDArray[np.float64]]:
        """Note where the arm came to rest, and return its time on the path and its distance."""
        at = nearest_time(self._path, actual, reached - _LAG, reached + _LAG)
        self.progress = GoalProgress(at, self._path.at(np.array([at]))[0], np.asarray(actual))
        return at, np.abs(self.progress.error)

    def _rest(self, path: Any, actual: Sequence[float], begin: float) -> PathPart:
        self._rising = True
        return rest_of_path(path, actual, begin=begin, factor=self.factor, profile=self._profile)

    async def _follow_part(self, part: PathPart, tolerances: Tolerances) -> bool:
        """Follow a part of a path, and the goals that take over on it.

        Returns:
            Whether to the end, or until a pause or another speed.
        """
        self._followed, self._switch, self._at_rest = part, TrajectorySwitch(), anyio.Event()
        due = 0.0
        period = self._period

        def feedback(found: Any) -> None:
            nonlocal due
            now = anyio.current_time()
            assert self._followed is not None
            time = self._followed.path_time(found.time)
            place = GoalProgress(time, found.desired, found.actual)
            self.progress = place
            self._recent.append((now, found.actual))
            if now >= due:
                # Keep the schedule of the first feedback; missed ones are skipped.
                due = max(due + period, now - period) if due else now + period
                self._running.handle.feedback(place)

        with anyio.CancelScope() as scope:
            self._part = scope
            if self._paused:
                scope.cancel()
            await self._robot.motion.follow_joint_trajectory(
                part.trajectory,
                v=max(self._profile.velocity),
                a=self._profile.acceleration,
                tolerances=tolerances,
                feedback=feedback,
                switch=self._switch,
                reach=2.0 * self._rules.start,
                through=self._through,
                options=self._options,
            )
            return True
        self._at_rest.set()
        return False

    async def _come_to_rest(self) -> None:
        """Wait until the joints are as slow as the goal asks for."""
        most = self._running.checked.goal_speed
        if most is None:
            return
        async for _ in every(_LOOK):
            if np.all(np.abs(await self._robot.state.get_actual_joints_speed()) <= most):
                return

    async def _watch_time(self) -> None:
        """End a goal that is late by its own times."""
        async for _ in every(_LOOK):
            if anyio.current_time() >= self._due:
                break
        late = self._running.checked.tolerances.goal_time
        text = f"not there {late:g} s after the goal's own end"
        self._halt("", GoalEnded(ErrorCode.GOAL_TOLERANCE_VIOLATED, text))

    async def _watch_speed(self) -> None:
        """End a goal whose joints have other speeds than its path, by more than it allows."""
        async for _ in every(_LOOK):
            place, most = self.progress, self._running.checked.path_speed
            if most is None:
                continue
            try:
                speeds = await self._robot.state.get_actual_joints_speed()
            except DucoError as error:
                text = (
                    f"the joints' speeds, for which it has path tolerances, were not read: {error}"
                )
                self._halt("", GoalEnded(ErrorCode.PATH_TOLERANCE_VIOLATED, text))
                return
            if place is None or self._part is None or self._part.cancel_called:
                continue
            if self.progress is not None and self._running.checked.path_speed is not most:
                continue  # another goal took over meanwhile
            # the arm lags behind: each speed that the path had since then is right
            times = np.linspace(place.time - _LAG, place.time + _LOOK, 16)
            wanted = self._path.velocity(np.clip(times, 0.0, self._path.times[-1])) * self.factor
            low, high = wanted.min(axis=0), wanted.max(axis=0)
            if self._rising:
                low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
            over = np.maximum(speeds - high, low - speeds) - np.array(most)
            # a speed that the controller does not tell is NaN: as bad as any
            over[np.isnan(speeds) & np.isfinite(most)] = math.inf
            if np.nanmax(over, initial=0.0) > 0.0:
                worst = int(np.nanargmax(over))
                text = f"{over[worst]:.3g} rad/s beyond its path tolerance"
                if np.isnan(speeds[worst]):
                    text = "not told by the controller, and has a path tolerance"
                text = f"the speed of {self._profile.joint_names[worst]} is {text}"
                self._halt("", GoalEnded(ErrorCode.PATH_TOLERANCE_VIOLATED, text))

    async def _watch_client(self) -> None:
        """End a goal whose client has gone: no client could cancel it."""
        async for _ in every(_LOOK):
            if not self._running.handle.alive():
                break
        _log.warning("the client of the goal is gone: the arm comes to rest")
        if self._stop_at_loss and self._part is not None:
            with contextlib.suppress(DucoError):
                await self._robot.stop()
        self._halt("its client is gone")


def _reject(handle: GoalHandle, error: Exception) -> None:
    """Tell the client of a goal that it was not started."""
    code = error.code if isinstance(error, GoalRefused) else ErrorCode.INVALID_GOAL
    handle.rejected(code, said(error))
