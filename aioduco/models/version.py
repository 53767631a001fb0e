"""Versions of the controller's software."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

Manual: TypeAlias = Literal["3.8", "4.3"]

_NUMBERS = re.compile(r"\d+(?:\.\d+)*")
#: a number alone may belong to a name, as in "GCR5-910"; one after a dot is part of another
_DOTTED = re.compile(r"(?<![\d.])(\d+)\.(\d+)(?:\.\d+)*")
#: versions whose behaviour one of the two manuals describes, as (first, last)
_OLDER: Final = ((1, 0), (3, 8))
_NEWER: Final = ((4, 3), (99, 0))


@dataclass(frozen=True, slots=True)
class ControllerVersion:
    """A version of the controller's software (控制器版本).

    Versions are ordered by their numbers; an unknown version comes before all others.

        if robot.version.controller.at_least(3, 4, 1): ...

    Attributes:
        text: version text from the controller; empty if the controller sends none.
    """

    text: str

    @property
    def numbers(self) -> tuple[int, ...]:
        """The first numbers in the text that are separated by dots: 3, 4, 1 in "V3.4.1-r2"."""
        found = _NUMBERS.search(self.text)
        return tuple(map(int, found[0].split("."))) if found else ()

    @property
    def known(self) -> bool:
        """Whether the text contains numbers."""
        return bool(self.numbers)

    @property
    def manual(self) -> Manual | None:
        """The manual whose meanings this version follows; None if that cannot be told.

        The manuals of 3.8 and 4.3 contradict each other, in the directions of a jog among others.
        It is inferred that versions up to 3.8 follow the one, and those from 4.3 the other. A
        version between them, a date, and a text without one version number tell nothing.
        """
        found = {(int(major), int(minor)) for major, minor in _DOTTED.findall(self.text)}
        if found and all(_OLDER[0] <= each <= _OLDER[1] for each in found):
            return "3.8"
        if found and all(_NEWER[0] <= each <= _NEWER[1] for each in found):
            return "4.3"
        return None

    def at_least(self, *numbers: int) -> bool:
        """Whether it is this version or a later one; false if it is unknown."""
        return self._padded(len(numbers)) >= numbers if self.known else False

    def __lt__(self, other: ControllerVersion) -> bool:
        length = max(len(self.numbers), len(other.numbers))
        return self._padded(length) < other._padded(length)

    def __le__(self, other: ControllerVersion) -> bool:
        return not other < self

    def __gt__(self, other: ControllerVersion) -> bool:
        return other < self

    def __ge__(self, other: ControllerVersion) -> bool:
        return not self < other

    def __str__(self) -> str:
        return self.text or "unknown"

    def _padded(self, length: int) -> tuple[int, ...]:
        """Return the numbers, 3.4 as 3.4.0; those of an unknown version are below all others."""
        if not self.known:
            return (-1,)
        return self.numbers + (0,) * (length - len(self.numbers))
