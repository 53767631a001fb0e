"""What a person at the machine does, as methods of the simulator."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.enums import OperationMode
    from aioduco.sim.runtime import Runtime

__all__ = ["Operating"]


class Operating(ABC):
    """The inputs, buttons and switches of a running machine, and its arm within reach."""

    @abstractmethod
    def _running(self) -> Runtime:
        """Give the simulation, which must be running."""

    def set_digital_input(self, num: int, value: bool) -> None:
        """Set a general input of the cabinet, 1 to 16."""
        with self._running().command() as controller:
            controller.signals.standard_in[num] = value

    def set_tool_digital_input(self, num: int, value: bool) -> None:
        """Set an input of the tool, 1 or 2."""
        with self._running().command() as controller:
            controller.signals.tool_in[num] = value

    def switch_mode(self, mode: OperationMode) -> None:
        """Turn the mode switch of the cabinet; what runs is paused, as by `switch_mode`.

        With `cabinet.mode_switch` programs cannot switch the mode.

        Args:
            mode: manual, automatic or remote.
        """
        with self._running().command() as controller:
            controller.switch_mode(mode)

    def emergency_stop(self) -> None:
        """Press the emergency stop."""
        with self._running().command() as controller:
            controller.press_emergency_stop()

    def release_emergency_stop(self) -> None:
        """Release the emergency stop; power off, power on and enable lead out of the stop."""
        with self._running().command() as controller:
            controller.release_emergency_stop()

    def collide(self, joint: int) -> None:
        """Let a joint, 1 to 6, detect a collision, unless a program has switched that off."""
        if not 1 <= joint <= 6:
            raise ValueError(f"joint is {joint}, but must be from 1 to 6")
        with self._running().command() as controller:
            if controller.collisions.level:
                controller.collide(joint)

    def push(self, wrench: Sequence[float]) -> None:
        """Push at the flange from now on, as a person does who guides the arm by hand.

        Args:
            wrench: force [N], then torque [N m], in the base frame; six zeros to let go.
        """
        if len(wrench) != 6:
            raise ValueError(f"wrench has {len(wrench)} numbers, but must have 6")
        self._running().push(wrench)

    def load(self, mass: float, centre: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Hang a load on the flange, whatever the program says is there.

        Until this is called, what hangs there is what the program tells by `set_tool_data` and
        `set_load_data`. From then on the two are apart: a controller that was told wrongly takes
        the difference for a force from outside, as a real one does.

        Args:
            mass: of the load, a point without inertia of its own [kg]; zero for none.
            centre: its centre of mass in the frame of the flange [m].
        """
        if not (math.isfinite(mass) and mass >= 0.0) or len(centre) != 3:
            raise ValueError(f"a load of {mass} kg at {centre} cannot be")
        self._running().carry(mass, centre)
