"""Which threads of the program are heard of: without a thread or a clock."""

from __future__ import annotations

__all__ = ["Presence"]


class Presence:
    """Keeps for each thread whether it is in a call, and when it left the last one.

    A thread writes only its own entries, so that no lock is needed.
    """

    def __init__(self) -> None:
        self._inside: dict[int, int] = {}
        self._left: dict[int, float] = {}

    def enter(self, thread: int) -> None:
        """A thread begins a call."""
        self._inside[thread] = self._inside.get(thread, 0) + 1

    def leave(self, thread: int, now: float) -> None:
        """A thread's call is over."""
        self._left[thread] = now
        self._inside[thread] -= 1

    def silence(self, thread: int, now: float) -> float:
        """How long a thread has not been heard of [s]; 0.0 while it is in a call."""
        if self._inside.get(thread):
            return 0.0
        return now - self._left.get(thread, now)
