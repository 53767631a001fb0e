"""How long each thread of the program has made no call. It has no thread and no clock."""

from __future__ import annotations

__all__ = ["CallTimes"]


class CallTimes:
    """Stores for each thread whether it is in a call, and when its last call ended.

    A thread writes only its own entries, so no lock is needed.
    """

    def __init__(self) -> None:
        self._inside: dict[int, int] = {}
        self._left: dict[int, float] = {}

    def enter(self, thread: int) -> None:
        """Note that a thread begins a call."""
        self._inside[thread] = self._inside.get(thread, 0) + 1

    def leave(self, thread: int, now: float) -> None:
        """Note that a thread's call has ended."""
        self._left[thread] = now
        self._inside[thread] -= 1

    def idle_time(self, thread: int, now: float) -> float:
        """Time since a thread's last call ended [s]; 0.0 while it is in a call."""
        if self._inside.get(thread):
            return 0.0
        return now - self._left.get(thread, now)
