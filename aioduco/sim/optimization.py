"""The switches that change how motions are planned (manual 1.3.11)."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Optimization"]


@dataclass(slots=True)
class Optimization:
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
