"""The controller's force stream (UDP 2011): forces at a high rate, when they are asked for.

    async with ForceStream("192.168.1.10") as stream:
        async for sample in stream:
            print(sample.force)

It needs no call and no connection of the robot. The vendor does not document it, and one public
program is all that is known: `aioduco.models.force_sample` says what.
"""

from __future__ import annotations

from typing import Final

import anyio
from anyio.abc import ConnectedUDPSocket

from aioduco.api.port_reader import PortReader
from aioduco.models.force_sample import FORCE_PORT, FORCE_REQUEST, ForceSample

__all__ = ["ForceSample", "ForceStream"]

#: silence after which the stream is asked for again, as in the program that is known [s]
ASK_AGAIN: Final = 2.0


class ForceStream(PortReader[ConnectedUDPSocket, ForceSample]):
    """The force stream of a controller; iterating yields each sample as it arrives.

    Datagrams may be lost, and come without a number or a time: a sample is as old as the network
    makes it. After two seconds of silence the stream is asked for again.

    Args:
        host: address of the controller.
        port: its UDP port.
        timeout: the longest wait for its name to be resolved, and for each sample [s].

    Raises:
        ParameterError: the host is no name or address, or the time is out of range.
    """

    _item = "sample"
    _ended = "nothing listens there"

    def __init__(self, host: str, port: int = FORCE_PORT, *, timeout: float = 5.0) -> None:
        super().__init__(host, port, timeout)

    async def _connect(self, host: str, port: int) -> ConnectedUDPSocket:
        opened = await anyio.create_connected_udp_socket(host, port)
        await opened.send(FORCE_REQUEST)
        return opened

    async def _receive(self, connection: ConnectedUDPSocket) -> bytes:
        while True:
            with anyio.move_on_after(ASK_AGAIN):
                return await connection.receive()
            await connection.send(FORCE_REQUEST)

    @staticmethod
    def _decode(data: bytes) -> ForceSample:
        return ForceSample.decode(data)

    async def sample(self) -> ForceSample:
        """Wait for the next sample.

        Returns:
            The sample.

        Raises:
            ConnectionLost: it is not open, or no sample came in time.
            ProtocolError: what came is none.
        """
        return await anext(self)
