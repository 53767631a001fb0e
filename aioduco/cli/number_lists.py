"""Numbers and mountings in options of the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from aioduco.kinematics.mounting import MountingLike

__all__ = ["mounting_option", "numbers"]


def numbers(option: str, text: str, count: int) -> list[float]:
    """Numbers with commas between them.

    Args:
        option: name of the option, for the error.
        text: its value.
        count: how many numbers it must have.

    Raises:
        ParameterError: it is something else.
    """
    from aioduco.errors import ParameterError  # noqa: PLC0415 - quick help

    try:
        values = [float(each) for each in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise ParameterError(option, text, f"{count} numbers with commas between them")
    return values


def mounting_option(text: str) -> MountingLike:
    """The mounting that an option names, or the pose that it gives.

    Raises:
        ParameterError: it is a list, but not of six numbers. The names are not checked.
    """
    return numbers("mounting", text, 6) if "," in text else cast("MountingLike", text)
