"""Set-points and positions of the arm, cycle by cycle."""

from __future__ import annotations

import numpy as np
import pytest

from aioduco.models.rotation import Array
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint


class Cycles:
    """Every cycle of the simulation, however fast it goes.

    The simulation's thread writes while tests read: what belongs together is written in one go.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self._rows: list[tuple[JointSetPoint, Array]] = []
        step = World.step

        def record(world: World, setpoint: JointSetPoint) -> None:
            step(world, setpoint)
            self._rows.append((setpoint, world.q))

        monkeypatch.setattr(World, "step", record)

    @property
    def points(self) -> list[JointSetPoint]:
        """Set-points."""
        return [point for point, _ in self._rows.copy()]

    @property
    def q(self) -> list[Array]:
        """The arm's joints after each set-point [rad]. Shapes (6,)."""
        return [q for _, q in self._rows.copy()]

    def farthest(self) -> float:
        """How far a joint was from its set-point at most [rad]."""
        return float(np.abs([point.q - q for point, q in self._rows.copy()]).max())

    @property
    def wanted(self) -> list[Array]:
        """Joints of the set-points [rad]. Shapes (6,)."""
        return [point.q for point in self.points]

    def clear(self) -> None:
        """Forget what was before, and begin with the next cycle."""
        self._rows.clear()
