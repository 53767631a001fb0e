"""Lines and arcs of the tool: their lengths, and points that make no arc."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from for_each import for_each
from numpy.typing import NDArray

from aioduco.errors import ParameterError
from aioduco.planning.toolpath import poses_along


def at(x: float, z: float) -> NDArray[np.float64]:
    pose = np.eye(4)
    pose[:3, 3] = 0.4 + x, 0.0, 0.4 + z
    return pose


@for_each("radius", [0.2, 0.02, 0.002, 0.0008, 0.0005, 0.0002, 0.00002])
def test_a_half_circle_of_any_size_is_an_arc(radius: float) -> None:
    found = poses_along(at(-radius, 0.0), at(0.0, radius), at(radius, 0.0))
    assert found.length == pytest.approx(math.pi * radius, rel=1e-6)


@for_each("size, via", product([1.0, 0.001], [(0.0, 0.0), (-1.0, 0.0), (1.0, 0.0), (0.3, 1e-7)]))
def test_three_points_on_a_line_are_none(size: float, via: tuple[float, float]) -> None:
    with pytest.raises(ParameterError, match="off the line"):
        poses_along(at(-size, 0.0), at(via[0] * size, via[1] * size), at(size, 0.0))
