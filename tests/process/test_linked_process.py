"""The channel between a program and a process that it has started."""

from __future__ import annotations

import os
import socket
import threading
from pathlib import Path

import pytest
from interpreter import python

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


_FORKING = """
import os
from aioduco._process.linked_process import LinkedProcess
from aioduco.errors import WrongProcess

def refused():
    try:
        linked.ask("child")
    except WrongProcess as error:
        return "was forked" in str(error)

linked = LinkedProcess("process.echoing", runs_program=True)
assert linked.ask("parent") == "parent"
child = os.fork()
if not child:
    wrong = not refused()
    linked.close()
    os._exit(wrong)
assert os.waitpid(child, 0)[1] == 0
assert linked.ask("goes on") == "goes on"
linked.close()
"""


@pytest.mark.linux("os.fork")
def test_a_forked_child_can_neither_use_nor_end_the_process_of_its_parent() -> None:
    """Its question would get the parent's answer: a planner's plan to another goal."""
    tests = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    found = python("-W", "ignore", "-c", _FORKING, env=tests)
    assert found.returncode == 0, found.stderr
