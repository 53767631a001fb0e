"""Changes of the physics that callers ask for: a push, a load, a drag, and others.

Any thread may ask. The simulation's thread makes them before its next cycle.
"""

from __future__ import annotations

import threading
from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.sim.physics.world import World


class PlantChanges:
    """Holds what is to change in the physics until the simulation's thread makes the changes.

    Args:
        plant: the physics.
    """

    def __init__(self, plant: World) -> None:
        self._plant = plant
        self._wake = threading.Event()
        self._changes: deque[Callable[[], object]] = deque()
        #: what the changes have changed in what the controller knows: for the next readings
        self._told: list[Callable[[], object]] = []
        self._pushed: bool = False  # whether something pushes the arm
        self._carries: bool = False  # whether `carry` mounts a load

    def change_world(self, change: Callable[[], object]) -> None:
        """Change the physics before the next cycle, on the thread that computes it.

        Args:
            change: must not raise an error, which would end the simulation.
        """
        self._changes.append(change)
        self._wake.set()

    def push(self, wrench: Sequence[float]) -> None:
        """Push at the flange from now on [N, N m], in the base frame."""
        push = tuple(wrench)
        self._pushed = any(push)
        self.change_world(lambda: self._plant.push(push))

    def load(
        self,
        mass: float,
        centre: Sequence[float],
        told: Callable[[], object] = lambda: None,
    ) -> None:
        """Set a load in the drives, and mount it unless `carry` has mounted another.

        Args:
            mass: its mass [kg].
            centre: its centre of mass [m].
            told: called before the first cycle of the controller whose readings have the load.
        """
        at = tuple(centre)

        def change() -> None:
            mount = self._plant.set_modelled_load if self._carries else self._plant.load
            mount(mass, at)
            self._told.append(told)

        self.change_world(change)

    def carry(self, mass: float, centre: Sequence[float]) -> None:
        """Mount a load at the flange [kg, m], whatever load is set in the drives."""
        at = tuple(centre)
        self._carries = True
        self.change_world(lambda: self._plant.carry(mass, at))

    def drag(self, dry: Sequence[float], viscous: Sequence[float]) -> None:
        """Set what drags at the joints, which the drives do not know [N m, N m s/rad]."""
        drag = tuple(dry), tuple(viscous)
        self.change_world(lambda: self._plant.drag(*drag))

    @property
    def _acted_upon(self) -> bool:
        """Whether a change is to be made, or something pushes the arm."""
        return bool(self._changes) or self._pushed

    def _make_changes(self) -> None:
        """Make the changes since the last cycle; on the thread that computes the physics."""
        while self._changes:
            self._changes.popleft()()
