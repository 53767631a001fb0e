"""A row of signals or registers of one kind (manual 1.3.7)."""

from __future__ import annotations

from typing import Generic, TypeVar

__all__ = ["Bank"]

T = TypeVar("T")


class Bank(Generic[T]):
    """Signals of one kind, numbered from 1 as in the manual.

    One element is read and written at once, so readers need no lock.
    """

    __slots__ = ("_values", "_zero")

    def __init__(self, size: int, zero: T) -> None:
        self._zero = zero
        self._values = [zero] * size

    def __len__(self) -> int:
        return len(self._values)

    def __contains__(self, num: int) -> bool:
        """Whether there is a signal of this number."""
        return 1 <= num <= len(self._values)

    def __getitem__(self, num: int) -> T:
        """One signal; zero for a number that does not exist, as the manual says (1.3.7)."""
        return self._values[num - 1] if num in self else self._zero

    def __setitem__(self, num: int, value: T) -> None:
        if num not in self:
            raise IndexError(f"there is no signal {num}; there are 1 to {len(self._values)}")
        self._values[num - 1] = value

    def all(self) -> list[T]:
        """Every signal, a copy."""
        return self._values.copy()
