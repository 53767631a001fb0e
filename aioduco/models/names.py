"""Place of each function of the manual and of the wire in this package.

The page of functions (`docs/functions.py`) and the errors for a name that is used on the wrong
object both ask here. `places.py` is generated from the robot's classes; the tables here say only
what the manual calls otherwise, or what a program does in its place. A test compares all of it with
the wire and with the manual.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from aioduco.errors import NamedElsewhere
from aioduco.models.places import PLACES

#: name in the manual or in the vendor's class, if different from the wire -> name on the wire
SPELLINGS: Final = {
    "move1": "movel",
    "move1_eaxis": "movel_eaxis",
    "set_digital_out_mode": "set_digital_output_mode",
    "get_noblock_taskstate": "get_noneblock_taskstate",
    "enable_combined_motion": "enable_combine_motion",
    "disable_combined_motion": "disable_combine_motion",
}

#: function of the wire that this package calls automatically -> when it calls it
BY_ITSELF: Final = {
    "rpc_heartbeat": "sent by itself while connected",
}

#: function of the manual that is not on the wire -> its replacement in a program
CLIENT_SIDE: Final = {
    "DucoCobot": "`aioduco.connect()`",
    "open": "`async with aioduco.connect() as robot`",
    "close": "the end of `async with`, or `await robot.aclose()`",
    "get_version": "`aioduco.__version__`",
}


#: function of blocking robots alone -> its replacement in a program with `async`
_BLOCKING_ALONE: Final = {"sleep": "`await asyncio.sleep(seconds)` in a program with `async`"}


def place(name: str) -> str | None:
    """Return the notation of a function in a program, such as `robot.motion.movel`.

    Args:
        name: name of the function on the wire or in the manual.

    Returns:
        The notation; None if there is no such function, or if the robot does not have it.
    """
    wire = SPELLINGS.get(name, name)
    for section, names in PLACES.items():
        if wire in names.split():
            return ".".join(filter(None, ("robot", section, wire)))
    return None


def _meant(name: str) -> str:
    """Describe the place of a function; empty if the manual has no such name."""
    where = place(name)
    if where is not None:
        wire = SPELLINGS.get(name)
        return where if wire is None else f"{where}: the controller calls it {wire}"
    return BY_ITSELF.get(name) or CLIENT_SIDE.get(name) or _BLOCKING_ALONE.get(name, "")


class ManualNames:
    """Base class whose error for a missing attribute names the place of a manual's function."""

    __slots__ = ()

    if not TYPE_CHECKING:  # a type checker would otherwise accept every name

        def __getattr__(self, name: str) -> Any:
            meant = "" if name.startswith("_") or hasattr(type(self), name) else _meant(name)
            if meant:
                raise NamedElsewhere(name, meant)
            # raises Python's own error, also an error that a property of this name has raised
            return object.__getattribute__(self, name)
