"""What commands print: lines, and results in the types of JSON, for `--json`.

Texts of the other side (a controller, a gateway, a recording) may contain what a terminal carries
out: titles, the clipboard, erased lines, a reversed order. Every text passes `shown` before it is
printed: by `say`, by `SafeConsole`, and, after `guard_streams`, in log messages and tracebacks.
"""

from __future__ import annotations

import dataclasses
import enum
import io
import json
import logging
import math
import sys
import unicodedata
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from types import TracebackType

__all__ = ["guard_streams", "one_line", "plain", "print_json", "say", "shown"]


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
    """Print a line to the standard output, or to the standard error."""
    print(shown(str(text)), end=end, file=sys.stderr if error else sys.stdout, flush=True)


class _ShownFormatter(logging.Formatter):
    """Log messages without control characters."""

    def format(self, record: logging.LogRecord) -> str:
        return shown(super().format(record))


def guard_streams() -> None:
    """Let warnings of the library, and the traceback that ends the program, pass `shown`, too.

    What the encoding of an output lacks, such as Chinese in a file of Windows, is spelled out.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    if logging.lastResort is not None:
        logging.lastResort.setFormatter(_ShownFormatter())
    sys.excepthook = _say_traceback


def _say_traceback(
    kind: type[BaseException], error: BaseException, where: TracebackType | None
) -> None:
    import traceback  # noqa: PLC0415 - for a program that fails

    say("".join(traceback.format_exception(kind, error, where)).rstrip("\n"), error=True)


def plain(value: Any) -> Any:
    """A result in the types of JSON; NaN and infinities become None."""
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, str | int | bool | None):
        return value
    return _parts(value)


def _parts(value: Any) -> Any:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = [field.name for field in dataclasses.fields(value)]
        return {name: plain(getattr(value, name)) for name in names}
    if callable(
        tolist := getattr(value, "tolist", None)
    ):  # a NumPy value; NumPy is not loaded here
        return plain(tolist())
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(each) for each in value]
    return str(value)


def print_json(value: Any) -> None:
    """Print a result as one line of JSON."""
    say(json.dumps(plain(value), allow_nan=False))
