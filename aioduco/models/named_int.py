"""An integer of the wire that a person reads by its name."""

from __future__ import annotations

from enum import IntEnum

#: presentations of numbers in a format specification
_OF_NUMBERS = tuple("bcdoxXneEfFgG%")


class NamedInt(IntEnum):
    """An integer that is printed by its name: `TaskState.FINISHED` as FINISHED, not as 4."""

    def __str__(self) -> str:
        return self._name_

    def __format__(self, spec: str) -> str:
        """As the name; as the number with a presentation of numbers, such as `d`."""
        return format(int(self), spec) if spec[-1:] in _OF_NUMBERS else format(str(self), spec)
