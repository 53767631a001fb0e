"""The controller's status port (TCP 2001): about ten frames a second, sent without a request.

    async with StatusPort("192.168.1.10") as port:
        async for frame in port:
            print(frame.joint_position[:6])

It needs no call and no connection of the robot, so a monitor can run beside any program. The vendor
does not document it: `aioduco.models.status_frame` describes what is known.
"""

from __future__ import annotations

import anyio
from anyio.streams.buffered import BufferedByteReceiveStream

from aioduco.api.port_reader import PortReader
from aioduco.errors import ParameterError
from aioduco.models.status_frame import FRAME_SIZE, PORT, RATE, StatusFrame

__all__ = ["StatusFrame", "StatusPort"]


class StatusPort(PortReader[BufferedByteReceiveStream, StatusFrame]):
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

    _item = "frame"
    _ended = "the controller closed the connection"

    def __init__(self, host: str, port: int = PORT, *, timeout: float = 3.0) -> None:
        super().__init__(host, port, timeout)
        if not self.timeout > 1.0 / RATE:
            raise ParameterError("timeout", timeout, f"above {1.0 / RATE} s: frames come as often")

    async def _connect(self, host: str, port: int) -> BufferedByteReceiveStream:
        return BufferedByteReceiveStream(await anyio.connect_tcp(host, port))

    async def _receive(self, connection: BufferedByteReceiveStream) -> bytes:
        return await connection.receive_exactly(FRAME_SIZE)

    @staticmethod
    def _decode(data: bytes) -> StatusFrame:
        return StatusFrame.decode(data)

    async def frame(self) -> StatusFrame:
        """Wait for the next frame.

        Returns:
            The frame.

        Raises:
            ConnectionLost: the connection ended or was not open; or no frame came in time, and the
                age of the next one would be unknown. Open a new connection.
            ProtocolError: what came is no such frame; the controller may send another layout.
        """
        return await anext(self)
