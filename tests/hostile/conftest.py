"""A controller without an arm, of which nothing is left behind."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from client.bench import Bench

from aioduco.testing import no_leaks


@pytest.fixture
def bench() -> Iterator[Bench]:
    with no_leaks(), Bench() as bench:
        yield bench
