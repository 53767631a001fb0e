"""Options of the whole suite."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from hypothesis import settings

if TYPE_CHECKING:
    import pytest

# An example that takes long on a busy machine is no failure; the time-out of the test is enough.
settings.register_profile("aioduco", deadline=None)
# What decides over a change draws the same examples each time; at the desk they vary.
settings.register_profile("aioduco-ci", deadline=None, derandomize=True, database=None)
settings.load_profile("aioduco-ci" if os.environ.get("CI") else "aioduco")


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("adversity", "faults on the wire, cancellations and kills")
    group.addoption(
        "--faults",
        type=int,
        default=10_000,
        metavar="N",
        help="faults that tests/adversity puts on the wire in all (default: %(default)s)",
    )
    group.addoption(
        "--seed",
        type=int,
        default=1,
        metavar="N",
        help="seed of tests/adversity; another one makes other faults (default: %(default)s)",
    )


def pytest_report_header(config: pytest.Config) -> str:
    return f"adversity: {config.getoption('faults')} faults, seed {config.getoption('seed')}"
