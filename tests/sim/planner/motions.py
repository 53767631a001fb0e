"""The arm of the planner's tests, where it stands, how it is moved, and what that takes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from aioduco.kinematics import arm
from aioduco.models.rotation import Array
from aioduco.sim.planner.mover import Mover, MoverTick
from aioduco.sim.planner.segments import Segment

FIVE = arm("gcr5_910")
HOME = np.radians([0, 0, 90, 0, -90, 0])
CYCLE = 0.001


def shifted(q: Array, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Array:
    """The flange at q, moved in the base frame."""
    flange = FIVE.fkine(q)
    flange[:3, 3] += x, y, z
    return flange


def moving(*plans: Callable[[Array], Segment], **options: Any) -> Mover:
    """A mover at home with motions in its queue, of the numbers 1, 2 and so on."""
    mover = Mover(FIVE, HOME, CYCLE, **options)
    for key, plan in enumerate(plans, start=1):
        mover.append(key, plan)
    return mover


def ticks_of(mover: Mover) -> list[MoverTick]:
    """What it does until it stands, cycle by cycle."""
    found = []
    while mover.moving:
        found.append(mover.tick())
    return found


def ran(follower: Any, cycles: int = 30_000) -> Array:
    """Set-points of a follower until it has ended. Shape (n, 3, 6)."""
    rows = []
    while not follower.ended:
        point = follower.tick(np.zeros(6), np.zeros(6))
        rows.append((point.q, point.qd, point.qdd))
        assert len(rows) < cycles
    return np.array(rows)


def trapezoid(length: float, v: float, a: float) -> float:
    """The time from rest to rest [s]."""
    return length / v + v / a if length > v * v / a else 2 * math.sqrt(length / a)
