"""One end of a TCP connection, with asynchronous methods; it can also end with a reset."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import struct

import anyio

from aioduco.testing.faults import Ending

_CHUNK = 1 << 16


class AwaitedSocket:
    """A non-blocking socket with asynchronous methods.

    It uses a plain socket and not anyio's streams, since those send a FIN before they close: the
    other side would never see a reset.
    """

    def __init__(self, sock: socket.socket) -> None:
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket = sock
        self._sending = anyio.Lock(fast_acquire=True)

    @classmethod
    async def connect(cls, host: str, port: int) -> AwaitedSocket:
        """Connect to a host given by its address.

        Raises:
            OSError: no server listens there.
        """
        with contextlib.ExitStack() as stack:
            sock = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_STREAM))
            endpoint = cls(sock)
            code = sock.connect_ex((host, port))
            if code == errno.EINPROGRESS:
                await anyio.wait_writable(sock)
                code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
            if code:
                raise OSError(code, os.strerror(code))
            stack.pop_all()
        return endpoint

    async def receive(self) -> bytes:
        """Receive the next bytes; empty when the other side has sent its FIN or a reset."""
        while True:
            try:
                return self._socket.recv(_CHUNK)
            except BlockingIOError:
                await anyio.wait_readable(self._socket)
            except OSError:
                return b""

    async def send(self, data: bytes) -> None:
        """Send all data in one piece, even if several tasks send at the same time.

        Raises:
            OSError: the other side has closed.
        """
        rest = memoryview(data)
        async with self._sending:
            while rest:
                try:
                    rest = rest[self._socket.send(rest) :]
                except BlockingIOError:
                    await anyio.wait_writable(self._socket)

    def end_sending(self) -> None:
        """Send a FIN: no more will come."""
        with contextlib.suppress(OSError):  # it has ended already
            self._socket.shutdown(socket.SHUT_WR)

    def close(self, how: Ending) -> None:
        """Close the socket. No task may be waiting on it any more."""
        if how is Ending.RESET:
            linger = struct.pack("ii", 1, 0)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
        self._socket.close()
