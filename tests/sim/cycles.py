"""What the drives were told and what the arm did, cycle by cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.sim.world import World

if TYPE_CHECKING:
    import pytest

    from aioduco.models.rotation import Array
    from aioduco.sim.planner.mover import SetPoint


class Cycles:
    """Every cycle of the simulation, however fast it goes.

    Attributes:
        points: set-points.
        q: the arm's joints after each of them [rad]. Shapes (6,).
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.points: list[SetPoint] = []
        self.q: list[Array] = []
        step = World.step

        def record(world: World, setpoint: SetPoint) -> None:
            step(world, setpoint)
            self.points.append(setpoint)
            self.q.append(world.q)

        monkeypatch.setattr(World, "step", record)

    @property
    def wanted(self) -> list[Array]:
        """Joints of the set-points [rad]. Shapes (6,)."""
        return [point.q for point in self.points]

    def clear(self) -> None:
        """Forget what was before, and begin with the next cycle."""
        self.points.clear()
        self.q.clear()
