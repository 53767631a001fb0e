"""`aioduco demo --plan`: goals, a line, and a way round an obstacle, on a simulated arm."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import anyio
import anyio.to_thread
import numpy as np

import aioduco
from aioduco.cli import extras
from aioduco.cli.demo_run import OUTPUT, write_result
from aioduco.cli.exit_codes import ended_by_errors, writing
from aioduco.cli.safe_console import SafeConsole
from aioduco.errors import GoalInCollision, PlanningError, RenderError
from aioduco.models.pose import Joints, Pose
from aioduco.models.whole_files import whole_file
from aioduco.planning import Plan, Planner, Scene
from aioduco.sim import Simulator
from aioduco.sim.scene import Box

if TYPE_CHECKING:
    from pathlib import Path

    from aioduco.kinematics import Arm
    from aioduco.robot import Robot
    from aioduco.sim.process import SimulatorProcess


ASIDE = Joints.deg(90, 0, 90, 0, -90, 0)
SIDE = math.radians(50.0)  # angle of joint 1 to either side of the obstacle
#: joints of the simulated arm at the start, as if someone had left it there [rad]
LEFT_THERE = (1.9, -0.4, 1.2, 0.1, -1.1, 0.2)
V, A = 1.5, 4.0  # speed and acceleration of the joints [rad/s, rad/s²]


class PlannedStep(NamedTuple):
    """A plan that was carried out.

    Attributes:
        name: purpose of the plan.
        duration: duration of the plan [s].
        clearance: least distance to any object on the way, at most 0.1 [m].
        planning: processor time that the planner took [s].
        error: largest measured deviation of a joint from the plan [rad].
    """

    name: str
    duration: float
    clearance: float
    planning: float
    error: float


def obstacle(arm: Arm) -> Box:
    """A board that blocks the direct way from one side to the other."""
    r = arm.reach
    return Box(
        at=(0.62 * r, 0.0, 0.36 * r),
        size=(0.5 * r, 0.04 * r, 0.72 * r),
        colour=(0.8, 0.35, 0.25),
        name="board",
    )


async def perform_plans(
    simulator: SimulatorProcess, arm: Arm, console: SafeConsole, pictures: Path | None
) -> list[PlannedStep]:
    """Bring the arm up, and carry out the plans one after another.

    Args:
        simulator: simulator whose arm is moved; the obstacle stands in its scene.
        arm: arm of the simulator.
        console: output.
        pictures: folder for pictures before and after; None for none.

    Raises:
        DucoError: a plan was not found, failed its check, or was not carried out.
    """
    scene = Scene(arm, [obstacle(arm)])
    steps: list[PlannedStep] = []
    async with aioduco.connect(simulator.host, simulator.port) as robot, Planner(scene) as planner:
        await robot.bring_up()

        async def carry_out(name: str, plan: Plan) -> None:
            found = await anyio.to_thread.run_sync(plan.check, scene)
            if not found:
                raise PlanningError(f"the plan {name!r} does not pass its check: {found}")
            result = await robot.motion.execute(plan, watch=scene)
            error = 0.0 if result is None else float(np.abs(result.path_error).max())
            planning = plan.searching + plan.timing
            steps.append(PlannedStep(name, plan.duration, plan.clearance, planning, error))
            console.print(
                f"{name}: {plan.duration:.2f} s, planned in {planning * 1e3:.0f} ms, "
                f"{plan.clearance * 1e3:.0f} mm clear, {len(plan.corners)} corners",
            )

        await carry_out("home", await planner.plan(await _here(robot), ASIDE, v=V, a=A))
        left = Joints(SIDE, *ASIDE[1:])
        await carry_out("a joint goal", await planner.plan(await _here(robot), left, v=V, a=A))
        pose = Pose.from_matrix(arm.fkine(left))
        lower = Pose(pose.x, pose.y, 0.3 * arm.reach, pose.rx, pose.ry, pose.rz)
        await carry_out("a pose goal", await planner.plan(await _here(robot), lower, v=V, a=A))
        higher = Pose(pose.x, pose.y, 0.45 * arm.reach, pose.rx, pose.ry, pose.rz)
        await carry_out("a straight line", await planner.line(await _here(robot), higher, v=V, a=A))
        try:
            inside = Pose.from_matrix(arm.fkine(ASIDE))
            board = Pose(0.62 * arm.reach, 0.0, 0.36 * arm.reach, inside.rx, inside.ry, inside.rz)
            await planner.plan(await _here(robot), board)
        except GoalInCollision as error:
            console.print(f"a goal inside the board is refused: {error}")
        here = await _here(robot)
        right = Joints(here.j1 - 2.0 * SIDE, *here[1:])
        around = await planner.plan(here, right, v=V, a=A)
        if pictures is not None:
            await anyio.to_thread.run_sync(save_pictures, around, scene, pictures, console)
        await carry_out("round the board", around)
    return steps


def save_pictures(plan: Plan, scene: Scene, folder: Path, console: SafeConsole) -> None:
    """Write pictures of the arm before and after a plan, and of the plan itself, as PNG files."""
    from PIL import Image  # noqa: PLC0415 - needs an extra

    try:
        before, after = scene.pictures([plan.start, plan.end])
        drawn = {"before": before, "plan": plan.picture(scene), "after": after}
    except RenderError as error:
        console.print(f"no pictures: {error}")
        return
    for name, picture in drawn.items():
        path = folder / f"demo-{name}.png"
        with writing(path), whole_file(path) as file:
            Image.fromarray(picture).save(file, "png", optimize=True)
        console.print(f"picture: {path}")


async def _here(robot: Robot) -> Joints:
    return Joints.of(await robot.state.get_actual_joints_position())


def run_planned(model: str, result: Path | None, pictures: Path | None) -> None:
    """Plan and carry out ways round an obstacle, on a simulated arm."""
    arm = extras.arm(model)
    console = SafeConsole(stderr=result == OUTPUT)
    if pictures is not None:
        with writing(pictures):
            pictures.mkdir(parents=True, exist_ok=True)
    with (
        ended_by_errors(),
        Simulator.spawn(model=model, joints=LEFT_THERE, scene=[obstacle(arm)]) as sim,
    ):
        steps = anyio.run(perform_plans, sim, arm, console, pictures)
    if result is not None:
        write_result({"model": model, "steps": [step._asdict() for step in steps]}, result)
