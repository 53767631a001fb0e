"""The simulated controller's force stream: datagrams to each client that has asked for them."""

from __future__ import annotations

import contextlib
import selectors
import socket
import time
from typing import TYPE_CHECKING, Any, Final

from aioduco.models.force_sample import FORCE_REQUEST, ForceSample
from aioduco.models.pose import Pose
from aioduco.sim.refusal import Refusal
from aioduco.sim.server.socket_thread import SocketThread

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire import rpc


#: between two datagrams, by the wall's clock [s]; its real value is not known
_PERIOD: Final = 0.01
#: the clients that asked last are served: a datagram's sender proves nothing
_MOST_CLIENTS: Final = 8
_RECEIVE: Final = 256


def force_sample_of(robot: rpc.Functions) -> ForceSample | None:
    """Make a sample of a controller's answers to calls; None without a force sensor."""
    force = tuple(robot.get_tcp_force())
    return ForceSample(force, Pose(*robot.get_tcp_pose())) if force else None


class ForceServer:
    """A UDP port that streams to those who ask.

    Args:
        sample: makes the sample of the present instant; None: nothing is sent.
        host: address to listen on.
        port: UDP port; 0 picks a free one, which the attribute `port` then gives.
    """

    def __init__(
        self, sample: Callable[[], ForceSample | None], *, host: str = "127.0.0.1", port: int = 0
    ) -> None:
        self.host = host
        self.port: int = port
        self._sample = sample
        #: addresses of clients, in the order in which they asked
        self._clients: dict[Any, None] = {}
        self._refusing = False
        self._thread: SocketThread | None = None

    def start(self) -> None:
        """Listen.

        Raises:
            OSError: The server cannot listen on the address, for instance if the port is in use.
        """
        family, kind, *_, address = socket.getaddrinfo(
            self.host, self.port, type=socket.SOCK_DGRAM
        )[0]
        opened = socket.socket(family, kind)
        try:
            opened.bind(address)
        except OSError:
            opened.close()
            raise
        self.port = opened.getsockname()[1]
        self._thread = SocketThread("sim-force", opened, self._serve)

    def refuse(self, refusing: bool) -> None:
        """While `refusing` is set, forget clients and take no new ones."""
        self._refusing = refusing

    def close(self) -> None:
        """End the streams, and wait until the thread has ended."""
        if self._thread is not None:
            self._thread.end()
            self._thread = None

    def _serve(self, opened: socket.socket, wake: socket.socket) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(wake, selectors.EVENT_READ)
            selector.register(opened, selectors.EVENT_READ)
            due = time.monotonic()
            while True:
                # Without clients it waits for one. The schedule is absolute.
                wait = max(0.0, due - time.monotonic()) if self._clients else None
                ready = {key.fileobj for key, _ in selector.select(wait)}
                if wake in ready:
                    return
                if opened in ready:
                    self._take(opened)
                if time.monotonic() >= due:
                    due += _PERIOD * (1.0 + (time.monotonic() - due) // _PERIOD)
                    self._push(opened)

    def _take(self, opened: socket.socket) -> None:
        try:
            asked, client = opened.recvfrom(_RECEIVE)
        except OSError:
            return  # an earlier datagram has found nobody
        if asked.strip() == FORCE_REQUEST and not self._refusing:
            self._clients.pop(client, None)
            self._clients[client] = None
            while len(self._clients) > _MOST_CLIENTS:
                del self._clients[next(iter(self._clients))]

    def _push(self, opened: socket.socket) -> None:
        if self._refusing:
            self._clients.clear()
        if not self._clients:
            return
        try:
            sample = self._sample()
        except Refusal:
            return  # the simulation has ended: there is nothing to send
        if sample is None:
            return
        data = sample.encode()
        for client in self._clients:
            with contextlib.suppress(OSError):  # its buffer is full, or it has gone
                opened.sendto(data, client)
