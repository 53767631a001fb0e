"""A robot for the time of a command."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import typer

from aioduco.cli.exit_codes import Terminated, ended_by_errors

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco.cli.addresses import RobotAddress
    from aioduco.sync import Robot

__all__ = ["looking_at", "moving", "until_told"]

#: seconds between two looks at whether there is something left to do
_LOOK: Final = 0.1


@contextmanager
def looking_at(address: RobotAddress, **options: Any) -> Iterator[Robot]:
    """Connect without a heartbeat: who moves the arm keeps its supervision.

    Errors and signals end the command. Leaving stops nothing.

    Args:
        address: the controller's.
        options: others of `connect`.
    """
    import aioduco.sync  # noqa: PLC0415 - for commands with a robot alone

    options = {"heartbeat": None, "lag_limit": None, **options}
    with (
        ended_by_errors(),
        aioduco.sync.connect(address.host, address.port, **options) as robot,
    ):
        yield robot


@contextmanager
def moving(address: RobotAddress, **options: Any) -> Iterator[Robot]:
    """Connect with a heartbeat. Whatever ends the command, the arm is stopped before it ends.

    Args:
        address: the controller's.
        options: others of `connect`.
    """
    import aioduco.sync  # noqa: PLC0415 - for commands with a robot alone

    options = {"lag_limit": None, **options}
    with (
        ended_by_errors("interrupted: the arm was stopped, and stands"),
        aioduco.sync.connect(address.host, address.port, **options) as robot,
    ):
        yield robot


def until_told(what: str, robot: Robot, going: Callable[[], bool], seconds: float | None) -> None:
    """Say what goes on, and wait until it is over: by itself, after a time, or by Ctrl-C.

    Args:
        what: the line that says what goes on; from it on, Ctrl-C is the way to end it.
        robot: what is looked at.
        going: whether it still goes on.
        seconds: for how long; None for no end.

    Raises:
        Terminated: SIGTERM asked for the end.
    """
    until = None if seconds is None else time.monotonic() + seconds
    try:
        typer.echo(f"{what}; Ctrl-C ends it")
        while going() and (until is None or time.monotonic() < until):
            left = _LOOK if until is None else until - time.monotonic()
            robot.sleep(min(_LOOK, max(0.0, left)))
    except Terminated:
        raise
    except KeyboardInterrupt:
        typer.echo()  # the ^C stands on a line of its own
