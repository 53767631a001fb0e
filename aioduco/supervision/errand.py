"""Something that blocks, done on a thread of its own and awaited.

Not `anyio.to_thread`: a program whose event loop was broken, by the third Ctrl-C for instance,
waits at its end for the threads of that, and never ends. Here they are daemons. Besides, what was
begun can be waited for again after a cancellation, so that nothing of it is lost.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Generic, TypeVar

import anyio

from aioduco._wire.handoff import doorbell
from aioduco.supervision.insist import insist

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["see_done"]

T = TypeVar("T")


class _Errand(Generic[T]):
    """Work that is done on a thread from now on."""

    def __init__(self, work: Callable[[], T]) -> None:
        self._work = work
        self._results: list[T] = []
        self._error: BaseException | None = None
        self._over = anyio.Event()
        self._ring = doorbell(self._over.set)
        threading.Thread(target=self._run, name="aioduco-errand", daemon=True).start()

    def _run(self) -> None:
        try:
            self._results.append(self._work())
        except BaseException as exc:
            # belongs to whoever waits
            self._error = exc
        self._ring()

    async def wait(self) -> T:
        await self._over.wait()
        if self._error is not None:
            raise self._error
        return self._results[0]


async def see_done(work: Callable[[], T]) -> tuple[T, BaseException | None]:
    """Do something that blocks, to its end even if this is cancelled.

    Args:
        work: called on a thread of its own; it must end by itself.

    Returns:
        Its result, and the last cancellation that came meanwhile: the caller must raise it.
    """
    return await insist(_Errand(work).wait)
