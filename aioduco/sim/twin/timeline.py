"""Orders samples and commands, which arrive by different ways, by their times."""

from __future__ import annotations

import heapq
import itertools
from typing import TYPE_CHECKING, TypeAlias

from aioduco.sim.twin.data import TwinCommand, TwinSample
from aioduco.sim.twin.predictor import AHEAD

if TYPE_CHECKING:
    from collections.abc import Iterator


Item: TypeAlias = TwinSample | TwinCommand

#: time for which samples are held back, so that commands of before can arrive [s]
HELD = AHEAD + 0.03


class Timeline:
    """Holds samples and commands back for a moment, and gives them in order.

    A command counts `AHEAD` before its time: a rehearsal that is behind the arm could not say where
    the arm should be.
    """

    def __init__(self) -> None:
        self._waiting: list[tuple[float, int, Item]] = []
        self._count = itertools.count()
        self._newest = 0.0

    def put(self, item: Item) -> None:
        """Add a sample or a command, in any order."""
        at = item.time
        if isinstance(item, TwinCommand):
            at -= AHEAD
        else:
            self._newest = max(self._newest, at)
        heapq.heappush(self._waiting, (at, next(self._count), item))

    def due(self) -> Iterator[Item]:
        """Take what came so long before the newest sample that nothing earlier can arrive."""
        while self._waiting and self._waiting[0][0] <= self._newest - HELD:
            yield heapq.heappop(self._waiting)[2]

    def rest(self) -> Iterator[Item]:
        """Take all that is left, in order."""
        while self._waiting:
            yield heapq.heappop(self._waiting)[2]
