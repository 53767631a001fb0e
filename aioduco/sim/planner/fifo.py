"""Queues of points that clients fill while the arm moves: bounded, first in, first out."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["CAPACITY", "Fifo", "Pool"]

CAPACITY = 1000
"""Points that fit: into the track pool by manual 1.3.12, into others by assumption."""

T = TypeVar("T")


class Fifo(Generic[T]):
    """A queue that takes all points of a call or none."""

    def __init__(self) -> None:
        self._points: deque[T] = deque()

    def __len__(self) -> int:
        return len(self._points)

    def put(self, points: Iterable[T]) -> bool:
        """Put all of them in, or none if they do not fit; whether they did."""
        new = list(points)
        if len(self._points) + len(new) > CAPACITY:
            return False
        self._points.extend(new)
        return True

    def clear(self) -> None:
        """Drop all."""
        self._points.clear()

    def first(self) -> T | None:
        """The next point, which stays."""
        return self._points[0] if self._points else None

    def take(self) -> T | None:
        """The next point; None when there is none."""
        return self._points.popleft() if self._points else None


class Pool(Fifo[tuple[tuple[float, ...], Any]]):
    """The track pool (轨迹池): points, each with what is to happen there, or None.

    Attributes:
        taken: points that have left it at its front, or were dropped.
        cleared: how often it was emptied.
    """

    def __init__(self) -> None:
        super().__init__()
        self.taken: int = 0
        self.cleared: int = 0

    def clear(self) -> None:
        """Drop all."""
        self.taken += len(self)
        self.cleared += 1
        super().clear()

    def get(self, number: int) -> tuple[tuple[float, ...], Any] | None:
        """The point of a number, counted from the very first; None if there is none yet."""
        index = number - self.taken
        return self._points[index] if index < len(self) else None

    def take_to(self, number: int) -> None:
        """The point of a number, and any before it, leave the pool."""
        while self.taken <= number and self.take() is not None:
            self.taken += 1
