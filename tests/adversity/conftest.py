"""Options for the number of faults and the seed, and the leak check of a module."""

from __future__ import annotations

from collections.abc import Iterator
from queue import SimpleQueue

import pytest

from aioduco._process.platform import missing_guard_features
from aioduco.sim import Simulator
from aioduco.supervision.guard.client import shared
from aioduco.supervision.guard.messages import Release
from aioduco.testing import no_leaks

from .arm import ready

#: tests among which the faults are divided
PARTS = 10


@pytest.fixture
def seed(request: pytest.FixtureRequest) -> int:
    """The seed of this run."""
    number = request.config.getoption("seed")
    assert isinstance(number, int)
    return number


@pytest.fixture
def sim() -> Iterator[Simulator]:
    """A simulated arm that is ready to move; when the test is over, nothing is left of it."""
    with no_leaks(), ready() as sim:
        yield sim


@pytest.fixture
def faults(request: pytest.FixtureRequest) -> int:
    """How many faults one of the parts puts on the wire."""
    number = request.config.getoption("faults")
    assert isinstance(number, int)
    return max(1, number // PARTS)


@pytest.fixture(scope="module")
def guards() -> Iterator[None]:
    """All robots of a module with a guard have the same: it is started once.

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
