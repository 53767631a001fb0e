"""Versions of the controller's software."""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["ControllerVersion"]

_NUMBERS = re.compile(r"\d+(?:\.\d+)*")


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
