"""Texts of the package for the user of commands: with a command in place of each function."""

from __future__ import annotations

from typing import Final

from aioduco.models.places import PLACES
from aioduco.models.user_terms import in_terms_of

#: function of the robot that errors, advice and log messages name -> the command for it
COMMANDS: Final = {
    **{name: f"`aioduco call {name}`" for names in PLACES.values() for name in names.split()},
    **{name: f"`aioduco {name}`" for name in ("recover", "stop", "pause", "resume")},
    "bring_up": "`aioduco bring-up`",
    "rearm_heartbeat": "`aioduco recover`",
    "move_jog": "`aioduco jog`",
}


def in_commands(told: object) -> str:
    """Return an error, advice or a message as the user of commands is told it."""
    return in_terms_of(COMMANDS, str(told))
