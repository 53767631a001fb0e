"""A thread that serves a socket until it is told to end."""

from __future__ import annotations

import socket
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


class SocketThread:
    """Starts the thread, and owns the socket from then on.

    Args:
        name: name of the thread.
        opened: the socket.
        serve: the thread's work, with the socket, and with another one that is readable when the
            work is to end.
    """

    def __init__(
        self,
        name: str,
        opened: socket.socket,
        serve: Callable[[socket.socket, socket.socket], object],
    ) -> None:
        opened.setblocking(False)
        self._opened = opened
        self._wake, woken = self._ends = socket.socketpair()
        self._thread = threading.Thread(target=serve, args=(opened, woken), name=name, daemon=True)
        self._thread.start()

    def end(self) -> None:
        """End the thread, wait until it has ended, and close the socket."""
        self._wake.send(b"x")
        self._thread.join()
        for each in (*self._ends, self._opened):
            each.close()
