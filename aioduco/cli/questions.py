"""The question before a command moves an arm or changes one of its outputs or settings."""

from __future__ import annotations

import typer

from aioduco.cli.exit_codes import NOT_CONFIRMED, fail
from aioduco.cli.output import say, shown

#: what a person must ensure before an arm moves
SAFE = (
    "No path is checked for obstacles. Is everyone out of reach, and someone at the emergency stop?"
)


#: what a person must know before an arm is guided by hand
GIVES_WAY = (
    "The arm at {} will give way to a hand. With a load or tool that its controller does not know "
    "of, it sinks or rises by itself. Hold it."
)


def ask(what: str, question: str, *, yes: bool) -> None:
    """Print what is about to happen, and continue only if the user confirms it.

    Text and question go to the standard error; `--json` alone writes to the standard output.

    Args:
        what: text that says what will happen.
        question: the question, such as "Move the arm?".
        yes: whether the command line already confirms it.
    """
    if yes:
        return
    say(what, error=True)
    try:
        agreed = typer.confirm(shown(question), default=False, err=True)
    except (typer.Abort, RuntimeError):  # the end of the input, or there is none (`<&-`)
        say(error=True)  # the question is still the last thing in its line
        agreed = False
    if not agreed:
        fail("not confirmed: nothing was sent that moves the arm", NOT_CONFIRMED)


def typed_line(question: str) -> str | None:
    """Ask for a line, by the standard error, and return it; None without further input."""
    say(question, error=True, end="")
    try:
        return input().strip()
    except (EOFError, RuntimeError):
        say(error=True)
        return None
