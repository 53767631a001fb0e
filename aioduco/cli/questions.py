"""The question before a command moves an arm, or sets something at it."""

from __future__ import annotations

import typer

from aioduco.cli.exit_codes import NOT_CONFIRMED

__all__ = ["SAFE", "ask"]

#: what a person has to see to before an arm moves
SAFE = (
    "No path is checked for obstacles. Is everyone out of reach, and someone at the emergency stop?"
)


def ask(what: str, question: str, *, yes: bool) -> None:
    """Say what is about to happen, and go on only if that is confirmed.

    It is said on the standard error, so that `--json` has the standard output for itself.

    Args:
        what: what will happen.
        question: what is asked, such as "Move the arm?".
        yes: whether the command line has answered it.
    """
    if yes:
        return
    typer.echo(what, err=True)
    try:
        agreed = typer.confirm(question, default=False, err=True)
    except typer.Abort:
        agreed = False
    if not agreed:
        typer.echo("not confirmed: nothing was sent that moves the arm", err=True)
        raise typer.Exit(NOT_CONFIRMED)
