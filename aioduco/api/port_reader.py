"""How what a controller sends by itself to a port is read: connect, read, close."""

from __future__ import annotations

import socket
import time
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Final, Generic, Self, TypeVar

import anyio

from aioduco._process.copying import Uncopied
from aioduco._wire.channel import resolve
from aioduco._wire.endpoint import Endpoint
from aioduco.errors import ConnectionLost, RobotStateError
from aioduco.models import ranges
from aioduco.models.address import host_alone
from aioduco.models.host_port import host_port

if TYPE_CHECKING:
    from anyio.abc import AsyncResource


#: how anyio says that the other side has ended the connection
_ENDS: Final = (anyio.EndOfStream, anyio.IncompleteRead, anyio.BrokenResourceError)

#: the connection
C = TypeVar("C", bound="AsyncResource")
#: what is read
T = TypeVar("T")


class PortReader(Uncopied, ABC, Generic[C, T]):
    """Reads a port of a controller; iterating yields each item as it arrives.

    Args:
        host: address of the controller.
        port: the port.
        timeout: the longest wait for the connection, and for each item [s].

    Raises:
        ParameterError: the host is no name or address, or the port or the time is out of range.
    """

    #: what an item is called, and why none comes any more, for messages
    _item: ClassVar[str]
    _ended: ClassVar[str]

    def __init__(self, host: str, port: int, timeout: float) -> None:
        host = host_alone(host)
        self.host = host
        self.port: int = ranges.PORT("port", port)
        self.timeout: float = ranges.TIMEOUT("timeout", timeout)
        self._connection: C | None = None

    def __repr__(self) -> str:
        state = "closed" if self._connection is None else "open"
        return f"<{type(self).__name__} {host_port(self.host, self.port)} {state}>"

    @abstractmethod
    async def _connect(self, host: str, port: int) -> C:
        """Connect to one address of the host; an `OSError` says that this failed."""

    @abstractmethod
    async def _receive(self, connection: C) -> bytes:
        """Wait for the bytes of the next item."""

    @staticmethod
    @abstractmethod
    def _decode(data: bytes) -> T:
        """Make the item; a `ProtocolError` says that the bytes are none."""

    async def __aenter__(self) -> Self:
        if self._connection is not None:
            raise RobotStateError(f"{self!r}: it is opened once at a time; make another one")
        endpoint = Endpoint(self.host, self.port, self.timeout, functions=False)
        deadline = time.monotonic() + self.timeout
        error: BaseException = TimeoutError("no time was left to connect")
        found = await resolve(endpoint, deadline)
        for (*_, name), until in endpoint.route.tries(found, deadline):
            host, port = socket.getnameinfo(name, socket.NI_NUMERICHOST | socket.NI_NUMERICSERV)
            try:
                with anyio.fail_after(until - time.monotonic()):
                    self._connection = await self._connect(host, int(port))
            except (OSError, anyio.BrokenResourceError) as exc:
                error = exc.__cause__ if isinstance(exc.__cause__, OSError) else exc
            else:
                return self
        raise endpoint.refused(error) from error

    async def __aexit__(self, *_: object) -> None:
        if self._connection is not None:
            connection, self._connection = self._connection, None
            await anyio.aclose_forcefully(connection)

    async def __anext__(self) -> T:
        """Wait for the next item, at most for the time-out.

        Raises:
            ConnectionLost: it is not open, nothing came in time, or nothing comes any more.
            ProtocolError: what came is no such item.
        """
        if self._connection is None:
            raise ConnectionLost(f"{self!r}: open it by `async with`")
        try:
            with anyio.fail_after(self.timeout):
                data = await self._receive(self._connection)
        except TimeoutError as exc:
            raise ConnectionLost(f"{self!r}: no {self._item} within {self.timeout} s") from exc
        except (OSError, *_ENDS) as exc:
            raise ConnectionLost(f"{self!r}: {self._ended}") from exc
        return self._decode(data)

    def __aiter__(self) -> Self:
        return self
