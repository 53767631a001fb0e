"""One running and one waiting goal; a newer goal replaces an older one."""

from __future__ import annotations

from typing import Generic, TypeVar

G = TypeVar("G")


class GoalQueue(Generic[G]):
    """Decides which goal runs; the arm carries out one at a time.

    Attributes:
        running: the goal that the arm carries out; None for none.
        waiting: the goal that comes after it; None for none.
    """

    def __init__(self) -> None:
        self.running: G | None = None
        self.waiting: G | None = None

    @property
    def superseded(self) -> bool:
        """Whether the running goal must end for the waiting one."""
        return self.running is not None and self.waiting is not None

    def submit(self, goal: G) -> G | None:
        """Add a new goal, and return the waiting goal that it replaces."""
        dropped, self.waiting = self.waiting, goal
        return dropped

    def withdraw(self, goal: G) -> bool:
        """Drop a goal if it is waiting; return whether it was."""
        if self.waiting is not goal:
            return False
        self.waiting = None
        return True

    def begin(self) -> G | None:
        """Start the waiting goal, if there is one and none is running."""
        if self.running is None:
            self.running, self.waiting = self.waiting, None
            return self.running
        return None

    def take_over(self) -> G:
        """Let the waiting goal take the place of the running one."""
        assert self.waiting is not None
        self.running, self.waiting = self.waiting, None
        return self.running

    def end(self) -> None:
        """The running goal has ended, with any result; the arm stands."""
        self.running = None
