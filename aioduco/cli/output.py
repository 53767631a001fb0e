"""What commands print: lines, and results in the types of JSON, for `--json`.

Texts of the other side (a controller, a gateway, a recording) may contain what a terminal carries
out: titles, the clipboard, erased lines, a reversed order. Every text passes `shown` before it is
printed: by `say`, by `SafeConsole`, and, after `guard_streams`, in log messages and tracebacks.
"""

from __future__ import annotations

import errno
import io
import json
import logging
import os
import sys
import unicodedata
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

from aioduco.models.numpy_on_use import json_value

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import TracebackType


class OutputFailed(Exception):
    """The standard output cannot be written: its disk is full, or nobody reads it any more.

    No `OSError`: commands take those for failures of the files and ports that they use.

    Args:
        error: the failure.
    """

    def __init__(self, error: OSError) -> None:
        super().__init__(f"the output cannot be written: {error.strerror or error}")
        self.error = error


#: descriptors of the standard output and the standard error
_OUTPUT, _LAST_STREAM = 1, 2
#: errors of a write to a full disk, a closed terminal, a pipe that nobody reads, a closed output
_UNWRITABLE: Final = {
    errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EPIPE, errno.EBADF
}  # fmt: skip


def shown(text: str) -> str:
    """A text as a terminal may show it: line ends and tabs stay, other controls are spelled out.

    Controls are those that `str.isprintable` refuses: C0 and C1, changes of direction, invisible
    characters, halves of surrogate pairs. Spaces of all widths stay.
    """
    if text.isprintable():
        return text
    return "".join(
        each if each.isprintable() or each in "\n\t" or unicodedata.category(each) == "Zs"
        else each.encode("unicode_escape").decode("ascii")
        for each in text
    )  # fmt: skip


def one_line(text: str) -> str:
    """A text of the other side that is part of a line: it makes no further lines."""
    return shown(text).replace("\n", "\\n").replace("\t", " ")


def say(text: object = "", *, error: bool = False, end: str = "\n") -> None:
    """Print a line to the standard output, or to the standard error.

    A standard error that cannot be written, as of a closed terminal, ends no command: the exit code
    still says how it ended.

    Raises:
        OutputFailed: the standard output cannot be written.
    """
    line = shown(str(text))
    if not error:
        with written():
            print(line, end=end, flush=True)
    elif sys.stderr is not None:
        with suppress(OSError):
            print(line, end=end, file=sys.stderr, flush=True)


@contextmanager
def written() -> Iterator[None]:
    """Raise `OutputFailed` if what is printed in the block cannot be written."""
    try:
        yield
    except OSError as error:
        raise OutputFailed(error) from error


@contextmanager
def ended_by_output() -> Iterator[None]:
    """End the command with 1 if its output cannot be written, and say why.

    It says nothing if whoever read the output has ended, as `head` does.
    """
    failed: BaseException | None = None
    try:
        try:
            yield
        except OSError as error:  # the help is printed by other means
            if error.errno not in _UNWRITABLE:
                raise
            raise OutputFailed(error) from error
    except* OutputFailed as group:
        failed = group
    if failed is None:
        return
    while isinstance(failed, BaseExceptionGroup):
        failed = failed.exceptions[0]
    assert isinstance(failed, OutputFailed)
    if not isinstance(failed.error, BrokenPipeError):
        say(failed, error=True)
    raise SystemExit(1)


def drop_unwritten() -> None:
    """Drop what the standard streams have not taken yet and cannot take, as of a closed terminal.

    Otherwise Python tries again at its end, and replaces the exit code by its own, 120.
    """
    for stream in filter(None, (sys.stdout, sys.stderr)):
        try:
            stream.flush()
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


class _ShownFormatter(logging.Formatter):
    """Log messages without control characters, with commands in place of the robot's functions.

    Args:
        at: address of the arm that they are about, as of `commands`.
    """

    def __init__(self, at: str = "") -> None:
        super().__init__()
        self._at = at

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - of the base class
        from aioduco.cli.command_terms import in_commands  # noqa: PLC0415 - quick stop

        return in_commands(super().formatMessage(record), self._at)

    def format(self, record: logging.LogRecord) -> str:
        return shown(super().format(record))


def guard_streams() -> None:
    """Let warnings of the library, and the traceback that ends the program, pass `shown`, too.

    What the encoding of an output lacks, such as Chinese in a file of Windows, is spelled out; what
    is typed in another encoding is taken, and refused as a name. Streams that are closed become
    empty ones.
    """
    _open_closed_streams()
    if isinstance(sys.stdin, io.TextIOWrapper):
        sys.stdin.reconfigure(errors="surrogateescape")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    log_about("")
    sys.excepthook = _say_traceback


def log_about(at: str) -> None:
    """Let log messages name commands for the arm at this address, as of `commands`."""
    if logging.lastResort is not None:
        logging.lastResort.setFormatter(_ShownFormatter(at))


def _open_closed_streams() -> None:
    """Open the standard streams that are closed, as a daemon's may be.

    Otherwise a socket takes such a number, and a process of this package takes it for its stream.
    A result that is written to a closed output fails, as with other commands; a message does not.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= _LAST_STREAM:
        if descriptor == _OUTPUT:
            os.close(descriptor)
            os.open(os.devnull, os.O_RDONLY)
        os.set_inheritable(descriptor, True)
    os.close(descriptor)
    if sys.stdin is None:
        sys.stdin = open(0, closefd=False)  # noqa: SIM115 - until the end
    if sys.stdout is None:
        sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115


def _say_traceback(
    kind: type[BaseException], error: BaseException, where: TracebackType | None
) -> None:
    if issubclass(kind, KeyboardInterrupt):  # while a command was loaded: it had done nothing
        say("interrupted", error=True)
        return
    import traceback  # noqa: PLC0415 - for a program that fails

    say("".join(traceback.format_exception(kind, error, where)).rstrip("\n"), error=True)


def print_json(value: Any) -> None:
    """Print a result as one line of JSON."""
    say(json.dumps(json_value(value), allow_nan=False))
