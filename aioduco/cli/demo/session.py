"""One demonstration from connecting to leaving; Ctrl-C ends it with a standing arm."""

from __future__ import annotations

import signal
from dataclasses import dataclass
from typing import TYPE_CHECKING

import anyio

import aioduco
from aioduco.cli.demo.script import pick_and_place
from aioduco.cli.demo.stage import Stage
from aioduco.cli.signals import heard
from aioduco.errors import ControllerError, DucoError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from anyio.abc import TaskStatus

    from aioduco.cli.demo.report import Report
    from aioduco.cli.demo.script import Choreography
    from aioduco.cli.demo.stage import Look
    from aioduco.cli.demo.view import View
    from aioduco.models.state import RobotStates, RobotStatus
    from aioduco.robot import Robot

__all__ = ["SAMPLES", "Found", "look", "perform"]

SAMPLES = 100.0  # of the arm, a second


@dataclass(frozen=True, slots=True)
class Found:
    """What is there before anything is sent that moves the arm.

    Attributes:
        states: the controller's four states.
        status: where the arm is.
        arm: series and model, as the controller tells them; empty if it does not.
    """

    states: RobotStates
    status: RobotStatus
    arm: str


async def look(host: str, port: int) -> Found:
    """Read the states of a controller and its arm, and leave. Nothing else is sent.

    Raises:
        ConnectError: there is no controller.
    """
    async with aioduco.connect(host, port, heartbeat=None) as robot:
        try:
            told = await robot.version.get_robot_type()
            arm = f"{told.series} {told.model}".strip()
        except ControllerError:  # older software lacks the function
            arm = ""
        return Found(await robot.state.get_robot_state(), await robot.state.getRobotStatus(), arm)


async def perform(
    robot: Robot, plan: Choreography, report: Report, view: View, look: Look | None = None
) -> signal.Signals | None:
    """Connect, bring the arm up, and go through the choreography.

    Args:
        robot: the robot, not connected yet: what it needs is loaded before the event loop runs.
        plan: where to and how fast.
        report: where the result is written, an error included.
        view: shows the progress while it runs.
        look: gives the place of the simulated box [m]; None if there is none.

    Returns:
        The signal that ended it, with the arm stopped; None if none did.
    """
    work = anyio.CancelScope()
    told: list[signal.Signals] = []
    async with anyio.create_task_group() as listening:
        # It outlives the work, so that a second Ctrl-C does not cut the stop short.
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
        stage.settle()


async def _end_on_signal(
    work: anyio.CancelScope,
    told: list[signal.Signals],
    view: View,
    *,
    task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED,
) -> None:
    with heard(signal.SIGINT, signal.SIGTERM) as signals:
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
