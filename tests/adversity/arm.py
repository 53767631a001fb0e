"""Checks of the arm after the program has ended."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

import aioduco.sync
from aioduco.sim import Simulator
from aioduco.testing import eventually_async

#: tasks that move nothing, and end by themselves
_STANDING = frozenset({"power_on", "power_off", "enable", "disable"})

#: by how much the joints may still swing after their set-points have come to rest [rad]
_SETTLING = 2e-3


@contextmanager
def ready() -> Iterator[Simulator]:
    """A simulated arm that is enabled, and as fast as the wall: so are heartbeats and stalls."""
    with Simulator(speed=200.0) as sim:
        with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as robot:
            robot.bring_up()
        sim.speed = 1.0
        yield sim


def random_target(rng: random.Random) -> list[float]:
    """Joints far from every singularity [rad]."""
    low, high = (-0.5, -0.2, 1.2, -0.3, -1.8, -0.5), (0.5, 0.2, 1.8, 0.3, -1.3, 0.5)
    return [rng.uniform(a, b) for a, b in zip(low, high, strict=True)]


def idle(sim: Simulator) -> bool:
    """Whether no task is there that could move the arm."""
    return all(task.name in _STANDING for task in sim.tasks)


def unrest(sim: Simulator) -> str:
    """What keeps the arm from standing, for messages."""
    return f"moving: {sim.moving}; tasks: {sim.tasks}; states: {sim.view[:4]}"


async def see_it_stand(sim: Simulator, after: object) -> None:
    """See that no task moves the arm at this moment, and that it does no more than settle."""
    joints = sim.joints.array
    assert idle(sim), f"after {after}: {unrest(sim)}"
    await eventually_async(lambda: not sim.moving, what=lambda: f"{after}: {unrest(sim)}")
    moved = float(np.abs(sim.joints.array - joints).max())
    assert moved < _SETTLING, f"after {after} the arm moved on by {moved} rad"
