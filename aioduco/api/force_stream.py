"""The controller's force stream (UDP 2011): forces at a high rate, when they are asked for.

    async with ForceStream("192.168.1.10") as stream:
        async for sample in stream:
            print(sample.force)

It needs no call and no connection of the robot. The vendor does not document it, and one public
program is all that is known: `aioduco.models.force_sample` says what.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final

import anyio

from aioduco._process.copying import Uncopied
from aioduco._wire.endpoint import HOST_RULE, is_host
from aioduco.errors import ConnectError, ConnectionLost, ParameterError
from aioduco.models import ranges
from aioduco.models.force_sample import FORCE_PORT, FORCE_REQUEST, ForceSample

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from anyio.abc import ConnectedUDPSocket

__all__ = ["ForceSample", "ForceStream"]

#: silence after which the stream is asked for again, as in the program that is known [s]
ASK_AGAIN: Final = 2.0


class ForceStream(Uncopied):
    """The force stream of a controller; iterating yields each sample as it arrives.

    Datagrams may be lost, and come without a number or a time: a sample is as old as the network
    makes it. After two seconds of silence the stream is asked for again.

    Args:
        host: address of the controller.
        port: its UDP port.
        timeout: the longest wait for a sample [s].

    Raises:
        ParameterError: the host is no name or address, or the time is out of range.
    """

    def __init__(self, host: str, port: int = FORCE_PORT, *, timeout: float = 5.0) -> None:
        if not isinstance(host, str) or not is_host(host):
            raise ParameterError("host", host, HOST_RULE)
        self.host = host
        self.port = port
        self.timeout: float = ranges.TIMEOUT("timeout", timeout)
        self._socket: ConnectedUDPSocket | None = None

    def __repr__(self) -> str:
        state = "closed" if self._socket is None else "open"
        return f"<{type(self).__name__} {self.host}:{self.port} {state}>"

    async def __aenter__(self) -> Self:
        try:
            self._socket = await anyio.create_connected_udp_socket(self.host, self.port)
            await self._socket.send(FORCE_REQUEST)
        except (OSError, anyio.BrokenResourceError) as exc:
            raise ConnectError(self.host, self.port, str(exc)) from exc
        return self

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._socket is not None:
            opened, self._socket = self._socket, None
            await anyio.aclose_forcefully(opened)

    async def sample(self) -> ForceSample:
        """Wait for the next sample.

        Returns:
            The sample.

        Raises:
            ConnectionLost: it is not open, or no sample came in time.
            ProtocolError: what came is none.
        """
        if self._socket is None:
            raise ConnectionLost(f"{self!r}: open it by `async with`")
        until = time.monotonic() + self.timeout
        while (left := until - time.monotonic()) > 0.0:
            data = None
            try:
                with anyio.move_on_after(min(left, ASK_AGAIN)):
                    data = await self._socket.receive()
                if data is None:
                    await self._socket.send(FORCE_REQUEST)
            except (anyio.BrokenResourceError, anyio.EndOfStream, OSError) as exc:
                raise ConnectionLost(f"{self!r}: nothing listens there") from exc
            if data is not None:
                return ForceSample.decode(data)
        raise ConnectionLost(f"{self!r}: no sample within {self.timeout} s")

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> ForceSample:
        return await self.sample()
