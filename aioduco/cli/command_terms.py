"""Texts of the package for the user of commands: with a command in place of each function."""

from __future__ import annotations

from typing import Final

from aioduco.models.places import PLACES
from aioduco.models.user_terms import in_terms_of

#: arguments of the functions that advice names without them
_ARGUMENTS: Final = {
    "fc_force_set_value": " '[true, true, true, true, true, true]' '[0, 0, 0, 0, 0, 0]'"
}


def commands(at: str = "") -> dict[str, str]:
    """Return what stands in place of what errors, advice and log messages name of a robot.

    Args:
        at: the arm's address, which the commands then name; empty: they are for the default arm.
    """
    host, option = (f" {at}", f" --host {at}") if at else ("", "")
    called = (name for names in PLACES.values() for name in names.split())
    return {
        **{name: f"`aioduco call {name}{_ARGUMENTS.get(name, '')}{option}`" for name in called},
        **{name: f"`aioduco {name}{host}`" for name in ("recover", "stop", "pause", "resume")},
        "bring_up": f"`aioduco bring-up{host}`",
        "rearm_heartbeat": f"`aioduco recover{host}`",
        "move_jog": f"`aioduco jog{option}`",
        "envelope": "the envelope in the file that gives it",
    }


def in_commands(told: object, at: str = "") -> str:
    """Return an error, advice or a message as the user of commands is told it.

    Args:
        told: the error, advice or message.
        at: the arm's address, as of `commands`.
    """
    return in_terms_of(commands(at), str(told))
