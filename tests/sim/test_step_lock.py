"""Simulated time that goes on by whole cycles alone, and things that are put in their places."""

from __future__ import annotations

import numpy as np
import pytest

from aioduco.errors import ParameterError
from aioduco.sim import Simulator
from aioduco.sim.scene import Box


@pytest.mark.usefixtures("real_cycle")
def test_time_goes_on_by_whole_cycles_and_the_same_each_time() -> None:
    box = Box(at=(0.5, 0.0, 0.3), size=(0.05, 0.05, 0.05), mass=0.1, name="box")
    with Simulator(speed=float("inf"), scene=[box]) as sim:
        with pytest.raises(RuntimeError, match="not locked"):
            sim.advance(1)
        with pytest.raises(RuntimeError, match="not locked"):
            sim.arrange({})
        sim.lock_time()
        ways = []
        for _ in range(2):
            sim.arrange({"box": (0.7, -0.4, 0.5, 0.0, 0.3, 0.0)})
            begun = sim.time
            way = []
            for cycles in (1, 7, 20):
                sim.advance(cycles)
                way.append(sim.positions[sim.place("box")])
            assert sim.time == pytest.approx(begun + 0.028, abs=1e-9)
            ways.append(np.array(way))
        first, second = ways
        np.testing.assert_array_equal(first, second)
        fallen = 0.5 - 0.5 * 9.81 * 0.028**2
        assert sim.thing("box").z == pytest.approx(fallen, abs=5e-4)
        with pytest.raises(ParameterError, match="one of the things"):
            sim.arrange({"ball": (0, 0, 0, 0, 0, 0)})
        with pytest.raises(ValueError, match="from 1 to"):
            sim.advance(0)
        locked = sim.time
        sim.unlock_time()
        sim.wait_until(lambda: sim.time > locked + 0.1)
