"""The driver's node on a simulated arm, without ROS."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator, Coroutine
from typing import Any

import anyio

from aioduco import Snapshot, WorkerOptions
from aioduco.integrations.ros.arm_node import ArmNode, NodeSettings, arm_node
from aioduco.integrations.ros.arm_readings import ArmReading, Diagnosis, PlacedFrame
from aioduco.integrations.ros.trajectory_goals import GoalRules
from aioduco.integrations.ros.trajectory_server import GoalProgress
from aioduco.sim import Simulator

from .goals import START


class Sink:
    """Remembers the newest of each kind."""

    def __init__(self) -> None:
        self.count = 0
        self.listens = True
        self.frames: dict[str, PlacedFrame] = {}
        self.reading: ArmReading | None = None
        self.snapshot: Snapshot | None = None
        self.diagnoses: list[Diagnosis] = []
        self.percent = self.factor = 0.0
        self.tool_fields: dict[str, Any] = {}
        self.place: GoalProgress | None = None
        self.forces: list[list[float]] = []

    def wants_frames(self) -> bool:
        return self.listens

    def joints(self, at: float, reading: ArmReading, frames: list[PlacedFrame]) -> None:
        self.count += 1
        self.reading, self.frames = reading, {frame.name: frame for frame in frames}

    def wrench(self, at: float, force: list[float]) -> None:
        self.forces.append(force)

    def states(self, snapshot: Snapshot) -> None:
        self.snapshot = snapshot

    def speed(self, percent: float) -> None:
        self.percent = percent

    def tool(self, fields: dict[str, Any]) -> None:
        self.tool_fields = fields

    def progress(self, place: GoalProgress, factor: float) -> None:
        self.place, self.factor = place, factor

    def diagnosis(self, found: Diagnosis) -> None:
        self.diagnoses.append(found)


@contextlib.asynccontextmanager
async def beside(work: Coroutine[Any, Any, None]) -> AsyncIterator[None]:
    """Work that goes on until the block ends.

    No task group: a fixture may be left in another task than it was entered in.
    """
    task = asyncio.create_task(work)
    try:
        yield
    finally:
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task


@contextlib.asynccontextmanager
async def running(sim: Simulator, sink: Sink | None = None, **given: Any) -> AsyncIterator[ArmNode]:
    """A node that serves, forgives a busy machine, and whose arm stands at START."""
    async with connected(sim, **given) as node, beside(node.run(sink or Sink())):
        yield node


@contextlib.asynccontextmanager
async def connected(sim: Simulator, **given: Any) -> AsyncIterator[ArmNode]:
    """The same before it serves."""
    settings = NodeSettings(
        host=sim.host,
        port=sim.port,
        heartbeat=20.0,
        through="servoj",  # the controller's queue holds a tenth of a second
        rate=20.0,
        rules=GoalRules(goal_time=60.0),
        **given,
    )
    options = WorkerOptions(timeout=20.0, connect_timeout=30.0)
    async with arm_node(settings, options=options) as node:
        for reply in (await node.services.recover(), await node.services.movej(START, 3.0, 20.0)):
            assert reply.success, reply.message
        yield node


async def ticks(rate: float) -> AsyncIterator[None]:
    start = anyio.current_time()
    for number in itertools.count():
        await anyio.sleep_until(start + number / rate)
        yield
