"""The channel between a program and a process that it has started."""

from __future__ import annotations

import socket
import threading

from aioduco._process.linked_process import ValueChannel
from aioduco.testing import eventually


def test_closing_a_channel_ends_what_both_sides_receive() -> None:
    ours, theirs = socket.socketpair()
    theirs.settimeout(20.0)
    channel, ended = ValueChannel(ours), []

    def receive() -> None:
        try:
            channel.receive()
        except (EOFError, OSError) as exc:
            ended.append(exc)

    thread = threading.Thread(target=receive, daemon=True)
    thread.start()
    with theirs:
        # the head of a value: the thread receives until the rest comes
        theirs.sendall(b"1234")
        eventually(lambda: _unread(ours) == 0)
        channel.close()
        assert theirs.recv(1) == b""
    thread.join(20.0)
    assert len(ended) == 1


def _unread(link: socket.socket) -> int:
    try:
        return len(link.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT))
    except BlockingIOError:
        return 0
