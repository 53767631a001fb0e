"""Run `aioduco demo`: the question before a real arm moves, the motions, and the output.

However it ends, the arm stands.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import anyio
import numpy as np
import typer

import aioduco
from aioduco.cli import extras
from aioduco.cli.command_terms import in_commands
from aioduco.cli.demo import view
from aioduco.cli.demo.report import Report
from aioduco.cli.demo.script import GRIPPER_NAME, Choreography, pick_and_place, scene
from aioduco.cli.demo.stage import Stage
from aioduco.cli.exit_codes import write_file
from aioduco.cli.output import say
from aioduco.cli.questions import SAFE, ask
from aioduco.cli.safe_console import SafeConsole
from aioduco.cli.signals import receive_signals
from aioduco.cli.status import look, states_line
from aioduco.errors import DucoError
from aioduco.kinematics import Arm, forward
from aioduco.models.host_port import host_port

if TYPE_CHECKING:
    import signal
    from collections.abc import Iterator

    from anyio.abc import TaskStatus
    from numpy.typing import NDArray

    from aioduco.cli.addresses import RobotAddress
    from aioduco.cli.demo.stage import Look
    from aioduco.cli.demo.view import View
    from aioduco.models.controller_clock import Clock
    from aioduco.robot import Robot


SAMPLES = 100.0  # samples of the arm per second


async def perform(
    robot: Robot, plan: Choreography, report: Report, view: View, look: Look | None = None
) -> signal.Signals | None:
    """Connect, bring the arm up, and go through the choreography.

    Args:
        robot: the robot, not connected yet; its modules are loaded before the event loop runs.
        plan: places and speeds.
        report: where the result is written, an error included.
        view: shows the progress while it runs.
        look: returns the place of the simulated box [m]; None without a box.

    Returns:
        The signal that ended it, after the arm was stopped; None without a signal.
    """
    work = anyio.CancelScope()
    told: list[signal.Signals] = []
    async with anyio.create_task_group() as listening:
        # This task runs longer than the work, so that a second Ctrl-C does not interrupt the stop.
        await listening.start(_end_on_signal, work, told, view)
        with work:
            try:
                await _perform(robot, plan, report, view, look)
            except* DucoError as group:
                report.error = "; ".join(str(error) for error in _leaves(group))
        listening.cancel_scope.cancel()
    if work.cancelled_caught:
        report.error = "interrupted: the arm was stopped, and stands"
    return told[0] if told else None


async def _perform(
    robot: Robot, plan: Choreography, report: Report, view: View, look: Look | None
) -> None:
    stage = Stage(robot, report, view, look)
    try:
        async with robot:
            await robot.bring_up()
            async with anyio.create_task_group() as watching:
                watching.start_soon(stage.watch)
                await pick_and_place(robot, stage, plan)
                watching.cancel_scope.cancel()
    finally:
        stage.record_rest()


async def _end_on_signal(
    work: anyio.CancelScope,
    told: list[signal.Signals],
    view: View,
    *,
    task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED,
) -> None:
    with receive_signals() as signals:
        task_status.started()
        async for number in signals:
            told.append(number)
            view.note("stopping the arm; this needs a moment")
            work.cancel()


def _leaves(group: BaseExceptionGroup[BaseException]) -> Iterator[BaseException]:
    for error in group.exceptions:
        if isinstance(error, BaseExceptionGroup):
            yield from _leaves(error)
        else:
            yield error


OUTPUT = Path("-")
#: joints of the simulated arm at the start, as if someone had left it there [rad]
LEFT = (-0.7, -0.4, 1.2, 0.1, -1.1, 0.2)


def run(
    address: RobotAddress | None,
    model: str,
    speed: float,
    plot: Path | None,
    result: Path | None,
    *,
    yes: bool,
) -> NoReturn:
    """Make the pick and place, show it, write the result, and end the program.

    Args:
        address: address of a controller; None for a simulated arm.
        model: the arm to simulate, or that is there.
        speed: speed of a simulated arm, as a multiple of the wall clock.
        plot: where to write the plot; None for none.
        result: where to write the result; None for nowhere.
        yes: whether a real arm moves without a question.
    """
    extras.need(*(() if address else ("sim",)), *(() if plot is None else ("plot",)))
    arm = extras.arm(model)
    console = SafeConsole(stderr=result == OUTPUT)
    plan = Choreography.for_reach(arm.reach, careful=address is not None)
    if address is not None:
        if not yes:
            ask(_warning(address, model, plan, look(address)), "Move the arm?", yes=False)
        report = Report(model, str(address), simulated=False)
        ended_by = _performed(address.host, address.port, plan, report, console)
    else:
        from aioduco.sim import Simulator  # noqa: PLC0415 - MuJoCo is for this case alone

        cell = {"scene": scene(arm, plan), "gripper": GRIPPER_NAME}
        with Simulator.spawn(model=model, speed=speed, joints=LEFT, **cell) as sim:

            def see() -> tuple[float, float, float]:
                x, y, z = sim.positions[-7:-4].tolist()  # the box comes last, with its quaternion
                return x, y, z

            report = Report(model, host_port(sim.host, sim.port), simulated=True, speed=speed)
            ended_by = _performed(sim.host, sim.port, plan, report, console, sim.clock, see)

    console.print(view.summary(report))
    if report.error:
        console.print(f"error: {report.error}", style="bold red", markup=False, highlight=False)
    if plot is not None and report.samples:
        _plot(report, arm, plot)
        console.print(f"plot: {plot}", highlight=False)
    if result is not None:
        _put(report.as_json(), result)
    if ended_by is not None:
        raise typer.Exit(128 + ended_by)  # as in a shell: 130 for Ctrl-C
    raise typer.Exit(0 if report.ok else 1)


def run_planned(
    address: RobotAddress | None, model: str, result: Path | None, pictures: Path | None
) -> None:
    """Plan and carry out ways round an obstacle, on a simulated arm."""
    if address is not None:
        raise typer.BadParameter("is for a simulated arm: its obstacle stands nowhere else",
                                 param_hint="--plan")  # fmt: skip
    extras.need("sim", "plan", *(("plot",) if pictures is not None else ()))
    from aioduco.cli.demo import planned  # noqa: PLC0415 - MuJoCo is for this case alone
    from aioduco.sim import Simulator  # noqa: PLC0415

    arm = extras.arm(model)
    console = SafeConsole(stderr=result == OUTPUT)
    try:
        left, board = planned.LEFT_THERE, planned.obstacle(arm)
        with Simulator.spawn(model=model, joints=left, scene=[board]) as sim:
            steps = anyio.run(planned.perform_plans, sim, arm, console, pictures)
    except DucoError as error:
        console.print(
            f"error: {in_commands(error)}", style="bold red", markup=False, highlight=False
        )
        raise typer.Exit(1) from None
    if result is not None:
        _put({"model": model, "steps": [step._asdict() for step in steps]}, result)


def _performed(
    host: str,
    port: int,
    plan: Choreography,
    report: Report,
    console: SafeConsole,
    clock: Clock | None = None,
    look: Look | None = None,
) -> signal.Signals | None:
    shown = view.view_for(console)
    shown.open(report)
    try:
        robot = aioduco.connect(host, port, state_rate=SAMPLES, clock=clock)
        return anyio.run(perform, robot, plan, report, shown, look)
    finally:
        shown.close()


def _warning(address: RobotAddress, model: str, plan: Choreography, found: dict[str, Any]) -> str:
    """The warning before the arm moves."""
    now, start = np.array(found["joints"]), plan.start.array
    far = np.rad2deg(np.abs(start - now))
    joint = int(far.argmax())
    return f"""\
controller at {address}: {states_line(found)}
the arm:       {found["arm"] or "not told by the controller"}; this plan is for a {model}
joints now:    {_degrees(now)}
joints first:  {_degrees(start)}   (joint {joint + 1} turns by {far[joint]:.0f}°)
joints aside:  {_degrees(plan.aside.array)}
The arm will be powered on and enabled if it is not. It goes to the first joints, picks and places
{plan.width * 1e3:.0f} mm to each side of there and {plan.depth * 1e3:.0f} mm below, and turns \
aside and back. Joints turn at {np.rad2deg(plan.joint_speed):.0f} °/s, lines are made at \
{plan.line_speed * 1e3:.0f} mm/s. Digital output 1 switches.
{SAFE}"""


def _degrees(joints: NDArray[np.float64]) -> str:
    return "  ".join(f"{angle:7.1f}°" for angle in np.rad2deg(joints))


def _plot(report: Report, arm: Arm, path: Path) -> None:
    from aioduco.cli.demo import plot  # noqa: PLC0415 - matplotlib takes half a second to load

    def skeleton(joints: NDArray[np.float64]) -> NDArray[np.float64]:
        origins: NDArray[np.float64] = forward.frames(arm.geometry, joints)[:, :3, 3]
        return origins

    plot.save(report, path, skeleton)


def _put(result: dict[str, Any], path: Path) -> None:
    text = json.dumps(result, indent=2)
    if path == OUTPUT:
        say(text)
    else:
        write_file(path, text + "\n")
