"""Fixtures for tests of programs that drive an arm. pytest finds them by itself.

    async def test_the_part_is_released(duco_robot, duco_simulator):
        await my_program.release(duco_robot)
        assert not duco_simulator.get_digital_output(1)

    async def test_a_lost_reply_is_no_second_motion(duco_robot, duco_proxy):
        duco_proxy.on("movej2", Cut(Place.BEFORE_REPLY))
        with pytest.raises(OutcomeUnknown):
            await my_program.home(duco_robot)
        assert len(duco_proxy.calls("movej2")) == 1

    def test_a_program_that_waits(duco_sync_robot, duco_simulator):
        my_plain_program.home(duco_sync_robot)
        assert not duco_simulator.moving

    def test_the_program_is_good(duco_preflight):
        assert duco_preflight("program.py", ["192.168.1.10"]).ok

    @pytest.mark.duco_model("gcr20_1100")
    @pytest.mark.duco_speed(5.0)
    @pytest.mark.duco_fault("movej2", Cut(Place.BEFORE_REPLY))
    async def test_it_is_said_who_is_asked(duco_robot):
        ...

The robots measure times by the simulator's clock. MuJoCo and Thrift are loaded only if a test asks
for a robot. The fixture `duco_robot` is a coroutine: it needs pytest-asyncio, in any mode, or
anyio's own plugin, beside which pytest-asyncio is not in auto mode. It belongs to the event loop
of pytest-asyncio's `asyncio_default_fixture_loop_scope`: set that to the scope of the tests' loop.

`pytest --duco-host 192.168.1.10` runs the same tests on an arm, slowly. Tests that need the
simulated controller, to inspect it or to inject a fault, are skipped there. A test that fails
leaves a recording of its arm, its events and log lines, last states, plots, and a picture.
"""

from __future__ import annotations

import contextlib
import importlib.util
import re
import shutil
import time
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Generator, Iterator, Mapping

    from aioduco.models.controller_clock import Clock
    from aioduco.robot import Robot
    from aioduco.sim import Simulator
    from aioduco.supervision.state_feed import Snapshot
    from aioduco.sync import Robot as SyncRobot
    from aioduco.testing import FaultProxy
    from aioduco.testing.preflight import PreflightReport

__all__ = [
    "duco_preflight",
    "duco_proxy",
    "duco_robot",
    "duco_robot_options",
    "duco_simulator",
    "duco_simulator_options",
    "duco_sync_robot",
]

_MARKERS = (
    "duco_model(name): the simulated arm of this test, such as gcr20_1100",
    "duco_speed(factor): how fast the simulated clock runs, of the wall's; inf by default",
    "duco_fault(function, fault, times=1, skip=0): what a proxy does to calls of a function",
)
_failed = pytest.StashKey[bool]()
_LAST_LOOK = 1.0  #: seconds that a failed test waits for a last sample of its arm


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add options for tests on an arm, and for the files that failed tests leave."""
    group = parser.getgroup("duco", "DUCO arms")
    group.addoption(
        "--duco-host",
        metavar="HOST[:PORT]",
        help="run tests of robots on this arm instead of a simulated one: it will move",
    )
    group.addoption(
        "--duco-model", metavar="NAME", help="which arm that is, for tests that name a model"
    )
    group.addoption(
        "--duco-host-speed",
        type=float,
        default=10.0,
        metavar="PERCENT",
        help="global speed of that arm during a test; it is put back (default: %(default)s)",
    )
    group.addoption(
        "--duco-artefacts",
        metavar="DIR",
        help="where failed tests leave what is known of their arms (default: pytest's own folder "
        "for temporary files)",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Register the markers; refuse tests on one arm from several processes."""
    for line in _MARKERS:
        config.addinivalue_line("markers", line)
    host = config.getoption("duco_host", None)
    if host is None:
        return
    _address(host)
    _check_arm(config)
    workers = getattr(config.option, "numprocesses", None)
    if workers or hasattr(config, "workerinput"):
        raise pytest.UsageError("--duco-host: tests on one arm run one after the other, without -n")


def _address(text: str) -> tuple[str, int]:
    """Host and port of the arm."""
    from aioduco.errors import ParameterError  # noqa: PLC0415
    from aioduco.models.address import PORT, parse_address  # noqa: PLC0415 - for an arm alone

    try:
        host, port = parse_address(text, name="--duco-host")
    except ParameterError as error:
        raise pytest.UsageError(str(error)) from None
    return host, port or PORT


def _check_arm(config: pytest.Config) -> None:
    """Refuse a model or a speed that no arm has, before an arm is brought up."""
    from aioduco.errors import ParameterError  # noqa: PLC0415 - for an arm alone
    from aioduco.kinematics import arm  # noqa: PLC0415
    from aioduco.models.ranges import GLOBAL_SPEED  # noqa: PLC0415

    model: str | None = config.getoption("duco_model")
    try:
        if model is not None:
            arm(model)
        GLOBAL_SPEED("--duco-host-speed", config.option.duco_host_speed)
    except ParameterError as error:
        raise pytest.UsageError(str(error)) from None


def pytest_report_header(config: pytest.Config) -> str | None:
    """Return a line that says which arm will move."""
    host = config.getoption("duco_host")
    speed = config.getoption("duco_host_speed")
    return (
        f"duco: the arm at {host} will move, at {speed:g} % of its speed"
        if host is not None
        else None
    )


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, None]:
    """Record whether a test failed, for its fixtures."""
    outcome = yield
    report = outcome.get_result()
    before = report.when != "setup" and item.stash.get(_failed, False)  # another run begins anew
    item.stash[_failed] = before or report.failed


def _async_fixture() -> Callable[[Any], Any]:
    """Return a fixture decorator: pytest-asyncio ignores plain ones in strict mode, its default."""
    if importlib.util.find_spec("pytest_asyncio") is None:
        return pytest.fixture
    import pytest_asyncio  # noqa: PLC0415 - it may be missing

    return pytest_asyncio.fixture


@pytest.fixture
def duco_simulator_options() -> Mapping[str, Any]:
    """Arguments of `duco_simulator`: override them to have another arm, or another clock.

        @pytest.fixture
        def duco_simulator_options():
            return {"model": "gcr20_1100", "speed": 5.0}

    Returns:
        Arguments of `aioduco.sim.Simulator`. By default the clock is as fast as the machine
        allows: a motion of one second takes some hundredths of a second. A test that interrupts
        a motion in its middle needs a slower clock.
    """
    return {"speed": float("inf")}


@pytest.fixture
def duco_robot_options() -> Mapping[str, Any]:
    """Arguments of `aioduco.connect` for robots of simulated arms: override them to test a time.

        @pytest.fixture
        def duco_robot_options():
            return {"heartbeat": 1.0}

    Returns:
        The arguments. By default times are long in which a busy computer beats the heart and gets
        an answer, so that it fails no test. How long the event loop may be blocked is as always.
    """
    return {"heartbeat": 20.0, "call_timeout": 10.0}


def _marked(request: pytest.FixtureRequest, name: str) -> Any:
    """Return the argument of a marker of the test; None without such a marker."""
    marker = request.node.get_closest_marker(name)
    if marker is None:
        return None
    if len(marker.args) != 1:
        raise pytest.UsageError(f"@pytest.mark.{name} takes one argument: it has {marker.args}")
    return marker.args[0]


def _has_fault(request: pytest.FixtureRequest) -> bool:
    return request.node.get_closest_marker("duco_fault") is not None


@pytest.fixture
def duco_simulator(
    request: pytest.FixtureRequest, duco_simulator_options: Mapping[str, Any]
) -> Iterator[Simulator]:
    """A simulated controller with its arm, powered off, on a port of its own."""
    if request.config.getoption("duco_host") is not None:
        pytest.skip("it needs the simulated arm, and --duco-host names another one")
    if _has_fault(request) and not {"duco_proxy", "_duco_line"} & {*request.fixturenames}:
        raise pytest.UsageError("@pytest.mark.duco_fault: the test connects past its duco_proxy")
    from aioduco.sim import Simulator  # noqa: PLC0415 - it loads MuJoCo

    options = dict(duco_simulator_options)
    for option, marker in (("model", "duco_model"), ("speed", "duco_speed")):
        value = _marked(request, marker)
        if value is not None:
            options[option] = value
    with Simulator(**options) as simulator:
        yield simulator


@pytest.fixture
def duco_proxy(request: pytest.FixtureRequest, duco_simulator: Simulator) -> Iterator[FaultProxy]:
    """A fault proxy before the simulated controller, with the faults of the test's markers."""
    from aioduco.testing import FaultProxy  # noqa: PLC0415 - only for tests that need it

    with FaultProxy(duco_simulator.host, duco_simulator.port) as proxy:
        for marker in request.node.iter_markers("duco_fault"):
            proxy.on(*marker.args, **marker.kwargs)
        yield proxy


class _Line:
    """The address of a test's robot, and the files that are left if the test fails.

    Args:
        request: pytest's request of the robot's fixture.
    """

    host: str
    port: int
    clock: Clock | None

    def __init__(self, request: pytest.FixtureRequest) -> None:
        self._request = request
        config = request.config
        self.simulator: Simulator | None = None
        address: str | None = config.getoption("duco_host")
        faults = _has_fault(request)
        if address is not None:
            if faults or "duco_proxy" in request.fixturenames:
                pytest.skip("it puts faults on the wire, which is not done to an arm")
            model = _marked(request, "duco_model")
            if model is None:
                model = request.getfixturevalue("duco_simulator_options").get("model")
            name: str | None = getattr(model, "name", model)  # an `Arm` has one
            if name not in (None, config.getoption("duco_model")):
                pytest.skip(f"it needs a {name}; --duco-model says which arm is there")
            (self.host, self.port), self.clock = _address(address), None
        else:
            simulator: Simulator = request.getfixturevalue("duco_simulator")
            self.simulator = simulator
            line: Simulator | FaultProxy = simulator
            if faults or "duco_proxy" in request.fixturenames:
                line = request.getfixturevalue("duco_proxy")
            self.host, self.port, self.clock = line.host, line.port, simulator.clock
        #: global speed of a real arm [%]; None for a simulated arm, whose speed is not changed
        self.speed: float | None = (
            config.getoption("duco_host_speed") if address is not None else None
        )
        self._folder = self._made_folder()
        self.options: dict[str, Any] = {}
        if self.clock is not None:
            self.options |= {"clock": self.clock, **request.getfixturevalue("duco_robot_options")}
        if importlib.util.find_spec("foxglove") is not None:
            from aioduco.testing.artefacts import RECORDING  # noqa: PLC0415 - as above

            self.options["record"] = self._folder / RECORDING

    def _made_folder(self) -> Path:
        node: str = self._request.node.nodeid
        name = re.sub(r"[^\w.-]+", "_", node)[-60:]
        base: str | None = self._request.config.getoption("duco_artefacts")
        if base is None:
            factory: pytest.TempPathFactory = self._request.getfixturevalue("tmp_path_factory")
            return factory.mktemp("duco-" + name)
        # by a number of its own: some names differ by signs alone
        folder = Path(base) / f"{name}-{zlib.crc32(node.encode(errors='replace')):08x}"
        # A recording of an earlier run would be kept, and taken for that of this one.
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    @property
    def keeps(self) -> bool:
        """Whether the test failed, so that the files about its arm are kept."""
        node: pytest.Item = self._request.node
        return node.stash.get(_failed, False)

    def leave(self) -> None:
        """Keep the files about the arm if the test failed, and delete them if not."""
        node: pytest.Item = self._request.node
        if not self.keeps:
            shutil.rmtree(self._folder, ignore_errors=True)
            return
        from aioduco.testing.artefacts import leave_artefacts  # noqa: PLC0415 - as above

        files = leave_artefacts(self._folder, self.simulator)
        node.add_report_section("teardown", "duco", f"{self._folder}: {', '.join(files)}")


def _later_than(moment: float) -> Callable[[Snapshot], bool]:
    """Return a predicate: whether a sample was received after `moment`, the end of the test."""
    return lambda sample: sample.status.received_at > moment


@pytest.fixture(name="_duco_line")
def _line_of_test(request: pytest.FixtureRequest) -> Iterator[_Line]:
    line = _Line(request)
    yield line
    line.leave()


@_async_fixture()
async def duco_robot(_duco_line: _Line) -> AsyncIterator[Robot]:
    """A robot, ready to move, connected to the simulated controller or to that of `--duco-host`.

    It connects through `duco_proxy` if the test uses that fixture, or has a fault. After the test
    its arm is stopped, and the connections are closed.
    """
    from aioduco import connect  # noqa: PLC0415 - only for tests that need it
    from aioduco.errors import DucoError  # noqa: PLC0415 - as above

    line = _duco_line
    async with connect(line.host, line.port, **line.options) as robot:
        await robot.bring_up()
        if line.speed is None:
            yield robot
        else:
            before = await robot.settings.get_global_speed()
            await robot.settings.speed(line.speed)
            try:
                yield robot
            finally:
                await robot.stop()  # what the test has left moving is not to go on faster
                await robot.settings.speed(before)
        if line.keeps:
            with contextlib.suppress(DucoError, TimeoutError):
                await robot.wait_for(_later_than(time.monotonic()), timeout=_LAST_LOOK)


@pytest.fixture
def duco_sync_robot(_duco_line: _Line) -> Iterator[SyncRobot]:
    """The same for blocking programs: a robot of `aioduco.sync`, ready to move."""
    from aioduco.errors import DucoError  # noqa: PLC0415 - only for tests that need it
    from aioduco.sync import connect  # noqa: PLC0415 - as above

    line = _duco_line
    with connect(line.host, line.port, **line.options) as robot:
        robot.bring_up()
        if line.speed is None:
            yield robot
        else:
            before = robot.settings.get_global_speed()
            robot.settings.speed(line.speed)
            try:
                yield robot
            finally:
                robot.stop()  # as above
                robot.settings.speed(before)
        if line.keeps:
            with contextlib.suppress(DucoError, TimeoutError):
                robot.wait_for(_later_than(time.monotonic()), timeout=_LAST_LOOK)


@pytest.fixture
def duco_preflight() -> Callable[..., PreflightReport]:
    """`preflight`, with settings as keywords: `duco_preflight(file, scene=cell)`.

    It takes the program's file, then its arguments as a list; the report's `ok` and `findings` say
    what would go wrong.
    """
    from aioduco.testing.preflight import PreflightSettings, preflight  # noqa: PLC0415 - loads MuJoCo

    def run(program: str, arguments: tuple[str, ...] = (), **settings: Any) -> PreflightReport:
        return preflight(program, arguments, PreflightSettings(**settings), quiet=True)

    return run
