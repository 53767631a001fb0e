"""Measures a sequence of set-points: the largest velocity, acceleration and jerk per group."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from aioduco.streaming.shared.space import Config, Space


class Peaks(NamedTuple):
    velocity: list[float]
    acceleration: list[float]
    jerk: list[float]


def peaks(space: Space, points: Sequence[Config], period: float) -> Peaks:
    """Largest finite differences of each group, from rest before the first point."""
    steps = np.array(
        [(0.0,) * 6] * 3 + [space.difference(a, b) for a, b in itertools.pairwise(points)]
    )
    found = []
    for order in (1, 2, 3):
        changes = np.diff(steps, n=order - 1, axis=0) / period**order
        found.append(
            [float(np.linalg.norm(changes[:, group], axis=1).max()) for group in space.groups]
        )
    return Peaks(*found)
