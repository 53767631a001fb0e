"""A thread is woken even if the thread that wakes it is interrupted."""

from __future__ import annotations

import ast
import itertools
import signal
import sys
import threading
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import aioduco
from aioduco._process.wakeup import Wakeup


class Interruption:
    """Interrupts at one of the lines and returns of functions that this thread runs."""

    def __init__(self, number: int) -> None:
        self.left = number

    def trace(self, _frame: FrameType, event: str, _arg: object) -> Any:
        """Count one; a trace function."""
        if event in ("line", "return"):
            self.left -= 1
            if self.left == 0:
                sys.settrace(None)
                raise KeyboardInterrupt
        return self.trace


@pytest.mark.skipif(sys.gettrace() is not None, reason="a debugger or a coverage tool traces")
def test_an_interrupt_anywhere_in_it_leaves_it_whole() -> None:
    for number in itertools.count(1):
        wakeup, interruption = Wakeup(), Interruption(number)
        woken = threading.Event()
        waiting = threading.Thread(
            target=lambda seen=woken, it=wakeup: it.wait(10.0) and seen.set(), daemon=True
        )
        waiting.start()
        sys.settrace(interruption.trace)
        try:
            wakeup.set()
        except KeyboardInterrupt:
            pass
        finally:
            sys.settrace(None)
        wakeup.set()
        assert woken.wait(10.0), number
        waiting.join()
        if interruption.left > 0:
            break
    assert number > 2


def test_it_is_taken_once_for_each_time_it_is_set() -> None:
    wakeup = Wakeup()
    assert not wakeup.wait(0.0)
    wakeup.set()
    assert wakeup.wait(0.0)
    assert not wakeup.wait(0.0)


@pytest.mark.linux("signal.setitimer")
def test_a_signals_handler_that_outlasts_the_wait_does_not_prolong_it() -> None:
    wakeup = Wakeup()
    rescue = threading.Timer(30.0, wakeup.set)
    rescue.start()
    handled = signal.signal(signal.SIGALRM, lambda *_: Wakeup().wait(0.4))
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        assert not wakeup.wait(0.3)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, handled)
        rescue.cancel()
        rescue.join()


@pytest.mark.parametrize(
    "room", ["_process", "_wire", "supervision", "streaming", "recording", "sync"]
)
def test_what_a_robot_is_left_by_has_no_event_of_threads(room: str) -> None:
    """An interrupt of its `set` may leave its lock held: leaving would begin anew, and hang."""
    found = [
        f"{path}:{node.lineno}"
        for path in (Path(aioduco.__file__).parent / room).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and node.attr in ("Event", "Condition")
        if isinstance(node.value, ast.Name) and node.value.id == "threading"
    ]
    assert not found
