"""Supervised execution of a plan, also in a scene that changes meanwhile."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import anyio
import numpy as np

from aioduco._process.threads import in_thread
from aioduco.errors import FirstPointTooFar, ParameterError, PlanObstructed
from aioduco.models.ranges import JOINT_SPEED
from aioduco.planning.scene import Scene, require_scene

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from aioduco.planning.plan import Plan, PlanCheck
    from aioduco.planning.planner import Planner
    from aioduco.streaming.joint_trajectory import Feedback, Tolerances, TrajectoryResult
    from aioduco.streaming.shared.options import WorkerOptions


_NEAR = 0.01  # largest distance of a joint from the start of the plan [rad]
_REPLANS = 5  # at most, in one execution
_ROOM = 1.5  # factor for the stream's own limit of acceleration, so that the stream rounds nothing

ReadJoints: TypeAlias = "Callable[[], Awaitable[Sequence[float]]]"
"""Reads where the arm is [rad]."""


async def execute(
    motion: Any,
    read_joints: ReadJoints,
    plan: Plan,
    *,
    watch: Scene | None = None,
    planner: Planner | None = None,
    through: str = "auto",
    tolerances: Tolerances | None = None,
    feedback: Callable[[Feedback], object] | None = None,
    options: WorkerOptions | None = None,
) -> TrajectoryResult | None:
    """Carry out a plan: see `robot.motion.execute`.

    Raises:
        FirstPointTooFar: the arm is not where the plan begins; nothing was sent.
        PlanObstructed: the arm would touch something in the scene that is watched.
        ParameterError: an argument is not allowed; nothing was sent.
    """
    if watch is not None:
        require_scene("watch", watch, plan.arm)
    if planner is not None and watch is None:
        raise ParameterError("planner", planner, "given with a scene to watch")
    if planner is not None and not callable(getattr(planner, "plan", None)):
        raise ParameterError("planner", planner, "a Planner")
    blended = through == "blended"
    supervision = (watch, tolerances, feedback, options)
    if blended and any(each is not None for each in supervision):
        expected = "another for watch, tolerances, feedback and options"
        raise ParameterError("through", through, expected)
    for _ in range(_REPLANS):
        await _at_start(plan, read_joints)
        # Read before the check, so that a change during the check is checked too.
        revision = 0 if watch is None else watch.revision
        if watch is not None:
            await _checked(plan, watch, 0.0)
        if plan.duration == 0.0:
            return None
        if blended:
            a = min(plan.limits.acceleration)
            await motion.run(*(motion.movej2(q, v, a, r=r) for q, v, r in plan.waypoints()))
            return None
        followed = _Followed(plan, watch, revision, feedback)
        result = await followed.run(motion, tolerances=tolerances, through=through, options=options)
        if followed.obstructed is None or result is not None:
            return result
        here = await read_joints()
        if planner is None:
            raise PlanObstructed(
                f"the way ahead is not free any more: {followed.obstructed}. The arm was brought "
                "to rest on its way; plan again from where it is",
                pair=followed.obstructed.clearance.pair,
                joints=followed.obstructed.joints,
            )
        # Along a line the tool's speed was asked for, which the limits of the joints do not have.
        limits, fastest = plan.limits, max(float(plan.rates.max()), JOINT_SPEED.low)
        plan = await planner.plan(
            here,
            plan.end,
            v=[min(each, fastest) for each in limits.velocity],
            a=limits.acceleration,
            jerk=limits.jerk,
            upright=plan.upright,
        )
    raise PlanObstructed(f"the way was not free after {_REPLANS} plans; the arm stands on its way")


async def _at_start(plan: Plan, read_joints: ReadJoints) -> None:
    far = np.abs(np.asarray(await read_joints()) - plan.start.array)
    if far.max() > _NEAR:
        joint = int(far.argmax())
        raise FirstPointTooFar(
            f"the plan begins at another place: joint {joint + 1} is {far[joint]:.4f} rad from "
            "there; nothing was sent. Plan from where the arm is, or move it to plan.start"
        )


async def _checked(plan: Plan, scene: Scene, after: float) -> None:
    found = await _check(plan, scene, after)
    if not found:
        raise PlanObstructed(
            f"the plan is not free in the scene as it is now: {found}; nothing was sent",
            pair=found.clearance.pair,
            joints=found.joints,
        )


async def _check(plan: Plan, scene: Scene, after: float) -> PlanCheck:
    return await in_thread(lambda: plan.check(scene, after=after))


class _Followed:
    """Follows one plan by the stream; brings the arm to rest if the path is no longer free.

    Args:
        plan: the plan.
        scene: the scene that is watched, if any.
        revision: revision of the scene in which the plan was found free.
        feedback: the user's callback.
    """

    def __init__(
        self,
        plan: Plan,
        scene: Scene | None,
        revision: int,
        feedback: Callable[[Feedback], object] | None,
    ) -> None:
        self._plan, self._scene, self._feedback = plan, scene, feedback
        self._checked_revision = revision
        self._changed = anyio.Event()
        self._time = 0.0
        self._error: Exception | None = None
        self.obstructed: PlanCheck | None = None

    async def run(self, motion: Any, **options: Any) -> TrajectoryResult | None:
        """Follow the plan; None if it ended before the goal."""
        limits = self._plan.limits
        result: TrajectoryResult | None = None
        self._notice_change()
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._watch, tasks.cancel_scope)
            try:
                result = await motion.follow_joint_trajectory(
                    self._plan.trajectory,
                    v=max(limits.velocity),
                    a=_ROOM * max(limits.acceleration),
                    reach=2.0 * _NEAR,
                    feedback=self._on_feedback,
                    **options,
                )
            except Exception as error:  # raised below, outside of the group
                self._error = error
            tasks.cancel_scope.cancel()
        if self._error is not None:
            raise self._error
        return result

    def _notice_change(self) -> None:
        if self._scene is not None and self._scene.revision != self._checked_revision:
            self._checked_revision = self._scene.revision
            self._changed.set()

    def _on_feedback(self, feedback: Feedback) -> None:
        self._time = feedback.time
        self._notice_change()
        if self._feedback is not None:
            self._feedback(feedback)

    async def _watch(self, following: anyio.CancelScope) -> None:
        while True:
            await self._changed.wait()
            self._changed = anyio.Event()
            assert self._scene is not None
            try:
                found = await _check(self._plan, self._scene, self._time)
            except Exception as error:  # the scene cannot be compiled: the arm must not continue
                self._error = error
            else:
                self.obstructed = None if found else found
            if self._error is not None or self.obstructed is not None:
                following.cancel()
                return
