"""Goals without an arm: which are accepted, and the code of each refusal."""

from __future__ import annotations

import contextlib
import math
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from itertools import product
from types import SimpleNamespace
from typing import Any
from unittest.mock import AsyncMock

import anyio
import anyio.lowlevel
import numpy as np
import pytest
from for_each import for_each
from hypothesis import example, given
from hypothesis import strategies as st

from aioduco.errors import (
    ConnectionLost,
    DucoError,
    FirstPointTooFar,
    GoalToleranceViolated,
    ParameterError,
    PathToleranceViolated,
    StreamStopped,
)
from aioduco.integrations.ros.goal_queue import GoalQueue
from aioduco.integrations.ros.trajectory_goals import (
    CheckedGoal,
    ErrorCode,
    GoalPoint,
    GoalRefused,
    GoalRules,
    NamedLimits,
    NamedTolerance,
    TrajectoryGoal,
    check_goal,
    check_start,
    code_of,
)
from aioduco.integrations.ros.trajectory_server import GoalProgress, TrajectoryServer
from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState
from aioduco.models.state import RobotStates
from aioduco.testing import eventually_async

from .goals import NAMES, NOW, PROFILE, START, WRONG, Client, goal, way

RULES = GoalRules()


def check(given_goal: TrajectoryGoal) -> CheckedGoal:
    return check_goal(given_goal, PROFILE, RULES, NOW)


@for_each("name", WRONG)
def test_a_wrong_goal_has_its_code(name: str) -> None:
    make, code = WRONG[name]
    with pytest.raises(GoalRefused, match="nothing was sent") as refused:
        check(make())
    assert refused.value.code == code
    assert code_of(refused.value) == code


def test_joints_in_any_order() -> None:
    turned = goal(joint_names=NAMES[::-1])
    turned = replace(
        turned, points=[p._replace(positions=p.positions[::-1]) for p in turned.points]
    )
    np.testing.assert_allclose(
        check(turned).trajectory.positions, check(goal()).trajectory.positions
    )


def test_velocities_and_accelerations_make_a_curve_of_their_order() -> None:
    still = (0.0,) * 6
    points = [
        GoalPoint(START, still, still, still, 0.0),
        GoalPoint(way(1.0), still, still, still, 1.0),
    ]
    found = check(goal(points=points)).trajectory.curve(START)
    at = np.array([0.25])
    quintic = 10 * 0.25**3 - 15 * 0.25**4 + 6 * 0.25**5
    np.testing.assert_allclose(found.at(at)[0], np.array(START) + 0.3 * quintic, atol=1e-12)
    cubic = check(goal(points=[p._replace(accelerations=()) for p in points])).trajectory
    np.testing.assert_allclose(cubic.curve(START).at(at)[0], way(0.25), atol=1e-12)


def test_tolerances_are_those_of_the_goal_or_the_default_or_erased() -> None:
    found = check(
        goal(
            path_tolerance=[NamedTolerance(NAMES[1], 0.5), NamedTolerance(NAMES[2], -1.0, -1.0)],
            goal_tolerance=[NamedTolerance(NAMES[5], 0.002), NamedTolerance(NAMES[0], 0.0)],
            goal_time_tolerance=3.0,
        )
    ).tolerances
    assert isinstance(found.path, tuple)
    assert isinstance(found.goal, tuple)
    assert found.path[:2] == (RULES.path, 0.5)
    assert found.path[2] > 4 * math.pi
    assert (found.goal[0], found.goal[5], found.goal_time) == (RULES.goal, 0.002, 3.0)


def test_tolerances_of_speeds_are_those_of_the_joints_that_have_one() -> None:
    none = check(goal(path_tolerance=[NamedTolerance(NAMES[0], 0.1, -1.0)]))
    assert (none.path_speed, none.goal_speed) == (None, None)
    some = check(goal(goal_tolerance=[NamedTolerance(NAMES[1], 0.0, 0.02)]))
    assert some.path_speed is None
    assert some.goal_speed == (math.inf, 0.02, *(math.inf,) * 4)


def test_a_trajectory_begins_where_the_arm_is() -> None:
    checked = check(goal())
    check_start(checked, [q + 0.01 for q in START], PROFILE, RULES)
    with pytest.raises(GoalRefused, match="begins elsewhere") as refused:
        check_start(checked, [q + 0.05 for q in START], PROFILE, RULES)
    assert refused.value.code == ErrorCode.INVALID_GOAL


def test_a_first_point_that_is_due_later_is_led_to() -> None:
    checked = check(goal(points=[GoalPoint(way(1.0), time=1.0)]))
    check_start(checked, START, PROFILE, RULES)
    with pytest.raises(GoalRefused, match="rad/s"):
        check_start(checked, [q - 3.0 for q in START], PROFILE, RULES)
    with pytest.raises(GoalRefused):
        check_start(checked, [math.nan] * 6, PROFILE, RULES)


@for_each(
    "error, code",
    [
        (PathToleranceViolated("off"), -4),
        (GoalToleranceViolated("off"), -5),
        (FirstPointTooFar("far"), -1),
        (ParameterError("v", 9, "less"), -1),
        (StreamStopped("stop"), -4),
    ],
)
def test_errors_on_the_way_have_a_code(error: DucoError, code: int) -> None:
    assert code_of(error) == code


@for_each(
    "wrong",
    [
        {"joint_names": ("a",) * 6},
        {"joint_names": ("a", "b")},
        {"velocity": 0.0},
        {"velocity": math.nan},
        {"acceleration": -1.0},
    ],
)
def test_a_profile_is_checked(wrong: dict[str, Any]) -> None:
    with pytest.raises(ParameterError):
        NamedLimits.of("gcr5_910", **wrong)


def test_a_queue_holds_one_that_runs_and_one_that_waits() -> None:
    queue: GoalQueue[str] = GoalQueue()
    assert queue.submit("a") is None
    assert queue.begin() == "a"
    assert (queue.submit("b"), queue.superseded) == (None, True)
    assert queue.begin() is None
    assert queue.submit("c") == "b"
    assert not queue.withdraw("b")
    queue.end()
    assert queue.begin() == "c"
    assert (queue.waiting, queue.superseded) == (None, False)


# -- any goal ----------------------------------------------------------------------------------

ANY = st.floats() | st.sampled_from([0.0, -0.0, 5e-324, 1e308, math.nan, math.inf, 6.28, -1.0])
ANY_ROW = st.lists(ANY, max_size=7) | st.just(list(START)) | st.just([0.0] * 6)
POINTS = st.builds(
    GoalPoint,
    positions=ANY_ROW,
    velocities=ANY_ROW,
    accelerations=ANY_ROW,
    effort=ANY_ROW,
    time=ANY,
)
NAME = st.sampled_from([*NAMES, "", "elbow"]) | st.text(max_size=3)
TOLERANCE = st.lists(st.builds(NamedTolerance, NAME, ANY, ANY, ANY), max_size=3)
GOALS = st.builds(
    TrajectoryGoal,
    joint_names=st.permutations(NAMES) | st.lists(NAME, max_size=8),
    points=st.lists(POINTS, max_size=4),
    stamp=ANY | st.floats(NOW - 2, NOW + 1),
    path_tolerance=TOLERANCE,
    goal_tolerance=TOLERANCE,
    goal_time_tolerance=ANY,
)


@st.composite
def near_goals(draw: st.DrawFn) -> TrajectoryGoal:
    """Goals that are nearly right: each number may be off, and each part may be another's."""
    right = goal(count=draw(st.integers(2, 5)))
    points = []
    for point in right.points:
        numbers = {
            name: draw(st.sampled_from([(), (0.0,) * 6]) | st.lists(ANY, min_size=6, max_size=6))
            for name in ("velocities", "accelerations")
        }
        if draw(st.booleans()):
            numbers["positions"] = draw(st.lists(st.floats(-7, 7), min_size=6, max_size=6))
        points.append(point._replace(time=point.time * draw(st.floats(0.5, 3)), **numbers))
    return replace(right, points=points)


class FakeMotion:
    """Takes what is to be followed, and is there at once."""

    def __init__(self) -> None:
        self.followed: list[Any] = []

    async def follow_joint_trajectory(self, trajectory: Any, **given: Any) -> None:
        self.followed.append((trajectory, given))
        await anyio.lowlevel.checkpoint()


class FakeRobot:
    """As much of a robot as goals need, where all of START is."""

    def __init__(self) -> None:
        self.motion = FakeMotion()
        ready = RobotStates(
            0, 0.0, RobotState.ENABLE, ProgramState.STOPPED, SafetyState.RUN, OperationMode.REMOTE
        )

        async def answer(value: Any) -> Any:
            return value

        self.state = SimpleNamespace(
            get_robot_state=lambda: answer(ready),
            get_actual_joints_position=lambda: answer(list(START)),
        )
        self.permit = contextlib.nullcontext


class HeldMotion:
    """A motion that goes on until it is ended, and comes to rest when it may."""

    def __init__(self) -> None:
        self.begun = 0
        self.rest = anyio.Event()
        self.trajectory: Any = None

    async def follow_joint_trajectory(self, trajectory: Any, *, feedback: Any, **_: Any) -> None:
        self.begun += 1
        self.trajectory = trajectory
        here = np.array(START)
        feedback(GoalProgress(0.0, here, here))
        try:
            await anyio.sleep_forever()
        finally:
            with anyio.CancelScope(shield=True):
                await self.rest.wait()


@asynccontextmanager
async def held(
    wall: Callable[[], float] = lambda: NOW,
) -> AsyncIterator[tuple[TrajectoryServer, HeldMotion]]:
    """A server whose arm is held on its way."""
    robot: Any = FakeRobot()
    robot.motion = HeldMotion()
    server = TrajectoryServer(robot, PROFILE, RULES, wall=wall)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(server.run)
        yield server, robot.motion
        robot.motion.rest.set()
        tasks.cancel_scope.cancel()


async def test_each_pause_is_answered_when_the_arm_stands() -> None:
    """Also two at once, and one after a resume that came before the arm stood."""
    answers: list[bool] = []
    async with held() as (server, motion), anyio.create_task_group() as tasks:

        async def pause() -> None:
            answers.append(await server.pause())

        server.submit(client := Client(goal()))
        await eventually_async(lambda: motion.begun == 1)
        tasks.start_soon(pause)
        tasks.start_soon(pause)
        await anyio.wait_all_tasks_blocked()
        assert answers == []  # it does not stand yet
        assert server.resume()
        tasks.start_soon(pause)
        await anyio.wait_all_tasks_blocked()
        assert answers == []
        motion.rest.set()
        await eventually_async(lambda: len(answers) == 3)
        assert answers == [True] * 3
        assert server.resume()
        await eventually_async(lambda: motion.begun == 2)
        assert client.told == ["accepted"]


@pytest.mark.parametrize(
    ("speeds", "said"),
    [
        (ConnectionLost("the cable is out"), "not read: the cable is out; the arm was brought"),
        (np.full(6, math.nan), f"the speed of {NAMES[1]} is not told by the controller"),
    ],
    ids=["not read", "not told"],
)
async def test_a_goal_whose_speeds_are_not_known_ends_and_says_so(speeds: Any, said: str) -> None:
    async def read() -> Any:
        if isinstance(speeds, Exception):
            raise speeds
        return speeds

    async with held() as (server, motion):
        motion.rest.set()
        state: Any = server._robot.state
        state.get_actual_joints_speed = read
        tolerance = [NamedTolerance(NAMES[1], velocity=0.5)]
        server.submit(client := Client(goal(path_tolerance=tolerance)))
        await eventually_async(lambda: client.done)
    assert (client.told[-1], client.code) == ("aborted", ErrorCode.PATH_TOLERANCE_VIOLATED)
    assert said in client.text


@pytest.mark.parametrize("step", [-3600.0, 3600.0])
async def test_a_clock_that_is_set_changes_no_goal_that_waits_for_its_begin(step: float) -> None:
    now = [NOW]
    async with held(lambda: now[0]) as (server, motion):
        server.submit(client := Client(goal(stamp=NOW + 0.05)))
        now[0] += step
        await eventually_async(lambda: motion.begun == 1)
        motion.rest.set()
        assert server._due > anyio.current_time()
        assert client.told == ["accepted"]


async def test_nothing_of_a_path_is_left_out_for_the_time_before_its_begin(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with held() as (server, motion):
        motion.rest.set()
        server.submit(Client(goal()))
        await eventually_async(lambda: motion.begun == 1)
        there = (*way(1.0, 0.1)[:5], 0.12)  # where the arm stands, and the path leads through late
        state: Any = server._robot.state
        state.get_actual_joints_position = AsyncMock(return_value=there)
        places = (START, (0.5, *START[1:]), START, there, way(1.0))
        points = [GoalPoint(place, time=10.0 * n) for n, place in enumerate(places)]
        long_ago = anyio.current_time() - 35.0
        with monkeypatch.context() as then:
            then.setattr(anyio, "current_time", lambda: long_ago)
            server.submit(Client(goal(points=points, stamp=NOW + 35.0)))
        await eventually_async(lambda: motion.begun == 2)
        assert motion.trajectory.duration > 35.0


async def test_a_goal_that_waits_for_its_begin_ends_with_its_client() -> None:
    """A client that has gone by its begin was never seen, in ROS 2: the arm moved for nobody."""
    async with held() as (server, motion):
        server.submit(client := Client(goal(stamp=NOW + 30.0)))
        await anyio.wait_all_tasks_blocked()
        client.here = False
        await eventually_async(lambda: client.done, 10.0)
        assert (client.told, motion.begun) == (["cancelled"], 0)


async def test_a_goal_that_has_just_come_is_paused() -> None:
    async with held() as (server, motion):
        motion.rest.set()
        server.submit(client := Client(goal()))
        assert await server.pause()
        await anyio.wait_all_tasks_blocked()
        assert client.told == ["accepted"]


async def test_a_resume_before_the_arm_stands_answers_the_pause() -> None:
    answers: list[bool] = []
    async with held() as (server, motion), anyio.create_task_group() as tasks:

        async def pause() -> None:
            answers.append(await server.pause())

        server.submit(Client(goal()))
        await eventually_async(lambda: motion.begun == 1)
        tasks.start_soon(pause)
        await anyio.wait_all_tasks_blocked()
        server.resume()
        motion.rest.set()
        await eventually_async(lambda: motion.begun == 2)
        assert answers == [False]


async def test_a_goal_that_comes_after_the_server_has_ended_is_refused() -> None:
    """While the rest of the driver ends: it would wait until the driver is activated again."""
    async with held() as (server, _):
        await anyio.wait_all_tasks_blocked()
    server.submit(client := Client(goal()))
    assert (client.told, server.busy) == (["rejected"], False)


async def test_a_goal_that_begins_elsewhere_disturbs_no_running_one() -> None:
    async with held() as (server, motion):
        server.submit(running := Client(goal()))
        await eventually_async(lambda: motion.begun == 1)
        away = [p._replace(positions=tuple(q + 0.5 for q in p.positions)) for p in goal().points]
        server.submit(elsewhere := Client(goal(points=away)))
        assert (elsewhere.told, elsewhere.code) == (["rejected"], ErrorCode.INVALID_GOAL)
        assert "elsewhere" in elsewhere.text
        assert running.told == ["accepted"]
        # one that begins where the arm soon is may take its place
        server.submit(near := Client(goal(points=[GoalPoint(way(0.1)), GoalPoint(START, time=2)])))
        assert near.told == []


async def test_a_goal_begins_where_the_arm_stands_also_right_after_another_one_has_ended() -> None:
    """Not where it was on its way, which only a goal does that supersedes a running one."""
    async with held() as (server, motion):
        motion.rest.set()
        server.submit(first := Client(goal()))
        await eventually_async(lambda: motion.begun == 1)
        server.cancel(first)
        await eventually_async(lambda: first.done and not server.busy)
        state: Any = server._robot.state
        state.get_actual_joints_position = AsyncMock(return_value=way(1.0, 0.1))
        server.submit(second := Client(goal()))
        await eventually_async(lambda: second.told)
        assert (second.told, motion.begun) == (["rejected"], 1)


@for_each(
    "name, value",
    product(["path", "goal", "goal_time", "start", "max_stamp_age"], [math.nan, -0.1, math.inf]),
)
def test_rules_are_numbers(name: str, value: float) -> None:
    given_: Any = {name: value}
    with pytest.raises(ParameterError, match=name):
        GoalRules(**given_)


@given(st.one_of(GOALS, near_goals()))
def test_no_goal_kills_the_server_and_what_is_followed_keeps_the_limits(
    given_goal: TrajectoryGoal,
) -> None:
    robot: Any = FakeRobot()
    last, any_one = Client(goal()), Client(replace(given_goal, stamp=0.0))

    async def serve() -> None:
        server = TrajectoryServer(robot, PROFILE, RULES, wall=lambda: NOW)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(server.run)
            server.submit(Client(given_goal))  # with any stamp: it may have to wait
            server.cancel_all("over")
            for client in (any_one, last):
                server.submit(client)
                while not client.done:
                    await anyio.lowlevel.checkpoint()
            tasks.cancel_scope.cancel()

    anyio.run(serve)
    assert last.told == ["accepted", "succeeded"]
    assert any_one.told in (["rejected"], ["accepted", "succeeded"])
    assert len(robot.motion.followed) == 1 + (any_one.told != ["rejected"])
    for trajectory, given_ in robot.motion.followed:
        curve = trajectory.curve(START)
        at = np.linspace(0.0, trajectory.duration, 500)
        assert np.abs(curve.velocity(at)).max() <= given_["v"] * 1.05
        assert np.abs(curve.at(at)).max() <= 2 * math.pi + 0.1


# -- any order of what clients ask -------------------------------------------------------------


class BriefMotion:
    """A motion of some steps of the event loop, which takes some more to come to rest."""

    def __init__(self, steps: int) -> None:
        self._steps = steps

    async def follow_joint_trajectory(self, trajectory: Any, *, feedback: Any, **_: Any) -> None:
        here = np.array(START)
        feedback(GoalProgress(0.0, here, here))
        try:
            await steps(self._steps)
        finally:
            with anyio.CancelScope(shield=True):
                await steps(8)


async def steps(number: int) -> None:
    for _ in range(number):
        await anyio.lowlevel.checkpoint()


FROM_START = goal(points=[GoalPoint(START), GoalPoint(way(0.1), time=1.0)])
KINDS = [goal(), FROM_START, goal(points=[GoalPoint(way(1.0), time=1.0)]), goal(points=())]
KINDS += [goal(points=[GoalPoint(way(1.0, 1.5)), GoalPoint(START, time=3.0)])]
ASKED = st.one_of(
    st.tuples(st.just("submit"), st.integers(0, len(KINDS) - 1)),
    st.tuples(st.sampled_from(["cancel", "leave"]), st.integers(0, 3)),
    st.tuples(st.sampled_from(["pause", "resume", "stop", "all"]), st.just(0)),
    st.tuples(st.just("scale"), st.integers(1, 10)),
    st.tuples(st.just("wait"), st.integers(0, 30)),
)


@example(
    asked=[("submit", 0), ("wait", 30), ("pause", 0), ("resume", 0), ("pause", 0)],
    length=200,
    shut_down=False,
)
@given(asked=st.lists(ASKED, max_size=12), length=st.integers(0, 200), shut_down=st.booleans())
def test_in_any_order_each_goal_has_one_result_and_each_pause_an_answer(
    asked: list[tuple[str, int]], length: int, shut_down: bool
) -> None:
    robot: Any = FakeRobot()
    robot.motion = BriefMotion(length)
    clients: list[Client] = []
    answered: list[bool] = []

    async def serve() -> int:
        server = TrajectoryServer(robot, PROFILE, RULES, wall=lambda: NOW)
        pauses = 0

        async def pause() -> None:
            answered.append(await server.pause())

        async with anyio.create_task_group() as pausing, anyio.create_task_group() as tasks:
            tasks.start_soon(server.run)
            for what, number in asked:
                if what == "submit":
                    clients.append(Client(KINDS[number]))
                    server.submit(clients[-1])
                elif what in ("cancel", "leave") and number < len(clients):
                    if what == "cancel":
                        server.cancel(clients[number])
                    clients[number].here = what == "cancel"
                elif what == "pause":
                    pausing.start_soon(pause)
                    pauses += 1
                    await steps(1)  # it begins
                elif what == "resume":
                    server.resume()
                elif what == "stop":
                    server.stopped()
                elif what == "all":
                    server.cancel_all("over")
                elif what == "scale":
                    server.scale(number / 10)
                else:
                    await steps(number)
            while not shut_down and not all(client.done for client in clients):
                server.resume()
                await anyio.lowlevel.checkpoint()
            tasks.cancel_scope.cancel()
        return pauses

    async def watched() -> int:
        with anyio.fail_after(60.0):
            return await serve()

    assert anyio.run(watched) == len(answered)
    for client in clients:
        assert client.told[-1:] != ["accepted"]
        assert [word for word in client.told if word != "accepted"] == client.told[-1:]
        assert client.told.count("accepted") <= 1
