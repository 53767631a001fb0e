"""Load of an arm."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["Load"]


class Load(NamedTuple):
    """Mass and centre of mass of a load (负载质量, 质心). A sequence of four numbers.

    Attributes:
        mass: mass [kg].
        x: centre of mass along x [m].
        y: centre of mass along y [m].
        z: centre of mass along z [m].
    """

    mass: float
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
