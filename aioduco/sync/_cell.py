"""A robot of a cell for blocking programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.sync._generated import Robot, connect

if TYPE_CHECKING:
    from aioduco.planning.cell import Cell


def connect_cell(cell: Cell, name: str | None = None, **options: Any) -> Robot:
    """Create a robot of a cell, kept within the cell's limits; `with` connects to it.

    Args:
        cell: the cell.
        name: name of the robot; None for the default, or the only one.
        **options: as of `connect`; `host` and `port` for another address, such as a simulator's.

    Raises:
        ParameterError: there is no such robot, or an option is out of range.
    """
    robot = cell.robot(name)
    made = connect(**{"host": robot.host, "port": robot.port, **options})
    made.envelope = cell.envelope(robot.name)
    return made
