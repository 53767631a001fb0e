"""What tests of the wire share: threads, and a name server."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from aioduco.testing import no_leaks

from .names import Names
from .servers import PATIENCE


@pytest.fixture
def background() -> Any:
    """Run something on a thread; its outcome when it has ended."""
    threads = []

    def start(work: Callable[[], Any]) -> Callable[[], Any]:
        outcome: list[Any] = []

        def run() -> None:
            try:
                outcome.append(work())
            except Exception as exc:
                outcome.append(exc)

        thread = threading.Thread(target=run)
        threads.append(thread)
        thread.start()

        def result() -> Any:
            thread.join(PATIENCE)
            assert not thread.is_alive()
            return outcome[0]

        return result

    yield start
    for thread in threads:
        thread.join(PATIENCE)


@pytest.fixture
def names(monkeypatch: pytest.MonkeyPatch) -> Iterator[Names]:
    """The only name server; when the test is over, no thread waits for it."""
    with no_leaks():
        made = Names(monkeypatch)
        yield made
        made.answers.set()
