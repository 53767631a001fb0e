"""The controller's status port (TCP 2001): about ten frames a second, sent without a request.

    async with StatusPort("192.168.1.10") as port:
        async for frame in port:
            print(frame.joint_position[:6])

It needs no call and no connection of the robot, so a monitor can run beside any program. The vendor
does not document it: `aioduco.models.status_frame` describes what is known.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import anyio
from anyio.streams.buffered import BufferedByteReceiveStream

from aioduco._process.copying import Uncopied
from aioduco._wire.endpoint import HOST_RULE, is_host
from aioduco.errors import ConnectError, ConnectionLost, ParameterError
from aioduco.models import ranges
from aioduco.models.status_frame import FRAME_SIZE, PORT, RATE, StatusFrame

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from anyio.abc import SocketStream

__all__ = ["StatusFrame", "StatusPort"]


class StatusPort(Uncopied):
    """A connection to the status port; iterating yields each frame as it arrives.

    A program that takes frames more slowly than they arrive gets them late, and the controller may
    close its connection.

    Args:
        host: address of the controller.
        port: its status port.
        timeout: the longest wait for the connection, and for each frame [s].

    Raises:
        ParameterError: the host is no name or address, or the time is shorter than that between
            two frames.
    """

    def __init__(self, host: str, port: int = PORT, *, timeout: float = 3.0) -> None:
        if not isinstance(host, str) or not is_host(host):
            raise ParameterError("host", host, HOST_RULE)
        timeout = ranges.TIMEOUT("timeout", timeout)
        if not timeout > 1.0 / RATE:
            raise ParameterError("timeout", timeout, f"above {1.0 / RATE} s: frames come as often")
        self.host = host
        self.port = port
        self.timeout = timeout
        self._stream: SocketStream | None = None
        self._frames: BufferedByteReceiveStream | None = None

    def __repr__(self) -> str:
        state = "closed" if self._stream is None else "open"
        return f"<{type(self).__name__} {self.host}:{self.port} {state}>"

    async def __aenter__(self) -> Self:
        try:
            with anyio.fail_after(self.timeout):
                self._stream = await anyio.connect_tcp(self.host, self.port)
        except TimeoutError as exc:
            reason = f"no answer within {self.timeout} s"
            raise ConnectError(self.host, self.port, reason) from exc
        except OSError as exc:
            raise ConnectError(self.host, self.port, str(exc)) from exc
        self._frames = BufferedByteReceiveStream(self._stream)
        return self

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._stream is not None:
            stream, self._stream, self._frames = self._stream, None, None
            await anyio.aclose_forcefully(stream)

    async def frame(self) -> StatusFrame:
        """Wait for the next frame.

        Returns:
            The frame.

        Raises:
            ConnectionLost: the connection ended or was not open; or no frame came in time, and the
                age of the next one would be unknown. Open a new connection.
        """
        if self._frames is None:
            raise ConnectionLost(f"{self!r}: open it by `async with`")
        try:
            with anyio.fail_after(self.timeout):
                data = await self._frames.receive_exactly(FRAME_SIZE)
        except TimeoutError as exc:
            raise ConnectionLost(f"{self!r}: no frame within {self.timeout} s") from exc
        except (anyio.IncompleteRead, anyio.EndOfStream, anyio.BrokenResourceError) as exc:
            raise ConnectionLost(f"{self!r}: the controller closed the connection") from exc
        return StatusFrame.decode(data)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> StatusFrame:
        return await self.frame()
