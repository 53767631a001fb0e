"""Which goal runs and which waits: one of each, and the newest goal counts."""

from __future__ import annotations

from typing import Generic, TypeVar

__all__ = ["GoalQueue"]

G = TypeVar("G")


class GoalQueue(Generic[G]):
    """Decides over goals; the arm carries out one at a time.

    Attributes:
        running: the goal that the arm carries out; None for none.
        waiting: the goal that comes after it; None for none.
    """

    def __init__(self) -> None:
        self.running: G | None = None
        self.waiting: G | None = None

    @property
    def superseded(self) -> bool:
        """Whether the running goal is to end for the waiting one."""
        return self.running is not None and self.waiting is not None

    def submit(self, goal: G) -> G | None:
        """Take a new goal, and give back the one that waited, which is dropped."""
        dropped, self.waiting = self.waiting, goal
        return dropped

    def withdraw(self, goal: G) -> bool:
        """Drop a goal if it waits. Tells whether it did."""
        if self.waiting is not goal:
            return False
        self.waiting = None
        return True

    def begin(self) -> G | None:
        """Let the waiting goal run, if there is one and none runs."""
        if self.running is None:
            self.running, self.waiting = self.waiting, None
            return self.running
        return None

    def end(self) -> None:
        """The running goal has ended, however it did; the arm stands."""
        self.running = None
