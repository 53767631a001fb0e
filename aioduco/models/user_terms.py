"""Texts for those who do not call the robot in Python, but by services, commands or buttons.

Errors and advice say what to do in the terms of `Robot`: `call robot.recover()`. Who reads them by
ROS, on the command line or in the panel is told the service, the command or the button instead.
"""

from __future__ import annotations

import logging
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

#: a function of the robot or of a section of it; or the call of one alone, as in `recover()`
_FUNCTION = re.compile(r"\brobot\.(?:\w+\.)?(\w+)(?:\(\))?|(?<![\w.])(\w+)\(\)")


def in_terms_of(names: Mapping[str, str], text: str) -> str:
    """Return a text with these names in place of functions of the robot.

    Args:
        names: for each function, by its name, what stands in its place; others stay.
        text: the text of an error, or advice.
    """

    def name(found: re.Match[str]) -> str:
        return names.get(found[1] or found[2], found[0])

    told = _FUNCTION.sub(name, text)
    for each in set(names.values()):  # two functions may be one service
        told = told.replace(f"{each} or {each}", each)
    return told


class TermsFormatter(logging.Formatter):
    """Formats log messages in the terms of their reader; tracebacks stay as they are.

    Args:
        told: returns a text in these terms.
    """

    def __init__(self, told: Callable[[str], str]) -> None:
        super().__init__()
        self._told = told

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - of the base class
        """Format the message without its traceback."""
        return self._told(super().formatMessage(record))
