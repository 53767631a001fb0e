"""Plans carried out on a simulated arm, with supervision and while a scene changes."""

from __future__ import annotations

import dataclasses
import json
import math
from collections import Counter
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import anyio
import numpy as np
import pytest
from cli_runner import CliRunner
from for_each import for_each
from interpreter import python
from moments import complaints, streamed_in_time
from patient import COMMAND_LINE, patient_queue
from PIL import Image

import aioduco
from aioduco import FirstPointTooFar, Joints, ParameterError, PlanObstructed, StreamStopped
from aioduco.cli.app import app
from aioduco.errors import NoPathFound
from aioduco.models.ranges import JOINT_SPEED
from aioduco.planning import Plan, Planner, Scene
from aioduco.planning.execution import execute
from aioduco.planning.motion_limits import MotionLimits
from aioduco.planning.plan import PlanCheck
from aioduco.robot import Robot
from aioduco.sim import Simulator
from aioduco.sim.scene import Box, Sphere
from aioduco.streaming.joint_trajectory import (
    Feedback,
    JointTrajectory,
    Tolerances,
    TrajectoryResult,
)
from aioduco.streaming.shared.options import WorkerOptions

LEFT = Joints.deg(50, 0, 90, 0, -90, 0)
RIGHT = Joints.deg(-50, 0, 90, 0, -90, 0)
BOARD = Box(at=(0.55, 0, 0.35), size=(0.5, 0.04, 0.7), name="board")


@pytest.fixture(scope="module", autouse=True)
def _patient() -> Iterator[None]:
    with patient_queue():
        yield


@asynccontextmanager
async def cell() -> AsyncIterator[tuple[Robot, Scene, Planner]]:
    scene = Scene("gcr5_910", [BOARD])
    # in a process of its own: looks at the scene are not to hold it up
    with Simulator.spawn(scene=[BOARD], joints=list(LEFT)) as sim:
        async with aioduco.connect(sim.host, sim.port) as robot, Planner(scene) as planner:
            await robot.bring_up()
            yield robot, scene, planner


async def joints(robot: Robot) -> Joints:
    return await robot.state.get_actual_joints_position()


@pytest.mark.slow
async def test_a_plan_is_followed_to_its_end_and_back_as_blended_motions(
    totals: Counter[str],
) -> None:
    async with cell() as (robot, _, planner):
        plan = await planner.plan(LEFT, RIGHT, v=2.0, a=6.0)

        async def again() -> None:
            await robot.recover()
            await robot.motion.movej2(LEFT, v=1.0, a=2.0)

        result = await streamed_in_time(lambda: robot.motion.execute(plan), again, totals)
        assert result is not None
        assert np.abs(result.path_error).max() < 0.02
        assert await joints(robot) == pytest.approx(RIGHT, abs=1e-3)
        with pytest.raises(FirstPointTooFar, match="nothing was sent"):
            await robot.motion.execute(plan)
        back = await planner.plan(RIGHT, LEFT, v=2.0, a=6.0)
        with pytest.raises(ParameterError, match="through"):
            await robot.motion.execute(back, through="blended", feedback=print)
        assert await robot.motion.execute(back, through="blended") is None
        assert await joints(robot) == pytest.approx(LEFT, abs=1e-3)
        # No collision was detected, which ends in an error.
        assert not await robot.state.get_last_error()


class FakeMotion:
    """Stands for `robot.motion`: it tells of progress until it is cancelled."""

    def __init__(self) -> None:
        self.followed = 0

    async def follow_joint_trajectory(
        self, trajectory: JointTrajectory, *, feedback: Any = None, **_: Any
    ) -> TrajectoryResult:
        self.followed += 1
        here = trajectory.positions[0]
        with anyio.fail_after(30):
            while True:
                feedback(Feedback(0.0, here, here, 0.0 * here))
                await anyio.lowlevel.checkpoint()

    def movej2(self, joints: Any, v: float, a: float, *, r: float = 0.0) -> Any:
        raise AssertionError("a plan is followed as a stream")

    async def run(self, *motions: Any) -> Any:
        raise AssertionError("a plan is followed as a stream")


async def at_start() -> Joints:
    return LEFT


def straight(scene: Scene, v: float = 1.0) -> Plan:
    """A plan from left to right, as if nothing stood there."""
    positions = np.linspace(LEFT, RIGHT, 20)
    times = np.linspace(0.0, 2.0, 20)
    return Plan(
        scene.arm,
        JointTrajectory(positions, times),
        MotionLimits.of(scene.arm, v, 2.0, None),
        tip=np.eye(4),
        corners=positions[[0, -1]],
        looked=times[[0, -1]],
        clearances=np.full(2, 0.1),
        radii=np.ones(6),
    )


async def test_a_change_during_the_check_is_checked_too(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, motion = Scene("gcr5_910"), FakeMotion()
    check = Plan.check

    def changed_meanwhile(plan: Plan, scene: Scene, *, after: float = 0.0) -> PlanCheck:
        found = check(plan, scene, after=after)
        if "board" not in scene:
            scene.add(BOARD)
        return found

    monkeypatch.setattr(Plan, "check", changed_meanwhile)

    with pytest.raises(PlanObstructed, match="brought to rest") as caught:
        await execute(motion, at_start, straight(scene), watch=scene)
    assert motion.followed == 1
    assert caught.value.pair is not None
    assert caught.value.pair[1] == "board"


@pytest.mark.slow
async def test_a_plan_for_another_arm_is_refused() -> None:
    """It is free for the links of that arm alone."""
    with Simulator("gcr10_1300", joints=list(LEFT)) as sim:
        async with (
            aioduco.connect(sim.host, sim.port) as robot,
            Planner(Scene("gcr5_910")) as other,
        ):
            await robot.bring_up()
            plan = await other.plan(LEFT, RIGHT, v=1.0, a=3.0)
            with pytest.raises(ParameterError, match="for the arm that is there"):
                await robot.motion.execute(plan)
            assert (await joints(robot)).almost_equal(LEFT)


async def test_an_upright_tool_stays_upright_on_the_way_round(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An open cup was tilted by the plan round what had come into its way."""
    asked: list[dict[str, Any]] = []

    async def plan(*_: object, **options: Any) -> Plan:
        asked.append(options)
        raise NoPathFound("it is a test")

    scene = Scene("gcr5_910")

    def appear(_: object) -> None:
        if "board" not in scene:
            scene.add(BOARD)

    with Planner(scene) as planner:
        monkeypatch.setattr(planner, "plan", plan)
        for upright in (True, False):
            with pytest.raises(NoPathFound):
                await execute(
                    FakeMotion(),
                    at_start,
                    dataclasses.replace(straight(scene), upright=upright),
                    watch=scene,
                    planner=planner,
                    feedback=appear,
                )
            scene.remove("board")
    assert [options["upright"] for options in asked] == [True, False]
    # the plan has 100° in 2 s, and limits of 1 rad/s
    assert asked[0]["v"] == pytest.approx([math.radians(50.0)] * 6)


async def test_a_scene_is_watched_while_the_program_has_all_threads_of_anyio() -> None:
    scene, plan = Scene("gcr5_910"), straight(Scene("gcr5_910"))
    threads = anyio.to_thread.current_default_thread_limiter()
    taken = [object() for _ in range(int(threads.total_tokens))]
    for each in taken:
        threads.acquire_on_behalf_of_nowait(each)

    def appear(_: object) -> None:
        if "board" not in scene:
            scene.add(BOARD)

    try:
        with pytest.raises(PlanObstructed, match="brought to rest"):
            await execute(FakeMotion(), at_start, plan, watch=scene, feedback=appear)
    finally:
        for each in taken:
            threads.release_on_behalf_of(each)


async def test_the_fastest_plan_is_one_that_a_stream_takes() -> None:
    asked: list[float] = []

    class FastMotion(FakeMotion):
        async def follow_joint_trajectory(
            self, trajectory: JointTrajectory, *, feedback: Any = None, v: float = 0.0, **_: Any
        ) -> TrajectoryResult:
            asked.append(JOINT_SPEED("v", v))
            raise StreamStopped("nothing is to move here", None)

    with pytest.raises(StreamStopped):
        await execute(FastMotion(), at_start, straight(Scene("gcr5_910"), JOINT_SPEED.high))
    assert asked == [JOINT_SPEED.high]


@for_each(
    "given",
    [
        {"watch": Scene("gcr5_910")},
        {"tolerances": Tolerances()},
        {"feedback": print},
        {"options": WorkerOptions()},
    ],
)
async def test_blended_motions_take_no_options_of_a_stream(given: dict[str, Any]) -> None:
    plan = straight(Scene("gcr5_910"))
    with pytest.raises(ParameterError, match="through"):
        await execute(FakeMotion(), at_start, plan, through="blended", **given)


@pytest.mark.slow
async def test_what_comes_into_the_way_stops_the_arm_or_is_gone_round() -> None:
    async with cell() as (robot, scene, planner):
        # slow, so that a busy machine has seconds to notice what comes into the way
        across = await planner.plan(LEFT, RIGHT, v=0.3, a=3.0)
        ahead = across.pose(0.7 * across.duration)

        def appear(_: object) -> None:
            if "ball" not in scene:
                scene.add(Sphere(at=ahead[:3], radius=0.03, name="ball"))

        with pytest.raises(PlanObstructed, match="brought to rest") as caught:
            await robot.motion.execute(across, watch=scene, feedback=appear)
        assert caught.value.pair is not None
        assert caught.value.pair[1] == "ball"
        assert not await robot.state.robotmoving()
        assert not scene.collides(await joints(robot))
        scene.remove("ball")
        plan = await planner.plan(await joints(robot), LEFT, v=0.6, a=3.0)
        scene.add(Sphere(at=plan.pose(0.5 * plan.duration)[:3], radius=0.03, name="ball"))
        with pytest.raises(PlanObstructed, match="nothing was sent"):
            await robot.motion.execute(plan, watch=scene)
        scene.remove("ball")
        await robot.motion.execute(plan)
        await robot.motion.execute(across, watch=scene, planner=planner, feedback=appear)
        assert "ball" in scene
        assert await joints(robot) == pytest.approx(RIGHT, abs=1e-3)


@pytest.mark.slow
def test_the_demonstration(tmp_path: Path) -> None:
    told = tmp_path / "told.json"
    command = [*COMMAND_LINE[1:], "demo", "--plan", "--json", str(told)]
    done = python(*command, "--pictures", str(tmp_path), timeout=110)
    assert done.returncode == 0, done.stdout + done.stderr
    steps = json.loads(told.read_text(encoding="utf-8"))["steps"]
    names = ["home", "a joint goal", "a pose goal", "a straight line", "round the board"]
    assert [step["name"] for step in steps] == names
    assert all(step["clearance"] > 0.0 for step in steps)
    assert all(step["error"] < 0.05 for step in steps)
    assert "a goal inside the board is refused" in done.stdout
    before, after = (
        np.asarray(Image.open(tmp_path / f"demo-{name}.png")) for name in ("before", "after")
    )
    assert before.shape == (480, 640, 3)
    assert (before != after).mean() > 0.01


@pytest.mark.slow
@pytest.mark.skipif(find_spec("ompl") is None, reason="OMPL has no build for this Python")
def test_the_example() -> None:
    root = Path(__file__).parents[2]
    example = root / "examples" / "16_plan_round_obstacle.py"
    command = ["-W", "error", str(root / "tests" / "patient.py"), str(example)]
    with Simulator.spawn(scene=[BOARD], joints=list(LEFT)) as sim:
        done = python(*command, sim.host, "--port", str(sim.port))
    assert (complaints(done.stderr), done.returncode) == ("", 0)
    assert "on the right side\non the left side again, round a ball" in done.stdout


@pytest.mark.slow
@pytest.mark.skipif(find_spec("ompl") is None, reason="OMPL has no build for this Python")
def test_a_demonstration_whose_pictures_cannot_be_written_says_so_first(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.touch()
    done = python(*COMMAND_LINE[1:], "demo", "--plan", "--pictures", str(file / "x"), timeout=110)
    assert done.returncode == 2, done.stdout + done.stderr
    assert f"{file / 'x'} cannot be written: " in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == "", "nothing was planned, and no arm moved"


@pytest.mark.slow
def test_the_demonstration_is_for_a_simulated_arm() -> None:
    done = CliRunner().invoke(app, ["demo", "--plan", "--host", "127.0.0.1"])
    assert done.exit_code == 2
    assert "--plan" in done.stderr
