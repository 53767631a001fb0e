"""Changes of the physics that callers ask for: a push, a load, a drag, and others.

Any thread may ask. The simulation's thread passes them on before its next cycle.
"""

from __future__ import annotations

import threading
from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.sim.cycle import Plant

__all__ = ["PlantChanges"]

_NO_PUSH: tuple[float, ...] = (0.0,) * 6
_NO_DRAG: tuple[Sequence[float], Sequence[float]] = (_NO_PUSH, _NO_PUSH)


class PlantChanges:
    """Holds what is to change in the physics until the simulation's thread passes it on."""

    def __init__(self) -> None:
        self._wake = threading.Event()
        self._changes: deque[Callable[[], object]] = deque()
        #: whether one of these values was changed
        self._dirty: bool = False
        self._push: Sequence[float] = _NO_PUSH
        self._pushed: Sequence[float] = _NO_PUSH
        self._drag = self._dragged = _NO_DRAG
        self._load: tuple[float, Sequence[float]] = (0.0, (0.0, 0.0, 0.0))
        self._loaded: tuple[float, Sequence[float]] = self._load
        self._carry: tuple[float, Sequence[float]] | None = None
        self._carried: tuple[float, Sequence[float]] | None = None

    def change_world(self, change: Callable[[], object]) -> None:
        """Change the physics before the next cycle, on the thread that computes it.

        Args:
            change: must not raise an error, which would end the simulation.
        """
        self._changes.append(change)
        self._dirty = True
        self._wake.set()

    def push(self, wrench: Sequence[float]) -> None:
        """Push at the flange from now on [N, N m], in the base frame."""
        self._push = tuple(wrench)
        self._dirty = True
        self._wake.set()

    def load(self, mass: float, centre: Sequence[float]) -> None:
        """Set a load in the drives [kg, m], and mount it unless `carry` has mounted another."""
        self._load = (mass, tuple(centre))
        self._dirty = True
        self._wake.set()

    def carry(self, mass: float, centre: Sequence[float]) -> None:
        """Mount a load at the flange [kg, m], whatever load is set in the drives."""
        self._carry = (mass, tuple(centre))
        self._dirty = True
        self._wake.set()

    def drag(self, dry: Sequence[float], viscous: Sequence[float]) -> None:
        """Set what drags at the joints, which the drives do not know [N m, N m s/rad]."""
        self._drag = (tuple(dry), tuple(viscous))
        self._dirty = True
        self._wake.set()

    @property
    def _acted_upon(self) -> bool:
        """Whether a change is to be passed on, or something pushes the arm."""
        changed = bool(self._changes) or self._pushed is not self._push or any(self._pushed)
        changed = changed or self._loaded is not self._load or self._dragged is not self._drag
        return changed or self._carried is not self._carry

    def _pass_on(self, plant: Plant) -> None:
        """Pass the changes since the last cycle to the physics; on the thread that computes it."""
        self._dirty = False  # first: a change that comes meanwhile is passed in the next cycle
        while self._changes:
            self._changes.popleft()()
        if self._pushed is not self._push:
            self._pushed = self._push
            plant.push(self._pushed)
        if self._dragged is not self._drag:
            self._dragged = self._drag
            plant.drag(*self._dragged)
        if self._carried is not self._carry and self._carry is not None:
            self._carried = self._carry
            plant.carry(*self._carried)
        if self._loaded is not self._load:
            self._loaded = self._load
            mount = plant.load if self._carried is None else plant.set_modelled_load
            mount(*self._loaded)
