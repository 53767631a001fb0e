"""What waits for a subscriber: the policies, without a clock or an event loop."""

from __future__ import annotations

from collections import deque
from typing import Generic, Literal, TypeAlias, TypeVar

from aioduco.errors import FeedOverflow, ParameterError

__all__ = ["Buffer", "Policy"]

Policy: TypeAlias = Literal["latest", "drop_oldest", "every"]

T = TypeVar("T")


class Buffer(Generic[T]):
    """Items between one who gives and one who takes.

    Args:
        policy: what happens to items that are not taken in time. "latest": a new one takes the
            place of the one before. "drop_oldest": the oldest goes when `size` are waiting.
            "every": none goes; when `size` are waiting, taking raises `FeedOverflow` after the
            last of them, so that a gap is never passed off as a whole.
        size: most items that wait; with "latest" it is one.

    Attributes:
        dropped: items that were never taken and went.
    """

    def __init__(self, policy: Policy, size: int) -> None:
        if policy not in ("latest", "drop_oldest", "every"):
            raise ParameterError("policy", policy, '"latest", "drop_oldest" or "every"')
        if type(size) is not int or size < 1:
            raise ParameterError("size", size, "a whole number from 1")
        self.policy = policy
        self.size: int = 1 if policy == "latest" else size
        self.dropped: int = 0
        self._items: deque[T] = deque()
        self._overflown = False

    def __len__(self) -> int:
        return len(self._items)

    @property
    def ready(self) -> bool:
        """Whether taking gives something, or raises."""
        return bool(self._items) or self._overflown

    def put(self, item: T) -> None:
        """Give an item."""
        if len(self._items) == self.size:
            self.dropped += 1
            if self.policy == "every":
                self._overflown = True
                return
            self._items.popleft()
        elif self._overflown:
            # after a gap nothing is taken up again until the subscriber has heard of it
            self.dropped += 1
            return
        self._items.append(item)

    def take(self) -> T:
        """Take the oldest item.

        Raises:
            FeedOverflow: items went missing here. Taking goes on behind the gap afterwards.
            IndexError: nothing waits.
        """
        if self._items:
            return self._items.popleft()
        if self._overflown:
            self._overflown = False
            raise FeedOverflow(
                f"more than {self.size} items waited, and {self.dropped} were dropped: take them "
                "faster, ask for a larger size, or choose another policy"
            )
        raise IndexError("nothing waits")
