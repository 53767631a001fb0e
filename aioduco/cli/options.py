"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer

__all__ = [
    "Duration",
    "Guide",
    "Json",
    "MountingOption",
    "Pedestal",
    "SceneFile",
    "ToolFile",
    "Yes",
    "refuse_unused",
    "require_folder",
]

Yes: TypeAlias = Annotated[bool, typer.Option("--yes", "-y", help="Do not ask for confirmation.")]
Json: TypeAlias = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Duration: TypeAlias = Annotated[
    float | None, typer.Option(min=0.0, help="Duration [s]. Default: until Ctrl-C.")
]
Guide: TypeAlias = Annotated[
    bool, typer.Option(help="Guide the arm by hand, or move it in another way.")
]
SceneFile: TypeAlias = Annotated[
    Path | None,
    typer.Option(exists=True, dir_okay=False, help="MJCF file: what stands around the arm."),
]
ToolFile: TypeAlias = Annotated[
    Path | None,
    typer.Option(exists=True, dir_okay=False, help="MJCF file: what the flange carries."),
]
#: a text; `number_lists.mounting_option` reads it
MountingOption: TypeAlias = Annotated[
    str, typer.Option(help="floor, wall, ceiling, or the base's x,y,z,rx,ry,rz [m, rad].")
]
Pedestal: TypeAlias = Annotated[
    float, typer.Option(help="Height of a column under an arm on the floor [m].")
]


def require_folder(option: str, path: Path | None) -> None:
    """Require that a file can be made, before what is to be written into it is done.

    Args:
        option: the option that names the file.
        path: the file; None for none.

    Raises:
        BadParameter: its folder does not exist.
    """
    if path is not None and not path.parent.is_dir():
        raise typer.BadParameter(f"there is no folder {path.parent}", param_hint=option)


def refuse_unused(context: typer.Context, use: str, *names: str) -> None:
    """Refuse options and arguments that are given, and would have no effect.

    Args:
        context: the command with what was given to it.
        use: what they are for, for the message: "is for …".
        names: the names of their parameters.

    Raises:
        BadParameter: one of them is given.
    """
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        if name in names and source is not None and source.name == "COMMANDLINE":
            options = (each for each in parameter.opts if each.startswith("--"))
            hint = next(options, name.upper())
            raise typer.BadParameter(f"it is for {use}", param_hint=hint)
