"""The file of a cell as an option of a command."""

from __future__ import annotations

from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias

import typer

from aioduco.cli.options import wrong_option

if TYPE_CHECKING:
    from aioduco import Cell


RobotName: TypeAlias = Annotated[
    str | None,
    typer.Option("--robot", help="Its robot, with --cell. Default: that of the cell."),
]
#: what options say of a simulated arm if they are not given
_USUAL: Final[dict[str, Any]] = {"model": "gcr5_910", "mounting": "floor", "pedestal": 0.0}


def load_cell(path: Path) -> Cell:
    """Read the file of a cell.

    Raises:
        typer.BadParameter: it is not valid; the message has the line.
    """
    from aioduco import Cell  # noqa: PLC0415 - for commands with a cell alone

    with wrong_option():
        return Cell.load(path)


def simulated_parts(cell: Path | None, robot: str | None, **given: Any) -> dict[str, Any]:
    """The arguments of a simulator: those of a cell, and of the options that are given.

    Args:
        cell: file of the cell; None for none.
        robot: name of the robot in it; None for its default.
        given: values of options, by the simulator's names.
    """
    if cell is None:
        if robot is not None:
            raise typer.BadParameter("is a robot of --cell, which is not given",
                                     param_hint="--robot")  # fmt: skip
        return given
    with wrong_option():
        found = load_cell(cell).simulator_options(robot)
    said = {
        key: value for key, value in given.items() if value is not None and value != _USUAL.get(key)
    }
    if "tool" in said:
        found.pop("gripper", None)
    if "gripper" in said:
        found.pop("tool", None)
    return {**given, **found, **said}


def is_cell(path: Path) -> bool:
    """Whether a file is one of a cell: TOML with robots, or with a table of points."""
    from aioduco.models.toml_files import read_toml  # noqa: PLC0415

    try:
        found = read_toml(path)
    except (OSError, ValueError):
        return False
    points = found.get("points")
    return "robots" in found or (
        isinstance(points, dict) and all(isinstance(each, dict) for each in points.values())
    )
