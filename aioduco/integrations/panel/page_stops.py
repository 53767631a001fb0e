"""The stops that pages ask for.

Guarantees:
- A stop waits for no other request of a page.
- A flood of stops is few of them: one that comes while several are under way is sent after the
  first of these, once for all that come until then.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import anyio

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from anyio.abc import TaskGroup


#: number of stops that are sent or confirmed at a time; further ones are joined
_MOST: Final = 4


class _Stopping:
    """One stop that pages asked for, and how it ended."""

    def __init__(self) -> None:
        self.over: anyio.Event = anyio.Event()
        self.failed: str = ""

    def end(self, failed: str) -> None:
        self.failed = failed
        self.over.set()


class PageStops:
    """Sends the stops that pages ask for.

    Args:
        stop: stops the arm, and waits until it stands; returns the reason if that is not known.
        begun: called when a stop is asked for.
        ended: called when one is over, with the reason if it failed.

    Attributes:
        tasks: where stops run; None while there is no controller to send them to.
    """

    def __init__(
        self,
        stop: Callable[[], Awaitable[str]],
        begun: Callable[[], object],
        ended: Callable[[str], object],
    ) -> None:
        self._stop = stop
        self._begun = begun
        self._ended = ended
        self.tasks: TaskGroup | None = None
        self._sent: set[_Stopping] = set()
        self._next: _Stopping | None = None

    def __bool__(self) -> bool:
        """Whether a stop is under way."""
        return bool(self._sent)

    async def carry_out(self) -> str:
        """A request without a page asks for a stop; returns the reason if that failed."""
        stopping = self.begin()
        await stopping.over.wait()
        return stopping.failed

    async def over(self) -> None:
        """Wait for the ends of the stops that have been sent."""
        for stopping in tuple(self._sent):
            await stopping.over.wait()

    def begin(self) -> _Stopping:
        """A page asks for a stop."""
        if self._next is not None:
            return self._next
        stopping = _Stopping()
        if self.tasks is None:
            stopping.end("the panel is not connected")
            return stopping
        if len(self._sent) < _MOST:
            self._send(self.tasks, stopping)
        else:
            self._next = stopping
        self._begun()
        return stopping

    def _send(self, tasks: TaskGroup, stopping: _Stopping) -> None:
        self._sent.add(stopping)
        tasks.start_soon(self._run, tasks, stopping)

    async def _run(self, tasks: TaskGroup, stopping: _Stopping) -> None:
        failed = "the stop was not carried out"
        try:
            # a stop that was sent runs to its end, also if the panel ends
            with anyio.CancelScope(shield=True):
                failed = await self._stop()
        finally:
            self._sent.remove(stopping)
            stopping.end(failed)
            after, self._next = self._next, None
            if after is not None:
                self._send(tasks, after)
            self._ended(failed)
