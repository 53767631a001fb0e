"""Resources that are left are found, and named."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
from pathlib import Path

import anyio
import pytest

from aioduco import ParameterError
from aioduco.testing import Resources, eventually, eventually_async, no_leaks


def test_nothing_opened_is_nothing_left() -> None:
    with no_leaks(timeout=0):
        pass


def test_a_thread_left_is_found_by_its_name() -> None:
    release = threading.Event()
    thread = threading.Thread(target=release.wait, name="heartbeat")
    with pytest.raises(AssertionError, match=r"thread \d+: heartbeat"), no_leaks(timeout=0):
        thread.start()
    release.set()
    thread.join()


def test_a_socket_left_is_found() -> None:
    opened: list[socket.socket] = []
    with pytest.raises(AssertionError, match=r"file \d+: socket:"), no_leaks(timeout=0):
        opened.append(socket.socket())
    opened[0].close()


def test_a_descriptor_used_again_is_found() -> None:
    sock = socket.socket()
    number = sock.fileno()
    before = Resources.now()
    sock.close()
    with Path(os.devnull).open() as other:
        assert other.fileno() == number
        assert Resources.now().beyond(before) == [f"file {number}: {os.devnull}"]
    assert Resources.now().beyond(before) == []


def test_a_child_left_is_found_while_it_runs_and_until_it_is_waited_for() -> None:
    command = [sys.executable, "-c", "input()"]
    before = Resources.now()
    with subprocess.Popen(command, stdin=subprocess.PIPE) as child:
        # Linux writes its command line a moment after the program has begun.
        eventually(lambda: any("input()" in line for line in Resources.now().beyond(before)))
        child.communicate(b"\n")
    assert Resources.now().beyond(before) == []
    child = subprocess.Popen([sys.executable, "-c", ""])
    eventually(lambda: "(not waited for)" in Resources.now().children.values())
    child.wait()


def test_what_goes_soon_is_no_leak() -> None:
    release = threading.Event()
    thread = threading.Thread(target=release.wait)
    timer = threading.Timer(0.05, release.set)
    with no_leaks():
        thread.start()
        timer.start()
    assert not thread.is_alive()


async def test_waiting_for_what_goes_soon_does_not_block_the_loop() -> None:
    release = threading.Event()
    thread = threading.Thread(target=release.wait)
    async with no_leaks():
        thread.start()
        # runs only if the loop does
        import asyncio  # noqa: PLC0415 - the loop's own timer is what is needed here

        asyncio.get_running_loop().call_later(0.02, release.set)
    assert not thread.is_alive()


def test_an_error_in_the_block_is_passed_on() -> None:
    def leave(sock: socket.socket) -> None:
        with no_leaks(timeout=0):
            os.dup2(sock.fileno(), 900)
            raise KeyError

    with socket.socket() as sock, pytest.raises(KeyError):
        leave(sock)
    os.close(900)


def test_a_condition_that_never_comes_says_what_was_waited_for() -> None:
    with pytest.raises(AssertionError, match=r"not so after 0.01 s: the arm stands"):
        eventually(lambda: False, 0.01, what="the arm stands")


async def test_a_condition_is_waited_for_on_the_loop() -> None:
    looks = iter([False, False, True])
    await eventually_async(lambda: next(looks))
    with pytest.raises(AssertionError, match=r"still moving"):
        await eventually_async(lambda: False, 0.01, what=lambda: "still moving")
    with pytest.raises(ParameterError, match="condition is a function whose result must be"):
        await eventually_async(lambda: anyio.sleep(0.0))
