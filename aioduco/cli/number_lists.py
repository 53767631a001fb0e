"""Numbers and mountings in options of the command line."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from aioduco.kinematics.mounting import MountingLike


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
