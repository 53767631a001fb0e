"""How many faults, from which seed; and how many it were."""

from __future__ import annotations

from collections import Counter

import pytest

#: tests among which the faults are divided
PARTS = 10

_totals = pytest.StashKey[Counter[str]]()


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


@pytest.fixture
def totals(request: pytest.FixtureRequest) -> Counter[str]:
    """Counts over all tests, said at the end."""
    return request.config.stash.setdefault(_totals, Counter())


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    totals = config.stash.get(_totals, Counter())
    if totals:
        said = ", ".join(f"{number} {what}" for what, number in sorted(totals.items()))
        terminalreporter.write_line(f"adversity, seed {config.getoption('seed')}: {said}")
