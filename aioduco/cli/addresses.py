"""The robot that a command is for, as an argument or an option of the command."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, TypeAlias

import typer

from aioduco.cli.options import wrong_option
from aioduco.cli.robots_file import ENVIRONMENT, RobotAddress, find, names

__all__ = ["CellFile", "Host", "HostOption", "HostOrSimulator", "Port", "RobotAddress", "robot_at"]


def robot_at(given: str | None, port: int | None = None, cell: Path | None = None) -> RobotAddress:
    """Find the robot of a command; see `robots_file.find`.

    Raises:
        typer.BadParameter: the file cannot be read, or the address is not valid.
    """
    with wrong_option():
        return find(given, port, cell)


def _names(incomplete: str) -> list[str]:
    """Names of robots, for the shell's completion."""
    return [name for name in names() if name.startswith(incomplete)]


_HELP: Final = (
    f"Address of the controller, or a name of your robots.toml. Default: {ENVIRONMENT}, the "
    "file's default, or a simulator on this computer."
)

Host: TypeAlias = Annotated[
    str | None, typer.Argument(help=_HELP, show_default=False, autocompletion=_names)
]
HostOrSimulator: TypeAlias = Annotated[
    str | None,
    typer.Argument(help="A controller's address, or its name. Without it: a simulated arm."),
]
HostOption: TypeAlias = Annotated[
    str | None, typer.Option("--host", help=_HELP, show_default=False, autocompletion=_names)
]
Port: TypeAlias = Annotated[
    int | None,
    typer.Option(
        min=1, max=65535, help="Its port, if it is not the one of the name or address, or 7003.",
        show_default=False,
    ),
]  # fmt: skip
CellFile: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--cell", exists=True, dir_okay=False, show_default=False,
        help="File of a cell, cell.toml: its robots by name, its limits, and what stands in it.",
    ),
]  # fmt: skip
