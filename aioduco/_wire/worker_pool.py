"""Assignment of connections to calls, without waiting, I/O, threads or clock."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


class Claimable(Protocol):
    """An object that one call at a time can claim."""

    def claim(self, call: object) -> bool:
        """Claim it for a call, if it is free or already claimed for that call; never waits."""
        ...


class Settleable(Protocol):
    """A call that may no longer be needed when a worker is free."""

    @property
    def settled(self) -> bool:
        """Whether no task waits for it any more."""
        ...


W = TypeVar("W", bound=Claimable)
C = TypeVar("C", bound=Settleable)


class WorkerPool(Generic[W, C]):
    """Assigns claimed workers to waiting calls, in the order of the calls.

    Guarantees: no more than `size` workers; no worker for a call that is settled; no call waits
    while a worker is free, once `assign` has been called. Workers are tried in the order in which
    they were made, so a light load uses few connections.

    Args:
        size: maximum number of workers.
        make: function that makes a worker; called when all others are in use.
    """

    def __init__(self, size: int, make: Callable[[], W]) -> None:
        self.size = size
        self._make = make
        self.workers: list[W] = []
        self._waiting: deque[C] = deque()

    @property
    def waiting(self) -> int:
        """Number of calls that wait for a worker."""
        return len(self._waiting)

    def take(self, call: C) -> W | None:
        """Claim a free worker for a new call; queue the call and return None if there is none."""
        worker = None if self._waiting else self._free(call)
        if worker is None:
            self._waiting.append(call)
        return worker

    def forget(self, call: C) -> bool:
        """Remove a call from the queue; return whether it was still there."""
        try:
            self._waiting.remove(call)
        except ValueError:
            return False
        return True

    def assign(self) -> Iterator[tuple[W, C]]:
        """Claim free workers for waiting calls; yield each worker with its call."""
        while self._waiting:
            if self._waiting[0].settled:
                self._waiting.popleft()
                continue
            worker = self._free(self._waiting[0])
            if worker is None:
                return
            yield worker, self._waiting.popleft()

    def discard(self, worker: W) -> bool:
        """Remove a worker, so that a new one can replace it; return whether it was in the pool."""
        if worker not in self.workers:
            return False
        self.workers.remove(worker)
        return True

    def drain(self) -> list[C]:
        """Empty the queue; return the calls that were in it."""
        left = list(self._waiting)
        self._waiting.clear()
        return left

    def _free(self, call: C) -> W | None:
        for worker in self.workers:
            if worker.claim(call):
                return worker
        if len(self.workers) < self.size:
            worker = self._make()
            self.workers.append(worker)
            if worker.claim(call):
                return worker
        return None
