"""A server on the level of messages: answers each call with the call's own body."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

from wire.servers import Peer, ScriptedServer

from aioduco.testing.message_parser import Message, MessageError, MessageParser, MessageType


class EchoServer(ScriptedServer):
    """Keeps what it received, and what it could not read."""

    def __init__(self) -> None:
        super().__init__(self._echo)
        self.received: list[Message] = []
        self.rest: list[bytes] = []
        self.ended = 0

    def _echo(self, peer: Peer) -> None:
        parser = MessageParser()
        with peer.sock as sock, suppress(OSError, MessageError):
            while data := sock.recv(4096):
                for message in parser.feed(data):
                    self.received.append(message)
                    sock.sendall(replace(message, kind=MessageType.REPLY).encode())
        self.rest.append(parser.pending)
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
