"""One demonstration from connect to disconnect; Ctrl-C stops the arm and ends it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import anyio

from aioduco.cli.demo.script import Choreography, pick_and_place
from aioduco.cli.demo.stage import Stage
from aioduco.cli.signals import receive_signals
from aioduco.errors import DucoError

if TYPE_CHECKING:
    import signal
    from collections.abc import Iterator

    from anyio.abc import TaskStatus

    from aioduco.cli.demo.report import Report
    from aioduco.cli.demo.stage import Look
    from aioduco.cli.demo.view import View
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
