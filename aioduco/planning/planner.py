"""The planner: it plans in a separate process, so that planning does not delay the program."""

from __future__ import annotations

import importlib.util
import threading
from typing import TYPE_CHECKING, Any

import anyio
import numpy as np

from aioduco._process import trial
from aioduco._process.closing import Closable
from aioduco._process.linked_process import LinkedProcess
from aioduco._process.spawn import Unstartable
from aioduco._process.threads import in_thread
from aioduco.errors import MissingExtra, NoPathFound, ParameterError, PlanningError
from aioduco.models.bounds import clipped
from aioduco.models.pose import JointsLike, Pose, PoseLike
from aioduco.models.ranges import JOINTS, POSE
from aioduco.models.rules import Integer, Number
from aioduco.planning.motion_limits import MotionLimits
from aioduco.planning.plan import Plan
from aioduco.planning.problem import GoalLike, PlanningProblem, WorkerScene, goals_of
from aioduco.planning.toolpath import poses_along

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.planning.scene import Scene

    PerJoint = float | Sequence[float]


_SEED = Integer(1, 2**31 - 1, source="this package")
_SPEED = Number(1e-4, unit="m/s", source="this package")
_TIMEOUT = Number(1e-3, 600.0, "s", source="this package")
_NEEDS = ("mujoco", "ompl")
_START = 60.0  # until a process that has not loaded its packages is killed [s]
_GRACE = 5.0  # from a problem's time-out until its process is killed, such as to time a path [s]
#: packages that the process imports; MuJoCo imports mostly OpenGL
_PACKAGES = (*_NEEDS, "OpenGL", "charset_normalizer", "glfw")


class _Request:
    """A problem that may be cancelled, without an effect on the other problems of the planner."""

    def __init__(self, problem: PlanningProblem, scene: Scene) -> None:
        self.problem, self.scene = problem, scene
        self._lock = threading.Lock()
        self._process: LinkedProcess | None = None
        #: whether nobody waits for the answer any more
        self.cancelled: bool = False

    def cancel(self) -> None:
        """Cancel it; this kills the process if it is at this problem."""
        with self._lock:
            self.cancelled = True
            if self._process is not None:
                self._process.popen.kill()

    def begin(self, process: LinkedProcess) -> None:
        """From now on the process is at this problem."""
        with self._lock:
            self._process = process
            if self.cancelled:
                process.popen.kill()

    def finish(self) -> None:
        """From now on a cancellation does not kill the process."""
        with self._lock:
            self._process = None


class Planner(Closable):
    """Plans paths of an arm through a scene (规划器).

        async with Planner(scene) as planner:
            plan = await planner.plan(here, Pose(0.4, 0.3, 0.5, math.pi, 0, 0), v=1.0, a=2.0)
            await robot.motion.execute(plan)

    A separate process does the work, one plan after another; it starts with the first plan. The
    planner kills it when the plan that it is making is cancelled or overdue, and starts it again
    for the next plan. A planner also works without `with`; its process then ends with `close`, or
    with the program. In a forked child, a planner that has planned before raises `WrongProcess`:
    make another one there.

    Args:
        scene: scene to plan in; it may change between plans.
        tool: the tool's tip in the flange's frame [m, rad]; poses as goals are poses of this tip.
            None for the flange itself.
        seed: seed of the search, from 1; the same problems in the same order give the same paths,
            unless one is cancelled or its time is over.

    Raises:
        MissingExtra: something of `aioduco[plan]` is not installed.
        ParameterError: `scene` is no scene, or the seed is out of range.
    """

    def __init__(self, scene: Scene, *, tool: PoseLike | None = None, seed: int = 1) -> None:
        for package in _NEEDS:
            if importlib.util.find_spec(package) is None:
                raise MissingExtra("planning", package, "plan")
        from aioduco.planning.scene import Scene  # noqa: PLC0415 - whoever has a scene has loaded it

        if not isinstance(scene, Scene):
            raise ParameterError("scene", scene, "a Scene")
        seed = _SEED("seed", seed)
        self.scene = scene
        self._tip = np.eye(4) if tool is None else Pose(*POSE("tool", tool)).matrix
        self._seed = seed
        self._lock = threading.Lock()
        self._process: LinkedProcess | None = None
        #: whether the process has the seed
        self._seeded = False
        #: the scene that the process has, and its revision
        self._sent: tuple[Scene, int] | None = None

    def __repr__(self) -> str:
        state = "not started" if self._process is None else f"process {self._process.popen.pid}"
        return f"<Planner in {self.scene!r}, {state}>"

    # -- plans ---------------------------------------------------------------------------------

    async def plan(
        self,
        start: JointsLike,
        goal: GoalLike,
        *,
        v: PerJoint = 1.0,
        a: PerJoint = 2.0,
        jerk: PerJoint | None = None,
        upright: bool = False,
        timeout: float = 5.0,
    ) -> Plan:
        """Find a path to a goal on which the arm touches nothing.

        Cancelling this ends the search at once.

        Args:
            start: where the arm is, six joint angles [rad].
            goal: `Joints`, a `Pose` of the tool in the base frame, a `Region`, or several of
                these; a path to any of them is enough. For a pose, every configuration is a goal.
            v: largest speed of each joint, 0.000175 to 3.926, one number or six [rad/s].
            a: largest acceleration of each joint, from 0.000175 [rad/s²].
            jerk: largest jerk of each joint [rad/s³]; None: 10 times the acceleration, per s.
            upright: whether the tool may turn about the vertical only, like an open cup. At the
                goal it must be upright as at the start, within 0.02 rad, which the plan leaves
                out; no joint goes further than half a turn.
            timeout: time-out of the search, 0.001 to 600 [s].

        Returns:
            The plan, a value; nothing moves.

        Raises:
            StartInCollision: the arm touches something at the start.
            GoalInCollision: the arm would touch something at each goal.
            GoalOutOfReach: no goal can be reached.
            NoPathFound: no path was found in time.
            ParameterError: an argument is out of range.
        """
        limits = {"v": v, "a": a, "jerk": jerk, "timeout": timeout}
        return await self._ask(self._free(start, goal, upright=upright, **limits))

    async def line(
        self,
        start: JointsLike,
        to: PoseLike,
        *,
        via: PoseLike | None = None,
        speed: float = 0.25,
        v: PerJoint = 1.0,
        a: PerJoint = 2.0,
        jerk: PerJoint | None = None,
        partial: bool = False,
        timeout: float = 5.0,
    ) -> Plan:
        """Plan a straight line or an arc of the tool, on one branch of the arm.

        Args:
            start: where the arm is, six joint angles [rad].
            to: pose of the tool at the end, in the base frame [m, rad].
            via: a pose on the path, which is then the arc through it; its orientation is not used.
            speed: largest speed of the tool, from 0.0001 [m/s].
            v: largest speed of each joint [rad/s].
            a: largest acceleration of each joint [rad/s²].
            jerk: largest jerk of each joint [rad/s³]; None: 10 times the acceleration, per s.
            partial: whether to plan a part of the path if not all of it is free and within reach;
                `Plan.fraction` is the share of the path.
            timeout: time-out, 0.001 to 600 [s].

        Returns:
            The plan, a value; nothing moves.

        Raises:
            StartInCollision: the arm touches something at the start.
            PathIncomplete: only a part of the path is free and within reach.
            ParameterError: an argument is out of range.
        """
        limits = {"v": v, "a": a, "jerk": jerk, "timeout": timeout}
        line = self._line(start, to, via=via, speed=speed, partial=partial, **limits)
        return await self._ask(line)

    def plan_blocking(self, start: JointsLike, goal: GoalLike, **options: Any) -> Plan:
        """Find a path to a goal, for programs without an event loop: see `plan`.

        Args:
            start: where the arm is, six joint angles [rad].
            goal: the goal.
            options: the other arguments of `plan`.
        """
        return self._solve(self._free(start, goal, **options))

    def line_blocking(self, start: JointsLike, to: PoseLike, **options: Any) -> Plan:
        """Plan a line or an arc of the tool, for programs without an event loop: see `line`.

        Args:
            start: where the arm is, six joint angles [rad].
            to: pose of the tool at the end, in the base frame [m, rad].
            options: the other arguments of `line`.
        """
        return self._solve(self._line(start, to, **options))

    # -- problems ------------------------------------------------------------------------------

    def _free(
        self, start: JointsLike, goal: GoalLike, *, upright: bool = False, **limits: Any
    ) -> _Request:
        goals = goals_of(goal)
        return self._request(self.scene, start, goals, {"upright": upright}, **limits)

    def _line(
        self,
        start: JointsLike,
        to: PoseLike,
        *,
        via: PoseLike | None = None,
        speed: float = 0.25,
        partial: bool = False,
        **limits: Any,
    ) -> _Request:
        scene = self.scene
        speed = _SPEED("speed", speed)
        end = Pose(*POSE("to", to))
        goals = (end,) if via is None else (Pose(*POSE("via", via)), end)
        if via is not None:
            # Raises if the three points are on a line, which is not an arc.
            first = scene.arm.fkine(start) @ self._tip
            poses_along(first, goals[0].matrix, goals[-1].matrix)
        shape = "line" if via is None else "arc"
        kind = {"shape": shape, "rate": speed, "partial": partial}
        return self._request(scene, start, goals, kind, **limits)

    def _request(
        self,
        scene: Scene,
        start: JointsLike,
        goals: tuple[Any, ...],
        kind: dict[str, Any],
        *,
        v: PerJoint = 1.0,
        a: PerJoint = 2.0,
        jerk: PerJoint | None = None,
        timeout: float = 5.0,
    ) -> _Request:
        timeout = _TIMEOUT("timeout", timeout)
        problem = PlanningProblem(
            arm=scene.arm,
            start=clipped(JOINTS("start", start), scene.arm.lower, scene.arm.upper),
            goals=goals,
            limits=MotionLimits.of(scene.arm, v, a, jerk),
            tip=self._tip,
            up=scene.mounting.matrix[2, :3].copy(),
            padding=scene.padding,
            timeout=timeout,
            **kind,
        )
        return _Request(problem, scene)

    # -- the process ---------------------------------------------------------------------------

    async def _ask(self, request: _Request) -> Plan:
        try:
            with trial.untimed():  # also while the loop waits for the thread
                return await in_thread(self._solve, request, abandon_on_cancel=True)
        except anyio.get_cancelled_exc_class():
            # The thread then reads the end of the channel, and ends.
            request.cancel()
            raise

    def _solve(self, request: _Request) -> Plan:
        if self._process is not None:
            self._process.channel.require_own()
        with trial.untimed(), self._lock:
            if request.cancelled:
                raise PlanningError("the plan was cancelled before its turn came")
            answer = self._exchange(request)
        if isinstance(answer, PlanningError):
            raise answer
        assert isinstance(answer, Plan)
        return answer

    def _exchange(self, request: _Request) -> Any:
        process = self._process or self._start()
        problem, asked = request.problem, False
        late = threading.Event()

        def end() -> None:
            late.set()
            process.popen.kill()

        starting = threading.Timer(_START, end)
        overdue = threading.Timer(problem.timeout + _GRACE, end)
        request.begin(process)
        try:
            if not self._seeded:
                # Wait until it has loaded its packages, which is not part of a problem's time.
                starting.start()
                process.channel.receive()
                starting.cancel()
                process.channel.send(self._seed)
                self._seeded = True
            unsent = self._unsent(request.scene)
            asked = True
            if unsent is not None:
                revision, values = unsent
                process.channel.send(values)
                self._sent = request.scene, revision
            process.channel.send(problem)
            overdue.start()
            answer = process.channel.receive()
            asked = False
        except (EOFError, OSError) as error:
            said = self._discard(process)
            if late.is_set() and not self._seeded:
                raise PlanningError(
                    f"the planner's process has not started within {_START:g} s, and was ended; "
                    "plan again"
                ) from error
            if late.is_set():
                raise NoPathFound(f"the planner was not done in {problem.timeout:g} s") from error
            why = said or "it said nothing"
            raise PlanningError(f"the planner's process has ended ({why}); plan again") from error
        finally:
            if asked and self._process is process:  # first: Ctrl-C may come again
                self._process = None
            request.finish()
            for timer in (starting, overdue):
                timer.cancel()
                if timer.ident is not None:
                    timer.join()
            if asked or request.cancelled or late.is_set():
                # Its answer, if it still comes, must not be taken for that of the next problem.
                process.popen.kill()
                self._discard(process)
        return answer

    def _unsent(self, scene: Scene) -> tuple[int, WorkerScene] | None:
        """A scene for the process, with its revision; None if the process has it."""
        if self._sent is not None:
            sent, revision = self._sent
            if sent is scene and revision == scene.revision:
                return None
        return scene.for_worker()

    def _start(self) -> LinkedProcess:
        try:
            process = LinkedProcess("aioduco.planning.worker", packages=_PACKAGES)
        except (Unstartable, OSError) as error:
            raise PlanningError(f"the planner's process was not started: {error}") from error
        self._seeded, self._sent, self._process = False, None, process
        return process

    def _discard(self, process: LinkedProcess) -> str:
        """Close a process that was killed or has ended. Returns the last line that it wrote."""
        if self._process is process:
            self._process = None
        return process.end()

    def close(self) -> None:
        """End the process; return when it has exited. The planner can be used again."""
        process, self._process = self._process, None
        if process is not None:
            process.close()
