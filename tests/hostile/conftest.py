"""A controller without an arm, of which nothing is left behind."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from client.bench import Bench
from wire.conftest import names

from aioduco.testing import no_leaks

__all__ = ["bench", "names"]


@pytest.fixture
def bench() -> Iterator[Bench]:
    with no_leaks(), Bench() as bench:
        yield bench
