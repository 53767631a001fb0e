"""Settings that change how the motions that come are planned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aioduco.sim.planner.weaving import Weave


__all__ = ["OptimizationSwitches", "WeaveSelection"]


@dataclass(slots=True)
class OptimizationSwitches:
    """What is switched on.

    Attributes:
        speed: in automatic mode speeds are as high as the arm allows, whatever a motion asks for.
        acceleration: accelerations are as high as the drives allow.
        singularity: a line through a singularity is gone around in joint space.
        vibration: starts and stops are smoothed; on from the beginning.
    """

    speed: bool = False
    acceleration: bool = False
    singularity: bool = False
    vibration: bool = True

    @property
    def avoids(self) -> bool:
        """Whether singularities are avoided: vibration control comes first (manual 1.3.11)."""
        return self.singularity and not self.vibration


@dataclass(slots=True)
class WeaveSelection:
    """The weave that was set, and the one that is in use.

    Attributes:
        chosen: the latest that was set; it is used from the next `enable` on.
        active: laid over the paths that come; None while it is switched off.
    """

    chosen: Weave | None = None
    active: Weave | None = None
