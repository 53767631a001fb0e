"""Receive signals that ask a command to end in its event loop, on every operating system."""

from __future__ import annotations

import signal
import socket
from contextlib import contextmanager
from typing import TYPE_CHECKING

import anyio

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

__all__ = ["receive_signals"]


@contextmanager
def receive_signals(*signals: signal.Signals) -> Iterator[AsyncIterator[signal.Signals]]:
    """Receive signals instead of being ended by them. Use it on the main thread.

    The interpreter writes a byte for each signal, and the event loop reads it. Not every event
    loop supports signal handlers, and a byte wakes up a loop that is waiting.

    Args:
        signals: the signals to receive.
    """
    ours, others = socket.socketpair()
    with ours, others:
        ours.setblocking(False)
        others.setblocking(False)
        before = signal.set_wakeup_fd(others.fileno(), warn_on_full_buffer=False)
        handlers = {number: signal.signal(number, lambda *_: None) for number in signals}
        try:
            yield _numbers(ours, signals)
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
            signal.set_wakeup_fd(before)


async def _numbers(
    link: socket.socket, signals: tuple[signal.Signals, ...]
) -> AsyncIterator[signal.Signals]:
    while True:
        await anyio.wait_readable(link)
        for number in link.recv(4096):
            if number in signals:
                yield signal.Signals(number)
