"""Options that several commands have."""

from __future__ import annotations

import enum
import os
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

import typer

from aioduco.errors import CellFileError, ParameterError
from aioduco.models.address import WrongAddress

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco.kinematics.mounting import MountingLike


#: settings of a command with numbers among its arguments: a negative one is no option
WITH_NUMBERS: Final = {"ignore_unknown_options": True}

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
#: a text; `mounting_option` reads it
MountingOption: TypeAlias = Annotated[
    str, typer.Option(help="floor, wall, ceiling, or the base's x,y,z,rx,ry,rz [m, rad].")
]
Pedestal: TypeAlias = Annotated[
    float, typer.Option(help="Height of a column under an arm on the floor [m].")
]


@contextmanager
def wrong_option(option: str | None = None) -> Iterator[None]:
    """End the command for a wrong option if what the block makes of it is not allowed.

    Args:
        option: name of the option; None if the message says it.
    """
    try:
        yield
    except (CellFileError, ParameterError, WrongAddress) as error:
        raise typer.BadParameter(str(error), param_hint=option) from None


def require_readable(option: str, path: Path | None) -> None:
    """Require that a file can be read, where it depends on other options whether it is.

    Args:
        option: the option that names the file.
        path: the file; None for none.

    Raises:
        BadParameter: it does not exist, is a folder, or may not be read.
    """
    if path is not None and not (path.is_file() and os.access(path, os.R_OK)):
        raise typer.BadParameter(f"there is no file {path} that can be read", param_hint=option)


def require_writable(option: str, path: Path | None, *inputs: Path | None) -> None:
    """Require that a file can be written, before what is to be written into it is done.

    Args:
        option: the option that names the file.
        path: the file; None for none.
        inputs: files that the command reads, and that writing would destroy; None for none.

    Raises:
        BadParameter: it is a folder, its folder does not exist, it may not be written, or it is one
            of the inputs.
    """
    if path is None:
        return
    place = path if path.exists() else path.parent
    wrong = ""
    if path.is_dir():
        wrong = f"{path} is a folder"
    elif not path.parent.is_dir():
        wrong = f"there is no folder {path.parent}"
    elif not os.access(place, os.W_OK):
        wrong = f"{path} cannot be written: {place} is write-protected"
    elif path.exists() and any(
        each is not None and each.exists() and path.samefile(each) for each in inputs
    ):
        wrong = f"{path} is read by this command, and would be overwritten"
    if wrong:
        raise typer.BadParameter(wrong, param_hint=option)


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


class Mounting(enum.StrEnum):
    """Where the arm is mounted."""

    FLOOR = "floor"
    WALL = "wall"
    CEILING = "ceiling"


def numbers(option: str, text: str, count: int) -> list[float]:
    """Numbers with commas between them.

    Args:
        option: name of the option, for the error.
        text: its value.
        count: how many numbers it must have.

    Raises:
        BadParameter: it is something else.
    """
    try:
        values = [float(each) for each in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise typer.BadParameter(
            f"{option} is {text!r}, but must be {count} numbers with commas between them"
        )
    return values


def mounting_option(text: str) -> MountingLike:
    """The mounting that an option names, or the pose that it gives.

    Raises:
        BadParameter: it is neither a name nor six numbers.
    """
    if "," in text:
        return numbers("mounting", text, 6)
    if text not in tuple(Mounting):
        names = ", ".join(Mounting)
        raise typer.BadParameter(f"mounting is {text!r}, but must be {names} or six numbers")
    return Mounting(text).value
