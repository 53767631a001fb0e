"""Receive signals that ask a command to end, on every operating system."""

from __future__ import annotations

import signal
import socket
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

import anyio

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator

__all__ = ["ENDS", "receive_signals", "wakeup_socket"]

#: the signals that ask a command to end
ENDS: Final = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def wakeup_socket() -> Iterator[tuple[socket.socket, Callable[[], object]]]:
    """Receive these signals instead of being ended by them. Use it on the main thread.

    The system may deliver a signal to any thread, also to a thread of a library. A blocking call of
    the main thread would then not return, and not every event loop supports signal handlers. The
    byte that the interpreter writes for the signal wakes up both.

    Yields:
        A socket from which the signals' numbers are read, and a function that makes it readable.
    """
    heard, rung = socket.socketpair()
    with heard, rung:
        heard.setblocking(False)
        rung.setblocking(False)
        before = signal.set_wakeup_fd(rung.fileno(), warn_on_full_buffer=False)
        handlers = {number: signal.signal(number, lambda *_: None) for number in ENDS}
        try:
            yield heard, lambda: rung.send(b"!")
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
            signal.set_wakeup_fd(before)


@contextmanager
def receive_signals() -> Iterator[AsyncIterator[signal.Signals]]:
    """The same in an event loop: iterate over the signals as they come."""
    with wakeup_socket() as (heard, _):
        yield _numbers(heard)


async def _numbers(link: socket.socket) -> AsyncIterator[signal.Signals]:
    while True:
        await anyio.wait_readable(link)
        for number in link.recv(4096):
            if number in ENDS:
                yield signal.Signals(number)
