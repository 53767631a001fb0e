"""A server on the level of messages: answers each call with the call's own body."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace

from wire.servers import Peer, ScriptedServer

from aioduco._wire.framing import Malformed
from aioduco._wire.messages import Inbox, Message, MessageType


class EchoServer(ScriptedServer):
    """Keeps what it received, and what it could not read."""

    def __init__(self) -> None:
        super().__init__(self._echo)
        self.received: list[Message] = []
        self.rest: list[bytes] = []
        self.ended = 0

    def _echo(self, peer: Peer) -> None:
        inbox = Inbox()
        with peer.sock as sock, suppress(OSError, Malformed):
            while data := sock.recv(4096):
                for message in inbox.messages(data):
                    self.received.append(message)
                    sock.sendall(replace(message, kind=MessageType.REPLY).encode())
        self.rest.append(inbox.pending)
        self.ended += 1


def call(name: str = "read_word_reg", seqid: int = 1, payload: str = "") -> Message:
    """A call that carries a text by which it is known again."""
    text = payload.encode()
    body = b"\x0b\x00\x01" + len(text).to_bytes(4, "big") + text + b"\x00"
    return Message(MessageType.CALL, name, seqid, body)


def replies(sock: socket.socket) -> Iterator[Message]:
    """What comes on a connection, message by message, until its end."""
    inbox = Inbox()
    while data := sock.recv(4096):
        yield from inbox.messages(data)
