"""Base of what `with` and `async with` start and close: a simulator here or in another process."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

import anyio
import anyio.to_thread

from aioduco._process.copying import Uncopied

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

__all__ = ["Startable"]


class Startable(Uncopied):
    """Starts on entry, and closes on exit; asynchronously in a thread, as both take a while."""

    @abstractmethod
    def start(self) -> Self:
        """Start it, and return it."""

    @abstractmethod
    def close(self) -> None:
        """End it, and wait until it has ended."""

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    async def __aenter__(self) -> Self:
        return await anyio.to_thread.run_sync(self.start)

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        with anyio.CancelScope(shield=True):
            await anyio.to_thread.run_sync(self.close)
