"""How many faults, from which seed."""

from __future__ import annotations

import pytest

#: tests among which the faults are divided
PARTS = 10


@pytest.fixture
def seed(request: pytest.FixtureRequest) -> int:
    """The seed of this run."""
    number = request.config.getoption("seed")
    assert isinstance(number, int)
    return number


@pytest.fixture
def faults(request: pytest.FixtureRequest) -> int:
    """How many faults one of the parts puts on the wire."""
    number = request.config.getoption("faults")
    assert isinstance(number, int)
    return max(1, number // PARTS)
