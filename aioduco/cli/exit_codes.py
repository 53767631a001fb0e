"""Exit codes of the commands, and the exit code of each error."""

from __future__ import annotations

import signal
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, NoReturn

from aioduco.cli.output import log_about, say

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path
    from types import FrameType


#: the command failed; the message says why
FAILED: Final = 1
#: wrong options or arguments, or a wrong file of settings or points that they name
USAGE: Final = 2
#: the question was not answered with yes; nothing was sent that moves the arm
NOT_CONFIRMED: Final = 3
#: it is not known that the arm stands: press the emergency stop
STOP_UNCONFIRMED: Final = 4
#: a person has to do something at the arm first; the message says what
PERSON_NEEDED: Final = 5
#: plus the number of the signal that ended the command: 130 for Ctrl-C
SIGNALLED: Final = 128


class Terminated(KeyboardInterrupt):
    """A request to end (SIGTERM, or SIGHUP: the terminal was closed); handled as Ctrl-C is.

    So the arm is stopped.

    Args:
        number: the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def say_error(told: object, at: str = "") -> None:
    """Print an error or advice of the robot, with commands (for the arm `at`) for functions."""
    from aioduco.cli.command_terms import in_commands  # noqa: PLC0415 - quick stop

    say(in_commands(told, at), error=True)


def fail(message: object, code: int = FAILED) -> NoReturn:
    """End the command with a message on the standard error, and an exit code."""
    import typer  # noqa: PLC0415 - not for `aioduco stop`, which is to be quick

    say_error(message)
    raise typer.Exit(code)


def cannot_listen(where: str, error: OSError) -> NoReturn:
    """End the command, which serves on a port that is taken or not allowed."""
    fail(f"cannot listen on {where}: {error.strerror or error}")


@contextmanager
def failing(*kinds: type[Exception], code: int = FAILED) -> Iterator[None]:
    """End the command on errors of these kinds, with their message."""
    import typer  # noqa: PLC0415 - not for `aioduco stop`, which is to be quick

    try:
        yield
    except typer.Exit:  # a RuntimeError, of which the message is told already
        raise
    except kinds as error:
        fail(error, code)


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """End the command if a file that an option names cannot be written in the block."""
    try:
        yield
    except OSError as error:
        fail(f"{path} cannot be written: {error.strerror or error}", USAGE)


def write_file(path: Path, text: str, errors: str = "strict") -> None:
    """Write a text to a file that an option names; end the command if that is not possible."""
    from aioduco.models.whole_files import write_whole  # noqa: PLC0415 - quick help

    with writing(path):
        write_whole(path, text, errors)


@contextmanager
def ended_by_errors(interrupted: str = "interrupted", at: str = "") -> Iterator[None]:
    """End the command on an error or a signal, with a message and an exit code.

    Args:
        interrupted: message after Ctrl-C, SIGTERM or SIGHUP.
        at: address of the arm, for the commands that the message, and log messages, name.
    """
    from aioduco.cli.signals import handled, termination_signals  # noqa: PLC0415 - quick help
    from aioduco.errors import (  # noqa: PLC0415 - quick help
        CellFileError,
        DucoError,
        ParameterError,
        PersonNeeded,
        SceneError,
        StopUnconfirmed,
        WaypointFileError,
    )

    told = signal.SIGINT.value
    if at:
        log_about(at)

    def terminate(number: int, frame: FrameType | None) -> None:
        nonlocal told
        on_interrupt = signal.getsignal(signal.SIGINT)
        if on_interrupt is signal.default_int_handler or not callable(on_interrupt):
            raise Terminated(number)
        # An event loop runs here: as on Ctrl-C it cancels the program, which leaves its robot.
        told = number
        on_interrupt(signal.SIGINT, frame)

    with handled(termination_signals(), terminate):
        try:
            yield
        except StopUnconfirmed as error:
            say_error(error, at)
            code = STOP_UNCONFIRMED
        except PersonNeeded as error:
            say_error(error, at)
            code = PERSON_NEEDED
        # of an option or argument, or a file that one names; nothing was sent
        except (ParameterError, CellFileError, SceneError, WaypointFileError) as error:
            say_error(error, at)
            code = USAGE
        except (DucoError, OSError) as error:  # an OSError: of a file
            say_error(error, at)
            code = FAILED
        except KeyboardInterrupt as end:
            say(interrupted, error=True)
            code = SIGNALLED + (end.number if isinstance(end, Terminated) else told)
        else:
            return
    raise SystemExit(code)
