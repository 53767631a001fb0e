"""A cell in one file: its robots, tool, frames, points, waypoints, scene, limits and gripper.

    cell = Cell.load("cell.toml")
    async with cell.connect() as robot:  # kept within the cell's limits
        await robot.motion.movej2(cell.joints("ready"), v=1.0, a=2.0)

A part above `aioduco.planning`: it makes robots, simulators and scenes, and uses each by its public
interface.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.planning.cell.cell import Cell
from aioduco.planning.cell.sections import CellRobot, CellTool

if TYPE_CHECKING:
    from aioduco.planning.cell.grippers import CellGripper

__all__ = ["Cell", "CellGripper", "CellRobot", "CellTool"]


def __getattr__(name: str) -> Any:
    """Load the drivers of grippers on first use alone."""
    if name != "CellGripper":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from aioduco.planning.cell.grippers import CellGripper  # noqa: PLC0415

    return CellGripper
