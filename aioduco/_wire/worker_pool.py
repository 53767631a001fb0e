"""Which call gets which connection: decided at once, without I/O, threads or clock."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


class Claimable(Protocol):
    """Something that one call at a time can have."""

    def claim(self, call: object) -> bool:
        """Take it for a call if it is free, or that call's already; never waits."""
        ...


class Refusable(Protocol):
    """A call that may not be wanted any more when its turn comes."""

    @property
    def refused(self) -> bool:
        """Whether no task waits for it any more."""
        ...


W = TypeVar("W", bound=Claimable)
C = TypeVar("C", bound=Refusable)


class WorkerPool(Generic[W, C]):
    """Hands claimed workers to waiting calls, in the order in which the calls came.

    Guarantees: no more than `size` workers; no worker for a call that is refused; no call waits
    while a worker is free, once `assign` has been called. Workers are tried in the order in
    which they were made, so a light load keeps to few connections.

    Args:
        size: most workers.
        make: makes a worker; called when all others are taken.
    """

    def __init__(self, size: int, make: Callable[[], W]) -> None:
        self.size = size
        self._make = make
        self.workers: list[W] = []
        self._waiting: deque[C] = deque()

    @property
    def waiting(self) -> int:
        """Calls that wait for a worker."""
        return len(self._waiting)

    def take(self, call: C) -> W | None:
        """A free worker for a new call, claimed now; None if the call has to wait."""
        worker = None if self._waiting else self._free(call)
        if worker is None:
            self._waiting.append(call)
        return worker

    def forget(self, call: C) -> bool:
        """Take a call out of the queue; whether it was still in it."""
        try:
            self._waiting.remove(call)
        except ValueError:
            return False
        return True

    def assign(self) -> Iterator[tuple[W, C]]:
        """Every pair of a free worker, claimed now, and the call that it is for."""
        while self._waiting:
            if self._waiting[0].refused:
                self._waiting.popleft()
                continue
            worker = self._free(self._waiting[0])
            if worker is None:
                return
            yield worker, self._waiting.popleft()

    def discard(self, worker: W) -> bool:
        """Forget a worker, so that a new one can take its place; whether it was here."""
        if worker not in self.workers:
            return False
        self.workers.remove(worker)
        return True

    def drain(self) -> list[C]:
        """Empty the queue; the calls that were in it."""
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
