"""Options of the whole suite, and how much of it is run.

Without options every test function runs, with a few of its cases: see `quick.py`. With `--thorough`
all of their cases run.
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
import quick
from hypothesis import settings
from patient import be_patient

_FAULTS = {False: 300, True: 10_000}
_FRAMES = {False: 300, True: 3_000}


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--thorough",
        action="store_true",
        help="run all cases of all tests, which takes minutes; without it a few of each",
    )
    parser.addoption(
        "--beyond",
        metavar="FILE",
        help="leave out what passed in another run, whose --junitxml this is: with --thorough all "
        "that the quick run leaves to it",
    )
    group = parser.getgroup("adversity", "faults on the wire, cancellations and kills")
    group.addoption(
        "--faults",
        type=int,
        metavar="N",
        help="faults that tests/adversity puts on the wire in all "
        f"(default: {_FAULTS[False]}, with --thorough {_FAULTS[True]})",
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
        metavar="N",
        help="frames that tests/sim/test_hostile.py sends to the server "
        f"(default: {_FRAMES[False]}, with --thorough {_FRAMES[True]})",
    )
    group.addoption(
        "--frames-json", metavar="FILE", help="where that test writes what came of them"
    )


def pytest_configure(config: pytest.Config) -> None:
    be_patient()
    all_of_it: bool = config.getoption("thorough")
    for option, number in (("faults", _FAULTS), ("frames", _FRAMES)):
        if config.getoption(option) is None:
            setattr(config.option, option, number[all_of_it])
    # An example that takes long on a busy machine is no failure; the time-out of the test is
    # enough. What decides over a change draws the same examples each time; at the desk they vary.
    same: dict[str, Any] = {"derandomize": True, "database": None} if os.environ.get("CI") else {}
    settings.register_profile("quick", deadline=None, max_examples=10, **same)
    settings.register_profile("thorough", deadline=None, max_examples=100, **same)
    settings.load_profile("thorough" if all_of_it else "quick")


@pytest.hookimpl(tryfirst=True)
def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Make no cases that the quick run leaves out: of some tables there are thousands."""
    if not metafunc.config.getoption("thorough"):
        quick.spread_cases(metafunc)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("thorough"):
        file = config.getoption("beyond")
        kept, left = (items, []) if file is None else quick.beyond(items, Path(file))
    else:
        kept, left = quick.divided(items)
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = kept


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """`-n auto`: more than the processors, since most tests wait for an arm or an answer."""
    return quick.processors() + 2


@pytest.fixture(scope="session")
def thorough(pytestconfig: pytest.Config) -> bool:
    """Whether all cases are run; a test that loops over them takes a few if not."""
    return bool(pytestconfig.getoption("thorough"))


def pytest_report_header(config: pytest.Config) -> str:
    option = config.getoption
    amount = "all cases (--thorough)" if option("thorough") else "a few cases of each test"
    return f"{amount}; {option('faults')} faults on the wire, seed {option('seed')}"


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
