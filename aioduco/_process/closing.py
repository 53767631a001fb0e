"""What `with` and `async with` close, such as a process that this program has started."""

from __future__ import annotations

from abc import abstractmethod
from typing import Self

import anyio

from aioduco._process.copying import Uncopied
from aioduco._process.threads import in_thread


class Closable(Uncopied):
    """Closes on exit; asynchronously in a thread, as it takes a while."""

    @abstractmethod
    def close(self) -> None:
        """End it, and wait until it has ended."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        with anyio.CancelScope(shield=True):
            await in_thread(self.close)


class Startable(Closable):
    """Also starts on entry; asynchronously in a thread, too."""

    @abstractmethod
    def start(self) -> Self:
        """Start it, and return it."""

    def __enter__(self) -> Self:
        return self.start()

    async def __aenter__(self) -> Self:
        return await in_thread(self.start)
