"""Viser without a port of its own: its pages come through the panel's.

Viser's server takes WebSockets of any site's pages and has no option to refuse them. So it is
started with a server that does not listen; what it would do with a connection is kept, and done for
the pages that the panel has let in. Guarantees:
- Viser opens no port. If a version of it does, `PictureDoor.handler` stays None.
- Nothing that a page sends reaches viser: messages to it have no effect and no cost there.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Final

import viser.infra
import websockets.asyncio.server
from websockets.exceptions import ConnectionClosed, ConnectionClosedOK

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterator

    from websockets.asyncio.server import ServerConnection


#: two servers of viser are not started at a time: the exchange is of a name in its module
_STARTING: Final = threading.Lock()


class PictureDoor:
    """Where viser's server would listen, and what it does with a connection.

    Attributes:
        handler: viser's function for a connection, on its own loop; None until it has begun.
    """

    def __init__(self) -> None:
        self.handler: Callable[[Any], Awaitable[None]] | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._drawing: set[asyncio.Task[None]] = set()

    @contextlib.asynccontextmanager
    async def instead_of_serve(self, handler: Any, *_: Any, **__: Any) -> AsyncIterator[Any]:
        """In the place of `websockets.serve`, on viser's loop."""
        self.handler, self._loop = handler, asyncio.get_running_loop()
        try:
            yield SimpleNamespace(server=SimpleNamespace(sockets=()))
        finally:  # as a server does: viser closes its loop next
            for drawing in self._drawing:
                drawing.cancel()
            await asyncio.gather(*self._drawing, return_exceptions=True)

    async def serve(self, page: ServerConnection) -> None:
        """Transport the picture to a page until it is closed. What the page sends is dropped."""
        if self.handler is None or self._loop is None:
            return
        viewer = _Viewer(page, asyncio.get_running_loop())
        coroutine = self._draw(self.handler, viewer)
        drawing = asyncio.wrap_future(asyncio.run_coroutine_threadsafe(coroutine, self._loop))
        try:
            with contextlib.suppress(ConnectionClosed):
                async for _ in page:
                    await asyncio.sleep(0)
        finally:
            with contextlib.suppress(RuntimeError):  # viser has ended, and its loop with it
                self._loop.call_soon_threadsafe(viewer.gone.set)
            with contextlib.suppress(asyncio.CancelledError, TimeoutError):
                await asyncio.wait_for(drawing, 1.0)

    async def _draw(self, handler: Callable[[Any], Awaitable[None]], viewer: _Viewer) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._drawing.add(task)
        try:
            with contextlib.suppress(ConnectionClosed):
                await handler(viewer)
        finally:
            self._drawing.discard(task)


class _Viewer:
    """What viser sees of a page: it can be sent to, and it ends.

    Args:
        page: the page's connection.
        loop: the loop of the connection.
    """

    def __init__(self, page: ServerConnection, loop: asyncio.AbstractEventLoop) -> None:
        self.subprotocol = page.subprotocol
        self.gone = asyncio.Event()
        self._page = page
        self._loop = loop

    async def send(self, data: bytes) -> None:
        """Send to the page; waits while the page is slow."""
        if self.gone.is_set():
            raise ConnectionClosedOK(None, None)
        sending = asyncio.run_coroutine_threadsafe(self._page.send(data), self._loop)
        await asyncio.wrap_future(sending)

    async def recv(self) -> bytes:
        """Wait for the end: a page has nothing to say to viser."""
        await self.gone.wait()
        raise ConnectionClosedOK(None, None)

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """Close the page's connection."""
        closing = asyncio.run_coroutine_threadsafe(self._page.close(code, reason), self._loop)
        await asyncio.wrap_future(closing)


@contextlib.contextmanager
def portless() -> Iterator[PictureDoor]:
    """A server of viser that is made in this block opens no port."""
    door = PictureDoor()
    module: Any = viser.infra._infra  # it has no option for this
    server = SimpleNamespace(**vars(websockets.asyncio.server))
    server.serve = door.instead_of_serve
    inner = SimpleNamespace(**vars(websockets.asyncio))
    inner.server = server
    outer = SimpleNamespace(**vars(websockets))
    outer.asyncio = inner
    with _STARTING:
        module.websockets = outer
        try:
            yield door
        finally:
            module.websockets = websockets
