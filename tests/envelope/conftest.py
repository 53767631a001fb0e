"""An arm beside a wall, for the tests of robots within an envelope."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from patient import STREAM_PATIENCE

import aioduco
from aioduco import Joints, WorkerOptions
from aioduco.envelope import Action, Zone
from aioduco.sim import Simulator

from .trials import ARM, CYCLE, Seen, watched

START = Joints(0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0)
#: the tool at START
AT = (0.492, 0.1405, 0.442)
#: the wall of most tests; there is no tool, so its tip is the flange
FLAT = (Zone.plane((0, AT[1] + 0.1, 0), (0, -1, 0), bodies=("flange",)),)
#: given in full: for `pytest tests/envelope`, this is loaded before the defaults are patient
THREAD = WorkerOptions(
    run_in="thread",
    timeout=STREAM_PATIENCE["timeout"],
    away_limit=STREAM_PATIENCE["away_limit"],
)
#: simulated seconds in a real one
SPEED = 10.0


@pytest.fixture(scope="module")
def seen() -> Iterator[Seen]:
    with watched() as seen:
        yield seen


@pytest.fixture(scope="module")
def sim(seen: Seen) -> Iterator[Simulator]:
    with Simulator(speed=SPEED, joints=START, cycle=CYCLE) as sim:
        yield sim


@pytest.fixture
async def robot(sim: Simulator, seen: Seen) -> AsyncIterator[aioduco.Robot]:
    connected = aioduco.connect(
        sim.host, sim.port, clock=sim.clock, state_rate=150.0, lag_limit=None
    )
    async with connected as robot:
        await robot.bring_up()
        await stand(robot, *START)
        seen.clear()
        yield robot


async def stand(robot: aioduco.Robot, *q: float) -> None:
    """Stand at joints, whatever the envelope says."""
    kept, robot.envelope = robot.envelope, None
    await robot.stop()
    await robot.motion.movej2(q, v=3.9, a=40.0)
    robot.envelope = kept


@contextmanager
def standing_time(sim: Simulator) -> Iterator[None]:
    """A block in which no simulated time passes.

    So a motion comes before the one that it follows has ended, however busy the machine is.
    """
    sim.lock_time()
    try:
        yield
    finally:
        sim.unlock_time()


def wall(off: float = 0.1, action: Action = "refuse", speed: float = 0.1) -> Zone:
    """A wall beside the tool at START, so far to its left [m]."""
    return Zone.plane(
        (0, AT[1] + off, 0), (0, -1, 0), bodies=("tool",), action=action, speed=speed, name="wall"
    )


def turned(angle: float) -> tuple[float, ...]:
    """START, with the first joint turned: by 0.2 rad the tool is at the wall."""
    return (angle, *START[1:])


def fastest(seen: Seen) -> float:
    """The highest speed that the tool had [m/s]."""
    tool = ARM.fkine(np.array(seen.q))[:, :3, 3]
    return float(np.linalg.norm(np.diff(tool, axis=0), axis=1).max() / CYCLE)
