"""What is tested with and without the guard."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from queue import SimpleQueue

import pytest

from aioduco._process.platform import missing_guard_features
from aioduco.supervision.guard.client import shared
from aioduco.supervision.guard.messages import Release

#: a test that is run without the guard, and with it
BOTH = pytest.mark.parametrize("guard", [None, "process"], ids=["alone", "guard"])


@contextmanager
def one_guard() -> Iterator[None]:
    """While this lasts, all robots with a guard have the same: it is started once.

    Where there can be none, tests without it are run all the same.
    """
    if missing_guard_features():
        yield
        return
    link = shared.acquire()
    try:
        answers: SimpleQueue[str | None] = SimpleQueue()
        # it answers to what it does not know, too, as soon as it runs
        assert link.ask(lambda token: Release(0, token), answers.put)
        assert answers.get(timeout=30.0) is not None
        yield
    finally:
        shared.release(link)
