"""Receive signals that ask a command to end, on every operating system."""

from __future__ import annotations

import signal
import socket
from contextlib import contextmanager
from typing import TYPE_CHECKING

import anyio

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable, Iterator
    from types import FrameType


def termination_signals() -> tuple[signal.Signals, ...]:
    """SIGTERM, and SIGHUP: the terminal was closed.

    Not SIGHUP if it is ignored, as under nohup: the command is to go on without its terminal.
    """
    from aioduco._process.platform import ending_signals  # noqa: PLC0415 - quick help

    return tuple(
        number
        for number in ending_signals()
        if number == signal.SIGTERM or signal.getsignal(number) is not signal.SIG_IGN
    )


def end_signals() -> tuple[signal.Signals, ...]:
    """The signals that ask a command to end: Ctrl-C and those above."""
    return (signal.SIGINT, *termination_signals())


@contextmanager
def handled(
    numbers: Iterable[signal.Signals], handler: Callable[[int, FrameType | None], object]
) -> Iterator[None]:
    """Call a handler on these signals. Use it on the main thread."""
    before = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, each in before.items():
            signal.signal(number, each)


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
        try:
            with handled(end_signals(), lambda *_: None):
                yield heard, lambda: rung.send(b"!")
        finally:
            signal.set_wakeup_fd(before)


@contextmanager
def receive_signals() -> Iterator[AsyncIterator[signal.Signals]]:
    """The same in an event loop: iterate over the signals as they come."""
    ends = end_signals()
    with wakeup_socket() as (heard, _):
        yield _numbers(heard, ends)


async def _numbers(
    link: socket.socket, ends: tuple[signal.Signals, ...]
) -> AsyncIterator[signal.Signals]:
    while True:
        await anyio.wait_readable(link)
        for number in link.recv(4096):
            if number in ends:
                yield signal.Signals(number)
