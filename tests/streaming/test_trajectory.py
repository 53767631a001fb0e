"""Joint trajectories: sampled as given, compared with the arm, cancelled on the way."""

from __future__ import annotations

import itertools
from typing import Any

import anyio
import numpy as np
import pytest
import scipy
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from aioduco.api.motion.trajectory import follow
from aioduco.api.streams.realtime import CYCLE
from aioduco.errors import (
    CallTimeout,
    FirstPointTooFar,
    GoalToleranceViolated,
    ParameterError,
    PathToleranceViolated,
    StreamLost,
)
from aioduco.streaming.joint_trajectory import (
    Feedback,
    JointTrajectory,
    Tolerances,
    TrajectoryResult,
)
from aioduco.streaming.sampling import Spline, sampled
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.shared.space import JOINT_SPACE, POSE_SPACE, Config, PoseSpace
from aioduco.streaming.worker.clock import Schedule

from .conftest import HERE, Controller, Cycles, answer_all, came_to_rest

#: a busy machine may take long over an answer
THREAD = WorkerOptions(run_in="thread", timeout=20.0)

# -- curves ------------------------------------------------------------------------------------

COUNT = st.integers(2, 8)


@st.composite
def curves(draw: st.DrawFn) -> tuple[Any, Any, Any]:
    count = draw(COUNT)
    steps = draw(hnp.arrays(np.float64, count, elements=st.floats(0.01, 2.0)))
    numbers = hnp.arrays(np.float64, (count, 6), elements=st.floats(-3, 3, width=32))
    return np.cumsum(steps), draw(numbers), draw(numbers)


@given(curves())
def test_points_alone_are_joined_without_overshoot(curve: tuple[Any, Any, Any]) -> None:
    times, points, _ = curve
    at = np.linspace(times[0], times[-1], 200)
    found = Spline(times, points).at(at)
    index = np.clip(np.searchsorted(times, at, "right") - 1, 0, len(times) - 2)
    low = np.minimum(points[index], points[index + 1])
    high = np.maximum(points[index], points[index + 1])
    assert np.all(found >= low - 1e-9)
    assert np.all(found <= high + 1e-9)
    np.testing.assert_allclose(Spline(times, points).at(times), points, atol=1e-12)
    np.testing.assert_allclose(Spline(times, points).velocity(times[[0, -1]]), 0.0, atol=1e-9)


@pytest.mark.slow
@given(curves())
def test_inside_the_slopes_are_those_of_pchip(curve: tuple[Any, Any, Any]) -> None:
    times, points, _ = curve
    theirs = scipy.interpolate.PchipInterpolator(times, points).derivative()(times[1:-1])
    np.testing.assert_allclose(Spline(times, points).velocity(times)[1:-1], theirs, atol=1e-6)


@pytest.mark.slow
@given(curves())
def test_velocities_given_are_had(curve: tuple[Any, Any, Any]) -> None:
    times, points, velocities = curve
    at = np.linspace(times[0], times[-1], 50)
    found = Spline(times, points, velocities)
    reference = scipy.interpolate.CubicHermiteSpline(times, points, velocities)
    np.testing.assert_allclose(found.at(at), reference(at), atol=1e-9)
    np.testing.assert_allclose(found.velocity(at), reference.derivative()(at), atol=1e-6)


@pytest.mark.slow
@given(curves())
def test_accelerations_given_are_had(curve: tuple[Any, Any, Any]) -> None:
    times, points, velocities = curve
    accelerations = velocities[::-1].copy()
    found = Spline(times, points, velocities, accelerations)
    at = np.linspace(times[0], times[-1], 50)
    given_at_points = np.stack([points, velocities, accelerations], axis=1)
    reference = scipy.interpolate.BPoly.from_derivatives(times, given_at_points)
    np.testing.assert_allclose(found.at(at), reference(at), atol=1e-9)
    np.testing.assert_allclose(found.velocity(at), reference.derivative()(at), atol=1e-6)


def test_a_trajectory_says_how_long_it_is() -> None:
    trajectory = JointTrajectory([[0.0] * 6, [0.1] * 6, [0.2] * 6], [0.0, 0.5, 1.25])
    assert repr(trajectory) == "<JointTrajectory 3 points in 1.25 s>"


def test_poses_are_sampled_by_the_shortest_turn() -> None:
    start, end = [0.5, 0.0, 0.4, 3.0, 0.0, 0.0], [0.6, 0.0, 0.4, -3.0, 0.0, 0.0]
    found = list(sampled(POSE_SPACE, [start, end], [0.0, 1.0], 0.1))
    assert np.shape(found) == (11, 6)
    turns = [
        POSE_SPACE.difference(POSE_SPACE.decode(a), POSE_SPACE.decode(b))[3]
        for a, b in itertools.pairwise(found)
    ]
    np.testing.assert_allclose(turns, (2 * np.pi - 6.0) / 10, atol=1e-9)


def test_a_long_array_is_sampled_bit_by_bit() -> None:
    """All of it takes seconds, in which an event loop would not run, and the robot be stopped."""
    made = []

    class Counting(PoseSpace):
        def encode(self, config: Config) -> tuple[float, ...]:
            made.append(config)
            return super().encode(config)

    found = sampled(Counting(), [[0.1] * 6, [0.2] * 6], [0.0, 100.0], 0.01)
    next(found)
    assert len(made) <= 256
    assert len(list(found)) == 10_000


@for_each(
    "trajectory, times, name",
    [
        ([[0.0] * 5], [0.0], "trajectory"),
        ([], [], "trajectory"),
        ([[0.0] * 6] * 2, [0.0, 0.0], "times"),
        ([[0.0] * 6] * 2, [1.0, 0.5], "times"),
        ([[0.0] * 6] * 2, [0.0], "times"),
        ([[float("nan")] * 6], [0.0], "trajectory"),
        ("nonsense", None, "trajectory"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(trajectory: Any, times: Any, name: str) -> None:
    with pytest.raises(ParameterError) as caught:
        next(sampled(JOINT_SPACE, trajectory, times, 0.01))
    assert caught.value.parameter == name


# -- execution ---------------------------------------------------------------------------------


@pytest.fixture
def missed(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Ticks that a busy machine let the stream's worker miss."""
    found: list[int] = []
    advance = Schedule.advance

    def counted(schedule: Schedule, now: int) -> int:
        found.append(advance(schedule, now))
        return found[-1]

    monkeypatch.setattr(Schedule, "advance", counted)
    return found


class Arm:
    """An arm that does what it is told, a few set-points later, or does not."""

    def __init__(self, controller: Controller, lag: int = 10) -> None:
        self.controller = controller
        self.lag = lag
        self.stuck = np.full(6, np.inf)
        self.offset = np.zeros(6)

    async def joints(self) -> list[float]:
        points = self.controller.points()
        place = np.array(points[max(0, len(points) - self.lag)] if points else HERE)
        place = np.minimum(place, self.stuck) + self.offset
        return [float(angle) for angle in place]


def there_and_back() -> JointTrajectory:
    here = np.array(HERE)
    return JointTrajectory([here, here + 0.1, here], [0.0, 0.3, 0.6])


async def run(
    controller: Controller, arm: Arm, trajectory: JointTrajectory | None = None, **options: Any
) -> TrajectoryResult:
    settings: dict[str, Any] = {"realtime": False, "v": 1.0, "a": 20.0, "options": THREAD}
    way = trajectory or there_and_back()
    return await follow(controller.endpoint, arm.joints, way, **(settings | options))


async def test_a_trajectory_is_followed_to_its_goal_with_feedback(controller: Controller) -> None:
    seen: list[Feedback] = []
    result = await run(controller, Arm(controller), feedback=seen.append)
    points = np.array(controller.points())
    assert points[:, 0].max() == pytest.approx(HERE[0] + 0.1, abs=1e-3)
    assert result.duration >= 0.6
    assert np.all(np.abs(result.goal_error) <= 0.01)
    assert np.all(result.path_error <= 0.005)
    assert len(seen) > 10
    times = [each.time for each in seen]
    assert times == sorted(times)
    for each in seen:
        np.testing.assert_allclose(each.error, each.actual - each.desired)
    assert controller.stops == []


@pytest.mark.slow
async def test_a_first_time_above_zero_leads_up_from_where_the_arm_is(
    controller: Controller,
) -> None:
    goal = np.array(HERE) + 0.15
    await run(controller, Arm(controller), JointTrajectory([goal], [0.5]))
    points = np.array(controller.points())
    np.testing.assert_allclose(points[0], HERE, atol=1e-3)
    np.testing.assert_allclose(points[-1], goal, atol=1e-9)


async def test_an_arm_that_is_stuck_violates_the_path(
    controller: Controller, missed: list[int]
) -> None:
    arm = Arm(controller)
    arm.stuck = np.array([HERE[0] + 0.03, *[np.inf] * 5])
    with pytest.raises(PathToleranceViolated, match="joint 1"):
        await run(controller, arm, tolerances=Tolerances(path=0.02))
    assert controller.stops == ["stop"]
    # It was brought to rest: not at the end, and not in one tick.
    assert came_to_rest(controller, 500, 20.0, sum(missed))


async def test_a_joint_whose_tolerance_is_0_is_not_looked_at_on_the_way(
    controller: Controller,
) -> None:
    arm = Arm(controller)
    arm.offset = np.array([0, 0.05, 0, 0, 0, 0])
    loose = Tolerances(path=(0.04, 0, *[0.04] * 4), goal=0.1, goal_time=20.0)
    assert (await run(controller, arm, tolerances=loose)).path_error[1] > 0.04


@pytest.mark.slow
@pytest.mark.parametrize("goal", [0.01, 0, (*[0.01] * 5, 0)])
async def test_an_arm_that_does_not_arrive_violates_the_goal(
    controller: Controller, goal: float | tuple[float, ...]
) -> None:
    arm = Arm(controller)
    arm.offset = np.array([0, 0, 0, 0, 0, 0.05])
    with pytest.raises(GoalToleranceViolated, match="joint 6"):
        await run(controller, arm, tolerances=Tolerances(path=0, goal=goal, goal_time=0.1))


@pytest.mark.slow
@pytest.mark.parametrize("on_the_way", [True, False])
async def test_an_arm_whose_place_is_not_answered_comes_to_rest(
    controller: Controller, missed: list[int], on_the_way: bool
) -> None:
    arm = Arm(controller)

    async def joints() -> list[float]:
        places = [point[0] for point in controller.points()] or [HERE[0]]
        if max(places) > HERE[0] + 0.05 and (on_the_way or places[-1] <= HERE[0] + 1e-6):
            raise CallTimeout("no answer came in time")
        return await arm.joints()

    with pytest.raises(StreamLost, match=r"where the arm is \(no answer came in time\)"):
        await follow(
            controller.endpoint, joints, there_and_back(), realtime=False, v=1.0, a=20.0,
            options=THREAD,
        )  # fmt: skip
    assert came_to_rest(controller, 500, 20.0, sum(missed))


async def test_cancelling_brings_the_arm_to_rest(controller: Controller, missed: list[int]) -> None:
    arm = Arm(controller)
    with anyio.CancelScope() as scope:

        def after_a_while(feedback: Feedback) -> None:
            if feedback.time > 0.1:
                scope.cancel()

        await run(controller, arm, feedback=after_a_while)
    assert scope.cancelled_caught
    assert came_to_rest(controller, 500, 20.0, sum(missed))
    assert controller.points()[-1][0] > HERE[0] + 1e-3


async def test_a_trajectory_that_begins_elsewhere_is_refused(controller: Controller) -> None:
    there = np.array(HERE) + 0.2
    trajectory = JointTrajectory([there, there + 0.1], [0.0, 1.0])
    with pytest.raises(FirstPointTooFar, match=r"joint 1: 0\.2 rad away"):
        await run(controller, Arm(controller), trajectory)
    assert not controller.points()


async def test_a_trajectory_too_fast_is_refused(controller: Controller) -> None:
    with pytest.raises(ParameterError, match=r"up to 0\.2 rad/s"):
        await run(controller, Arm(controller), v=0.2)


async def test_a_speed_above_v_by_rounding_is_followed_within_v(controller: Controller) -> None:
    """`v` may be the limit from which the trajectory was computed, as that of a goal of ROS."""
    way = there_and_back()
    fastest = np.abs(np.diff(way.curve(HERE).at(np.arange(0.0, 0.6, 0.002)), axis=0)).max() / 0.002
    v = fastest / 1.0005
    await run(controller, Arm(controller), way, v=v)
    steps = np.diff(np.array(controller.points()), axis=0)
    assert np.abs(steps).max() <= v * 0.002 * (1 + 1e-6)
    with pytest.raises(ParameterError, match="rad/s, but must be up to"):
        await run(controller, Arm(controller), way, v=fastest / 1.002)


async def test_a_trajectory_that_ends_in_motion_is_refused(controller: Controller) -> None:
    """The arm would go beyond its last point, as far as it takes to brake, and come back."""
    here = np.array(HERE)
    moving = JointTrajectory([here, here + 0.1], [0.0, 0.5], [[0.0] * 6, [0.3] * 6])
    with pytest.raises(ParameterError, match=r"0\.3 rad/s at its last point"):
        await run(controller, Arm(controller), moving)
    assert not controller.server.received("servoj")


@pytest.mark.slow
async def test_through_the_realtime_queue(controller: Controller) -> None:
    queue = Cycles(CYCLE)
    answer_all(controller.server, queue.answers)

    async def joints() -> list[float]:
        queue.size()
        return list(queue.points[queue.taken - 1].joint_pos_cmd) if queue.taken else HERE

    arm = Arm(controller)
    arm.joints = joints  # type: ignore[method-assign]  # it follows the queue
    result = await run(controller, arm, realtime=True)
    assert np.all(np.abs(result.goal_error) <= 0.01)
    places = np.array([point.joint_pos_cmd for point in queue.points])
    assert places[:, 0].max() == pytest.approx(HERE[0] + 0.1, abs=1e-4)


@for_each(
    "arguments, name",
    [
        (([[0.0] * 6] * 2, [0.0]), "times"),
        (([[0.0] * 6] * 2, [-1.0, 0.5]), "times"),
        (([[0.0] * 6] * 2, ["soon", "late"]), "times"),
        (([[0.0] * 6] * 2, [0.0, 1.0], [[0.0] * 6]), "velocities"),
        (([[0.0] * 6] * 2, [0.0, 1.0], None, [[0.0] * 6] * 2), "accelerations"),
        (([[7.0] * 6] * 2, [0.0, 1.0]), "positions"),
    ],
)
def test_trajectories_that_do_not_fit_are_refused(arguments: Any, name: str) -> None:
    with pytest.raises(ParameterError) as caught:
        JointTrajectory(*arguments)
    assert caught.value.parameter.startswith(name)


def test_the_times_of_a_trajectory_are_a_copy_and_cannot_be_changed() -> None:
    times = np.array([0.0, 1.0])
    trajectory = JointTrajectory([[0.0] * 6] * 2, times)
    times[1] = -1.0
    assert trajectory.times.tolist() == [0.0, 1.0]
    with pytest.raises(ValueError, match="read-only"):
        trajectory.times[1] = -1.0
