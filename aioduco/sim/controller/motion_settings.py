"""Settings for the planning of later motions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aioduco.sim.planner.weaving import Weave


@dataclass(frozen=True, slots=True)
class OptimizationSwitches:
    """The switches of the optimization.

    Attributes:
        speed: in automatic mode speeds are as high as the arm allows, whatever a motion requests.
        acceleration: accelerations are as high as the drives allow.
        singularity: a line through a singularity goes around it in joint space.
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
        chosen: the latest weave that was set; the next enable_combine_motion makes it active.
        active: the weave that is added to later paths; None while it is switched off.
    """

    chosen: Weave | None = None
    active: Weave | None = None
