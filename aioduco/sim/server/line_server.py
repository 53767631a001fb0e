"""A loopback port for lines of text: each line is a command, and the answer is text.

A line that is too long is answered by an error, and no part of it is a command. Nor is any part of
a request of a browser: the page of any site can send one to a port of this computer.
"""

from __future__ import annotations

import socketserver
import threading
from http import HTTPMethod
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


_HOST = "127.0.0.1"
_LONGEST = 1000  # longest line [bytes]
_REQUESTS = tuple(f"{method} ".encode() for method in HTTPMethod)


class _Lines(socketserver.StreamRequestHandler):
    def handle(self) -> None:
        assert isinstance(self.server, _Listener)
        while line := self.rfile.readline(_LONGEST):
            if line.startswith(_REQUESTS):
                return  # its body would be lines, too
            if len(line) == _LONGEST and not line.endswith(b"\n"):
                # what follows belongs to this line, and is no command
                while (rest := self.rfile.readline(_LONGEST)) and not rest.endswith(b"\n"):
                    pass
                answer = f"error: a line has {_LONGEST} bytes at most: nothing was done"
            else:
                answer = self.server.answer(line.decode(errors="replace"))
            try:
                self.wfile.write(answer.encode() + b"\n")
            except OSError:
                return  # the client has disconnected before its answer


class _Listener(socketserver.ThreadingTCPServer):
    allow_reuse_address = True
    daemon_threads = True

    def __init__(self, port: int, answer: Callable[[str], str]) -> None:
        self.answer = answer
        super().__init__((_HOST, port), _Lines)


class LineServer:
    """Listens on loopback only, whatever address the simulator itself listens on.

    Args:
        answer: carries out a line and returns the answer; called in the thread of the connection.
        port: TCP port; 0 picks a free one, which the attribute `port` then gives.

    Raises:
        OSError: The server cannot listen on the port.
    """

    def __init__(self, answer: Callable[[str], str], port: int) -> None:
        self._listener = _Listener(port, answer)
        self.port: int = self._listener.server_address[1]
        self._thread = threading.Thread(
            target=self._listener.serve_forever, args=(0.05,), name="sim-lines", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Stop listening, and wait until the thread has ended."""
        self._listener.shutdown()
        self._thread.join()
        self._listener.server_close()
