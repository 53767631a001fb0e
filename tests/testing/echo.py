"""A server on the level of messages: answers each call with the call's own body."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Self

from aioduco.testing.message_parser import Message, MessageError, MessageParser, MessageType

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import TracebackType


class EchoServer:
    """Keeps what it received, and what it could not read."""

    def __init__(self) -> None:
        self.received: list[Message] = []
        self.rest: list[bytes] = []
        self.ended = 0
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self._open: set[socket.socket] = set()
        self._threads = [threading.Thread(target=self._accept, name="echo accept")]

    def __enter__(self) -> Self:
        self._threads[0].start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for sock in (self._listener, *self._open):
            with suppress(OSError):
                sock.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            thread.join()
        self._listener.close()

    def _accept(self) -> None:
        while True:
            try:
                sock, _ = self._listener.accept()
            except OSError:
                return
            self._open.add(sock)
            thread = threading.Thread(target=self._serve, args=(sock,), name="echo connection")
            self._threads.append(thread)
            thread.start()

    def _serve(self, sock: socket.socket) -> None:
        parser = MessageParser()
        with sock, suppress(OSError, MessageError):
            while data := sock.recv(4096):
                for message in parser.feed(data):
                    self.received.append(message)
                    sock.sendall(replace(message, kind=MessageType.REPLY).encode())
        self.rest.append(parser.pending)
        self._open.discard(sock)
        self.ended += 1


def call(name: str = "read_word_reg", seqid: int = 1, payload: str = "") -> Message:
    """A call that carries a text by which it is known again."""
    text = payload.encode()
    body = b"\x0b\x00\x01" + len(text).to_bytes(4, "big") + text + b"\x00"
    return Message(MessageType.CALL, name, seqid, body)


def replies(sock: socket.socket) -> Iterator[Message]:
    """What comes on a connection, message by message, until its end."""
    parser = MessageParser()
    while data := sock.recv(4096):
        yield from parser.feed(data)
