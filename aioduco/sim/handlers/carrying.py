"""What setting a tool and setting a load have in common: the arm carries both."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.sim.handlers.base import Section
from aioduco.sim.load import Load

if TYPE_CHECKING:
    from aioduco.sim.controller import Controller

__all__ = ["CarryingSection"]


class CarryingSection(Section):
    """Handlers that change what the arm carries."""

    def _carry(self, controller: Controller) -> None:
        """Tell sensor and drives of the tool in use and of what it holds; both are mounted.

        A tool that the simulator was given is there already, as heavy as it is.
        """
        mass, *centre = controller.frames.tool().payload
        held = self._cabinet.held
        both = Load(mass, tuple(centre)).along(held)
        controller.force.carry(both.mass, both.centre)
        self._runtime.load(*(held if self._cabinet.tooled else both))
