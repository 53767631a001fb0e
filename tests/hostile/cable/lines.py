"""What the processes of a run write: one JSON object a line, with the time."""

from __future__ import annotations

import json
import sys
import time
from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class Line:
    """Something that happened in a process.

    Attributes:
        at: when, by the clock that all processes of a machine share, `time.monotonic()` [s].
        what: the kind of event.
        text: what is to be known about it.
    """

    at: float
    what: str
    text: str = ""


def say(what: str, text: str = "", at: float | None = None) -> None:
    """Write a line to the standard output; `at` is now unless given."""
    line = Line(time.monotonic() if at is None else at, what, text)
    sys.stdout.write(json.dumps(asdict(line)) + "\n")
    sys.stdout.flush()


def parse(text: str) -> Line:
    """The line that `say` wrote."""
    return Line(**json.loads(text))
