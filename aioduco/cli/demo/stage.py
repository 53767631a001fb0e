"""Run the choreography: follow each motion, sample the arm, and keep the report."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import anyio
import anyio.to_thread
import numpy as np

from aioduco.cli.demo.report import MotionRecord, Report
from aioduco.errors import RobotStateError, TaskError
from aioduco.models.enums import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.cli.demo.view import View
    from aioduco.models.state import RobotStatus
    from aioduco.robot import Robot
    from aioduco.supervision.command import MotionCommand
    from aioduco.supervision.state_feed import Snapshot
    from aioduco.supervision.task import Task

    Look = Callable[[], tuple[float, float, float]]


PATIENCE = 30.0  # seconds within which the arm must begin to move


class Running(NamedTuple):
    """A motion that the controller has accepted: its task, and its record in the report."""

    task: Task
    record: MotionRecord


class Stage:
    """Runs motions on a robot, and records the observations.

    Args:
        robot: the robot, connected.
        report: where the result is written.
        view: shows the progress while it runs.
        look: returns the place of the simulated box [m]; None without a box. It may block.
    """

    def __init__(self, robot: Robot, report: Report, view: View, look: Look | None = None) -> None:
        self._look = look
        self._robot = robot
        self._report = report
        self._view = view
        self._live: list[Running] = []

    async def watch(self) -> None:
        """Take the samples of the arm until cancelled."""
        with self._robot.feed.subscribe() as samples:
            async for sample in samples:
                self._take(sample.status)

    @property
    def simulated(self) -> bool:
        """Whether there is a simulated box, and a gripper with sensors for it."""
        return self._look is not None

    async def see(self, where: str) -> None:
        """Record where the box is.

        Args:
            where: description of the place, such as "it is carried".
        """
        if self._look is not None:
            place = await anyio.to_thread.run_sync(self._look)
            self._report.part.append(place)
            told = ", ".join(f"{1e3 * value:.0f}" for value in place)
            self.note(f"the box: {where} at {told} mm")

    def note(self, text: str) -> None:
        """Report an event that is no motion."""
        self._view.note(text)

    async def move(
        self, name: str, motion: MotionCommand, *, expect: Outcome = Outcome.FINISHED
    ) -> None:
        """Make a motion and follow it to its end.

        Args:
            name: purpose of the motion.
            motion: the motion, not sent yet.
            expect: expected outcome.
        """
        await self.finish(await self.start(name, motion, expect=expect))

    async def start(
        self, name: str, motion: MotionCommand, *, expect: Outcome = Outcome.FINISHED
    ) -> Running:
        """Send a motion, and return as soon as the controller accepted it."""
        record = MotionRecord(name, motion.command.name, expect)
        self._report.motions.append(record)
        task = await motion.start()
        record.task_id = task.id
        record.begin = task.accepted_at - self._report.origin
        self._view.began(record)
        running = Running(task, record)
        self._live.append(running)
        return running

    async def finish(self, running: Running) -> None:
        """Follow a motion to its end, and record its outcome.

        Raises:
            TaskError: it did not end as expected.
        """
        error: TaskError | None = None
        try:
            await running.task
        except TaskError as raised:
            error = raised
        self._record(running, error)
        if error is not None and not running.record.ok:
            raise error

    def record_rest(self) -> None:
        """Record the outcomes of motions that are no longer followed."""
        for running in tuple(self._live):
            self._record(running, None)

    def _record(self, running: Running, error: TaskError | None) -> None:
        self._live.remove(running)
        task, record = running.task, running.record
        record.outcome = task.outcome
        record.end = (task.ended_at or time.monotonic()) - self._report.origin
        record.tracking_error = self._report.error_between(record.begin, record.end)
        if not record.ok:
            record.message = str(error or "")
        self._view.ended(record)

    async def moved(self, angle: float) -> None:
        """Wait until a joint has moved by an angle [rad] from where it is now."""
        begin = (await self._robot.feed.latest()).status.joints.array

        def has_moved(sample: Snapshot) -> bool:
            return bool(np.abs(sample.status.joints.array - begin).max() > angle)

        try:
            await self._robot.wait_for(has_moved, timeout=PATIENCE)
        except TimeoutError as error:
            raise RobotStateError(f"no joint moved by {angle:g} rad in {PATIENCE:g} s") from error

    def _take(self, status: RobotStatus) -> None:
        self._report.samples.append(status)
        for running in self._live:
            running.record.state = running.task.state.name.lower()
        self._view.sample(status)
