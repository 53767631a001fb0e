"""How long each thread of the program has made no call. It has no clock."""

from __future__ import annotations

import threading


class CallRecord:
    """Of the calls of one thread, which alone changes this: is it in one, when did one end."""

    __slots__ = ("_inside", "_left")

    def __init__(self) -> None:
        self._inside = 0
        self._left: float | None = None

    def enter(self) -> None:
        """Note that the thread begins a call."""
        self._inside += 1

    def leave(self, now: float) -> None:
        """Note that the thread's call has ended."""
        self._left = now
        self._inside -= 1

    def idle_time(self, now: float) -> float:
        """Time since the thread's last call ended [s]; 0.0 while it is in a call."""
        if self._inside or self._left is None:
            return 0.0
        return now - self._left


class CallTimes(threading.local):
    """The calls of the thread that reads it.

    Not by the thread's number: the system gives the number of a thread that has ended to a later
    one, whose calls would then count as those of the thread before it.
    """

    def __init__(self) -> None:
        self.here: CallRecord = CallRecord()
