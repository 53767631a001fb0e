"""A process that answers each value with the value."""

from __future__ import annotations

import contextlib

from aioduco._process.linked_process import ValueChannel


def main(arguments: list[str]) -> int:
    """Answer until the channel closes."""
    channel = ValueChannel.of(arguments)
    with contextlib.suppress(EOFError, OSError):
        while True:
            channel.send(channel.receive())
    return 0
