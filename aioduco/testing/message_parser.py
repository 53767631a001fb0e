"""A parser of the wire's messages, for a proxy between a client and a server."""

from __future__ import annotations

from aioduco._wire.framing import Malformed
from aioduco._wire.messages import Inbox, Message, MessageType, application_error

__all__ = ["Message", "MessageError", "MessageParser", "MessageType", "application_error"]


class MessageError(ValueError):
    """The bytes are not a message of the wire."""


class MessageParser:
    """Finds whole messages in a stream of bytes.

    Each byte is read once, however the stream is split. After a `MessageError` the parser cannot
    continue: nothing in the stream tells where the next message would begin.
    """

    def __init__(self) -> None:
        self._inbox = Inbox()
        self._wrong: MessageError | None = None

    @property
    def pending(self) -> bytes:
        """The bytes that were fed and do not belong to a complete message yet."""
        return self._inbox.pending

    def feed(self, data: bytes) -> list[Message]:
        """Take more bytes.

        Args:
            data: the next bytes of the stream, any number of them.

        Returns:
            The messages that these bytes complete, oldest first.

        Raises:
            MessageError: the bytes are not a message. Complete messages before them in the
                same piece are returned first; the next call raises the error.
        """
        self._inbox.feed(data)
        found: list[Message] = []
        while self._wrong is None:
            try:
                message = self._inbox.take()
            except Malformed as exc:
                self._wrong = MessageError(str(exc))
                break
            if message is None:
                return found
            found.append(message)
        if not found:
            raise self._wrong
        return found
