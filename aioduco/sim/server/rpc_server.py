"""Accept loop, and a thread for each connection."""

from __future__ import annotations

import contextlib
import logging
import selectors
import socket
import threading
import time
from typing import TYPE_CHECKING, Self

from aioduco._process.reporting import BackgroundLogger
from aioduco._wire import idl
from aioduco._wire.framing import Malformed
from aioduco.models.host_port import host_port
from aioduco.sim import trial
from aioduco.sim.server.processor import CallInbox, Processor
from aioduco.sim.server.socket_thread import SocketThread

if TYPE_CHECKING:
    from aioduco._wire.messages import Message
    from aioduco.sim.server.generations import Wire

_log = BackgroundLogger(__name__)

_RECEIVE = 1 << 16
#: number of warnings about peers; later ones have debug level: a hostile peer must not fill a disk
_WARNINGS = 20
#: pause after a failed accept, so that a full descriptor table does not cause a busy loop [s]
_ACCEPT_PAUSE = 0.1


class Server:
    """Serves a handler on one TCP port.

    Args:
        handler: object whose methods answer the calls, from many threads at once.
        host: address to listen on; loopback by default.
        port: TCP port; 0 picks a free one, which the attribute `port` then gives.
        wire: the functions that are served; None for those of the present generation.
        max_connections: largest number of connections; others are closed right after the accept.
    """

    def __init__(
        self,
        handler: object,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        wire: Wire | None = None,
        max_connections: int = 2048,
    ) -> None:
        self.host = host
        self.port: int = port
        self._wire = wire
        self.max_connections = max_connections
        self._handler = handler
        self._lock = threading.Lock()
        self._connections: dict[socket.socket, threading.Thread] = {}
        self._acceptor: SocketThread | None = None
        self._refusing = False
        self._refused: set[socket.socket] = set()
        self._closing = threading.Event()
        self._warned = 0

    def __repr__(self) -> str:
        state = "closed" if self._acceptor is None else f"{len(self._connections)} connections"
        return f"<{type(self).__name__} {host_port(self.host, self.port)} {state}>"

    @property
    def connections(self) -> int:
        """Number of open connections."""
        return len(self._connections)

    def start(self) -> None:
        """Listen, and begin to accept.

        Raises:
            OSError: The server cannot listen on the address, for instance if the port is in use.
            RuntimeError: It listens already.
        """
        if self._acceptor is not None:
            raise RuntimeError(f"this server listens already, on {host_port(self.host, self.port)}")
        idl.functions()  # parse the IDL before a first client has to wait for that
        family = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_STREAM)[0][0]
        listener = socket.create_server((self.host, self.port), family=family, backlog=512)
        self.port = listener.getsockname()[1]
        self._closing.clear()
        self._acceptor = SocketThread("sim-accept", listener, self._accept)

    def refuse(self, refusing: bool) -> None:
        """Close every open connection, and every new one, for as long as `refusing` is set.

        A controller that is starting behaves like this: it accepts connections and closes them.
        Calls in progress are answered before.
        """
        with self._lock:
            self._refusing = refusing
            if refusing:
                self._refused.update(self._connections)
                self._shut(socket.SHUT_RD)

    def drop(self) -> int:
        """Cut every open connection, like a pulled cable, and return their number."""
        with self._lock:
            self._shut(socket.SHUT_RDWR)
            return len(self._connections)

    def _shut(self, how: int) -> None:
        for connection in self._connections:
            with contextlib.suppress(OSError):  # the peer has already closed it
                connection.shutdown(how)

    def close(self, timeout: float = 10.0) -> None:
        """Stop accepting, cut every connection, and wait until every thread has ended.

        The handler must have released its waiting calls before this is called.

        Raises:
            TimeoutError: A handler did not return within `timeout` seconds.
        """
        if self._acceptor is None:
            return
        deadline = time.monotonic() + timeout
        self._closing.set()
        self._acceptor.end()
        self._acceptor = None
        self.drop()
        with self._lock:
            threads = list(self._connections.values())
        for thread in threads:
            thread.join(max(0.0, deadline - time.monotonic()))
        if stuck := [thread.name for thread in threads if thread.is_alive()]:
            raise TimeoutError(f"calls still run after {timeout} s on: {', '.join(stuck)}")

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _accept(self, listener: socket.socket, wake: socket.socket) -> None:
        with selectors.DefaultSelector() as selector, selectors.DefaultSelector() as pause:
            selector.register(listener, selectors.EVENT_READ)
            for each in (selector, pause):
                each.register(wake, selectors.EVENT_READ)
            while not self._closing.is_set():
                selector.select()
                if self._closing.is_set():
                    return
                try:
                    connection, peer = listener.accept()
                except (BlockingIOError, ConnectionAbortedError):
                    continue  # the peer disconnected between the two calls
                except OSError:
                    _log.exception("cannot accept a connection")
                    pause.select(_ACCEPT_PAUSE)
                    continue
                self._admit(connection, host_port(*peer[:2]))

    def _admit(self, connection: socket.socket, peer: str) -> None:
        with self._lock:
            if self._refusing or len(self._connections) >= self.max_connections:
                self._warn("%s: connection refused", peer)
                connection.close()
                return
            thread = threading.Thread(
                target=self._serve, args=(connection, peer), name=f"sim-{peer}", daemon=True
            )
            self._connections[connection] = thread
        try:
            thread.start()
        except RuntimeError:
            _log.exception("%s: no thread for another connection", peer)
            with self._lock:
                del self._connections[connection]
                connection.close()

    def _warn(self, message: str, *args: object) -> None:
        level = logging.WARNING if self._warned < _WARNINGS else logging.DEBUG
        self._warned += 1
        _log.log(level, message, *args)

    def _serve(self, connection: socket.socket, peer: str) -> None:
        """Answer the calls of one connection until it ends. Runs on a thread of its own."""
        inbox, processor = CallInbox(), Processor(self._handler, self._wire)
        try:
            connection.setblocking(True)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
            # Each time: Linux delivers bytes that arrive after a SHUT_RD.
            while (data := connection.recv(_RECEIVE)) and connection not in self._refused:
                inbox.feed(data)
                while connection not in self._refused and (message := inbox.take()) is not None:
                    if answer := _answer(processor, message):
                        connection.sendall(answer)
        except Malformed as exc:
            self._warn("%s: connection closed: %s", peer, exc)
        except OSError as exc:
            _log.info("%s: connection lost: %s", peer, exc)
        except Exception:
            _log.exception("%s: connection closed", peer)
        finally:
            # Under the lock, so that `drop` never uses a descriptor that was assigned anew.
            with self._lock:
                del self._connections[connection]
                self._refused.discard(connection)
                connection.close()


def _answer(processor: Processor, message: Message) -> bytes:
    if trial.current is None:
        return processor.answer(message)
    return trial.current.answer(message.name, lambda: processor.answer(message))
