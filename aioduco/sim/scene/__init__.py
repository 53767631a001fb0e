"""What stands around the arm, and what it carries: boxes, tables, springs, or any MJCF."""

from __future__ import annotations

from aioduco.sim.scene.things import Box, Cylinder, Pad, Rod, Sphere, Table, Thing
from aioduco.sim.scene.xml import SceneLike, mjcf_of

__all__ = [
    "Box",
    "Cylinder",
    "Pad",
    "Rod",
    "SceneLike",
    "Sphere",
    "Table",
    "Thing",
    "mjcf_of",
]
