"""Options of the whole suite."""

from __future__ import annotations

import os
from collections import Counter
from typing import Any

import pytest
from hypothesis import settings

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
    group.addoption(
        "--frames",
        type=int,
        default=3_000,
        metavar="N",
        help="frames that tests/sim/test_hostile.py sends to the server (default: %(default)s)",
    )
    group.addoption(
        "--frames-json", metavar="FILE", help="where that test writes what came of them"
    )


def pytest_report_header(config: pytest.Config) -> str:
    return f"adversity: {config.getoption('faults')} faults, seed {config.getoption('seed')}"


# What the adversity tests did, counted. Here and not beside them: where tests are spread over
# processes, the one that reports reads no other conftest than this.

_totals = pytest.StashKey[Counter[str]]()


def _counted(config: pytest.Config) -> Counter[str]:
    return config.stash.setdefault(_totals, Counter())


@pytest.fixture
def totals(request: pytest.FixtureRequest) -> Counter[str]:
    """Counts over all tests, said at the end."""
    return _counted(request.config)


def pytest_sessionfinish(session: pytest.Session) -> None:
    output: dict[str, Any] | None = getattr(session.config, "workeroutput", None)
    if output is not None:
        output["adversity"] = dict(_counted(session.config))


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    _counted(node.config).update(getattr(node, "workeroutput", {}).get("adversity", {}))


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    if totals := _counted(config):
        said = ", ".join(f"{number} {what}" for what, number in sorted(totals.items()))
        terminalreporter.write_line(f"adversity, seed {config.getoption('seed')}: {said}")
