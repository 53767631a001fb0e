"""The arm of the planner's tests, where it stands, and what a plain motion takes."""

from __future__ import annotations

import math

import numpy as np

from aioduco.kinematics import arm

FIVE = arm("gcr5_910")
HOME = np.radians([0, 0, 90, 0, -90, 0])
CYCLE = 0.001


def trapezoid(length: float, v: float, a: float) -> float:
    """The time from rest to rest [s]."""
    return length / v + v / a if length > v * v / a else 2 * math.sqrt(length / a)
