"""Options of the whole suite, and how much of it is run.

Without options every kind of test runs, with a few of its cases: see `quick.py`. With `--thorough`
all of them run, with all of their cases.
"""

from __future__ import annotations

import contextlib
import gc
import os
import signal
import sys
from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from importlib import import_module
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

import pytest
import quick
from hypothesis import HealthCheck, settings

# Before anything of the package is imported: what it sees of the platform is taken away here, and
# in all children by PYTHONPATH.
BARE = Path(__file__).parent / "bare"
if "--bare-platform" in sys.argv or "AIODUCO_TESTS_BARE" in os.environ:
    sys.path.insert(0, str(BARE))
    if "AIODUCO_TESTS_BARE" not in os.environ:
        paths = [str(BARE), *filter(None, [os.environ.get("PYTHONPATH")])]
        os.environ["PYTHONPATH"] = os.pathsep.join(paths)
    import_module("bare_platform").install()
    # Of Python's shared memory on Linux, and of none on Windows: no test is to have left it.
    resource_tracker.ensure_running()

from ports import give_each_once  # noqa: E402 - see above

# The tests start hundreds of programs. Where Python is told to keep no bytecode, each of them would
# compile all that it imports.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Threads of NumPy's algebra, which nothing here has a use for, take longer to start and to end than
# NumPy to load, in each of some hundred processes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# MuJoCo loads what draws, which takes as long as the rest of it: see aioduco/_process/spawn.py.
os.environ.setdefault("MUJOCO_GL", "disable")

# A shell without job control starts what it puts into the background with this signal ignored, and
# so would all programs of the tests, some of which are interrupted.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

#: what a test may not leave changed: the programs that later tests start would inherit it
_SIGNALS = [
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGCHLD", "SIGPIPE")
    if hasattr(signal, name)
]


@pytest.fixture
def hangups() -> Iterator[None]:
    """Programs are told of a hang-up also where the tests themselves are not, as under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


_FAULTS = {False: 300, True: 2_000}
_FRAMES = {False: 300, True: 3_000}


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--thorough",
        action="store_true",
        help="run all cases of all tests, which takes minutes; without it a few of each",
    )
    parser.addoption(
        "--share",
        type=quick.share,
        metavar="K/N",
        help="run the Kth of N shares of the cases alone, always the same ones: by turns, N runs "
        "take all of them",
    )
    parser.addoption(
        "--bare-platform",
        action="store_true",
        help="run without what Windows lacks, see tests/bare: no memory files, no poll, no sends "
        "that do not wait, no forks, no inherited descriptors, an event loop of select",
    )
    parser.addoption(
        "--late",
        type=float,
        metavar="S",
        help="answer calls so much later where a simulator has no clock, see tests/late.py: a test "
        "that fails then depends on how busy the machine is",
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
        "--frames-save", action="store_true", help="keep what came of them in benchmarks/results"
    )


#: whether each process collects a part of the files, and which
_divided, _own = pytest.StashKey[bool](), pytest.StashKey[set[Path]]()
#: whether simulators have a user's cycle now
_real = pytest.StashKey[bool]()


def pytest_configure(config: pytest.Config) -> None:
    all_of_it: bool = config.getoption("thorough")
    if getattr(config.option, "dist", "no") == "no":  # not where others run the tests
        _prepare(all_of_it=all_of_it, late=config.getoption("late"))
    if getattr(config.option, "dist", "no") == "load":
        # Of all files, each process collects and runs its part alone: to import all of them takes
        # as long as to run a fifth of the quick tests. Otherwise each takes neighbours, so that a
        # fixture of a module is made once or twice, and at the end those that another one has left.
        config.stash[_divided] = _all_files(config) and not all_of_it
        config.option.dist = "each" if config.stash[_divided] else "worksteal"
        if config.stash[_divided]:
            config.pluginmanager.register(_Progress())
    for option, number in (("faults", _FAULTS), ("frames", _FRAMES)):
        if config.getoption(option) is None:
            setattr(config.option, option, number[all_of_it])
    # An example that takes long on a busy machine is no failure; the time-out of the test is
    # enough. What decides over a change draws the same examples each time; at the desk they vary.
    options: dict[str, Any] = {
        "deadline": None,
        "suppress_health_check": [HealthCheck.too_slow],
        **({"derandomize": True, "database": None} if os.environ.get("CI") else {}),
    }
    _draw_no_constants()
    settings.register_profile("quick", max_examples=10, **options)
    settings.register_profile("thorough", max_examples=100, **options)
    settings.load_profile("thorough" if all_of_it else "quick")


def _prepare(*, all_of_it: bool, late: float | None) -> None:
    """Change what robots and simulators of this process have by default."""
    import_module("patient").be_patient()
    if late is not None:
        import_module("late").answer_late(late)
    give_each_once()
    times = import_module("cycle_time")
    times.set_power_times(times.SHORT)
    if not all_of_it:
        times.set_cycle(times.COARSE)


def _draw_no_constants() -> None:
    """Let Hypothesis draw no numbers and texts that it finds in the modules which are loaded.

    It parses all of them in each process. The examples would depend on what is loaded, and so on
    which tests a process has run before.
    """
    with contextlib.suppress(ImportError, KeyError):  # no part of its interface
        providers = import_module("hypothesis.internal.conjecture.providers")
        none = type(vars(providers)["_local_constants"])()
        vars(providers)["_get_local_constants"] = lambda: none


@pytest.hookimpl(tryfirst=True)
def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Make no cases that the quick run leaves out: of some tables there are thousands."""
    if not metafunc.config.getoption("thorough"):
        quick.spread_cases(metafunc)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("bare_platform"):
        for item in items:
            for mark in item.iter_markers("linux"):
                item.add_marker(pytest.mark.skip(f"this platform lacks: {mark.args[0]}"))
    kept, left = (items, []) if config.getoption("thorough") else quick.divided(items)
    if (share := config.getoption("share")) is not None:
        left += [item for item in kept if not quick.in_share(item.nodeid, *share)]
        kept = [item for item in kept if quick.in_share(item.nodeid, *share)]
    if left:
        config.hook.pytest_deselected(items=left)
    if _is_divided(config):
        items[:] = kept
        return
    items[:] = quick.slow_first(kept, int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """In the thorough run, have the cycle for a test's folder before any fixture is made."""
    if not item.config.getoption("thorough"):
        return
    times = import_module("cycle_time")
    many = item.config.getoption("faults") > _FAULTS[True]  # as .ci/adversity has them
    real = item.nodeid.removeprefix("tests/").startswith(times.REAL + ("adversity/",) * many)
    if item.config.stash.get(_real, None) is not real:
        item.config.stash[_real] = real
        times.set_cycle(times.FINE if real else times.COARSE)


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Generator[None, object, object]:
    """Keep Python's search for garbage away from the tests themselves, half a million objects.

    While they are collected it would find nothing, and take a fifth of the time. Afterwards it
    would take a busy machine more than a second each time, in which no event loop runs.
    """
    gc.disable()
    try:
        if not _is_divided(session.config):
            _import_own_files(session.config)
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def _all_files(config: pytest.Config) -> bool:
    return [Path(__file__).parent] == [config.rootpath / each for each in config.args]


def _own_files(config: pytest.Config) -> Sequence[Path]:
    """A part of the files of tests, where several processes run all of them."""
    given: dict[str, Any] = getattr(config, "workerinput", {})
    if not given or not _all_files(config):
        return []
    number, processes = int(given["workerid"].removeprefix("gw")), given["workercount"]
    folder = Path(__file__).parent
    times = {
        file: file.stat().st_size * quick.wait(file.relative_to(folder).as_posix())
        for file in sorted(folder.rglob("test_*.py"))
    }
    return quick.part(times, number, processes)


def _is_divided(config: pytest.Config) -> bool:
    return bool(getattr(config, "workerinput", {}).get("divided"))


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    node.workerinput["divided"] = node.config.stash.get(_divided, False)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave to the other processes what is theirs, where each collects a part of the files."""
    if not _is_divided(config) or collection_path.is_dir():
        return None
    if _own not in config.stash:
        config.stash[_own] = set(_own_files(config))
    return None if collection_path in config.stash[_own] else True


class _Progress:
    """Shows how much of all has been run, where xdist would show it of what one process has."""

    def __init__(self) -> None:
        self._all = 0
        self._session: Any = None

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, node: Any, ids: list[str]) -> None:
        self._all += len(ids)
        self._session = node.config.pluginmanager.getplugin("session")

    def pytest_runtest_logstart(self) -> None:
        self._session.testscollected = self._all


def _import_own_files(config: pytest.Config) -> None:
    """Import these first where each process imports all files.

    So each compiles a part of them, and finds the others compiled: in a fresh clone half of the
    time of collecting.
    """
    for path in _own_files(config):
        name = ".".join(path.relative_to(Path(__file__).parent).with_suffix("").parts)
        with contextlib.suppress(Exception, pytest.skip.Exception):  # collecting it reports that
            import_module(name)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A test that asks for what this platform or this Python lacks is skipped with its words."""
    report = yield
    if report.failed and call.excinfo is not None:
        bare: bool = item.config.getoption("bare_platform")
        why = _lacking(call.excinfo.value, bare)
        if why:
            report.outcome = "skipped"
            report.longrepr = (str(item.path), item.location[1] or 0, f"Skipped: {why}")
    return report


def _lacking(error: BaseException, bare: bool) -> str:
    """What was said by a robot that was to have a guard on a platform without one, or a planner."""
    if isinstance(error, BaseExceptionGroup):
        return next(filter(None, (_lacking(each, bare) for each in error.exceptions)), "")
    # Of a process of the test, or beside what the test waited for, it is quoted.
    if bare and "process needs Linux, and this system has no packets" in str(error):
        return "a guard's process needs Linux"
    if sys.version_info >= (3, 14) and "ompl" in str(error):
        return "OMPL has no build for this Python"
    return ""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """`-n auto`: more than the processors, since tests wait for an arm or an answer.

    Of the quick ones few do, and each process takes some seconds to start.
    """
    return quick.processors() + (4 if config.getoption("thorough") else 2)


@pytest.fixture(autouse=True)
def signals_as_before() -> Generator[None]:
    """A test that leaves a signal ignored or handled fails, and not one of those after it."""
    before = {number: signal.getsignal(number) for number in _SIGNALS}
    yield
    after = {number: signal.getsignal(number) for number in _SIGNALS}
    for number in _SIGNALS:
        if after[number] is not before[number]:
            signal.signal(number, before[number])
    assert after == before


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
        output["totals"] = dict(_counted(session.config))


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    _counted(node.config).update(getattr(node, "workeroutput", {}).get("totals", {}))


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    if totals := _counted(config):
        said = ", ".join(f"{number} {what}" for what, number in sorted(totals.items()))
        terminalreporter.write_line(f"seed {config.getoption('seed')}: {said}")
