"""What the controller keeps besides the arm: variables, settings, ports, files."""

from __future__ import annotations

from dataclasses import dataclass, field

from aioduco.sim.values import SystemValues

__all__ = ["Cabinet"]


@dataclass(slots=True)
class Cabinet:
    """Everything in the cabinet that no motion needs.

    Attributes:
        values: system values.
    """

    values: SystemValues = field(default_factory=SystemValues)
