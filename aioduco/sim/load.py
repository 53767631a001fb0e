"""Loads: what the flange carries, as the controller is told (set_tool_data, set_load_data)."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["Load"]


class Load(NamedTuple):
    """A mass in one point.

    Attributes:
        mass: kg.
        centre: in the flange's frame [m].
    """

    mass: float = 0.0
    centre: tuple[float, ...] = (0.0, 0.0, 0.0)

    def along(self, other: Load) -> Load:
        """Give both together."""
        mass = self.mass + other.mass
        if mass == 0.0:
            return Load()
        pairs = zip(self.centre, other.centre, strict=True)
        return Load(mass, tuple((self.mass * a + other.mass * b) / mass for a, b in pairs))
