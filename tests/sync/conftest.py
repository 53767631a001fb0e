"""Fixtures: a controller without an arm, and a robot of the blocking interface."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

import pytest
from api.desk import Desk

import aioduco.sync
from aioduco import Joints
from aioduco.testing import eventually

HOME = Joints(0, 0, 1.5, 0, -1.5, 0)


class Interrupts(Protocol):
    """Sends Ctrl-C when a condition holds, and again for each further one."""

    def __call__(self, *conditions: Callable[[], object]) -> AbstractContextManager[None]: ...


@pytest.fixture
def desk() -> Iterator[Desk]:
    with Desk() as desk:
        yield desk


@pytest.fixture
def robot(desk: Desk) -> Iterator[aioduco.sync.Robot]:
    with aioduco.sync.connect(desk.host, desk.port, hold_limit=0.2) as robot:
        yield robot


@contextmanager
def meanwhile(*steps: Callable[[], object]) -> Iterator[None]:
    """Do something in another thread while the block waits."""

    def run() -> None:
        for step in steps:
            step()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        thread.join()


@contextmanager
def raised_by_ctrl_c(kind: type[BaseException]) -> Iterator[None]:
    """Let a signal handler raise another error, as one for SIGTERM that calls sys.exit does."""

    def raises(*_: object) -> None:
        raise kind

    before = signal.signal(signal.SIGINT, raises)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.fixture
def interrupts() -> Interrupts:
    def ctrl_c(condition: Callable[[], object]) -> Callable[[], None]:
        def send() -> None:
            eventually(condition)
            os.kill(os.getpid(), signal.SIGINT)

        return send

    return lambda *conditions: meanwhile(*map(ctrl_c, conditions))
