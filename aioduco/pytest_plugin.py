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

The robots' times go by the simulator's clock. Unless a test asks for one, neither MuJoCo nor
Thrift is loaded for them. The fixture `duco_robot` is a coroutine: it needs pytest-asyncio, in any
mode, or anyio's own plugin.
"""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator, Mapping

    from aioduco.preflight import PreflightReport
    from aioduco.robot import Robot
    from aioduco.sim import Simulator
    from aioduco.sync import Robot as SyncRobot
    from aioduco.testing import FaultProxy

__all__ = [
    "duco_preflight",
    "duco_proxy",
    "duco_robot",
    "duco_simulator",
    "duco_simulator_options",
    "duco_sync_robot",
]


def _async_fixture() -> Callable[[Any], Any]:
    """pytest-asyncio does not see a plain fixture in its strict mode, which is its default."""
    if importlib.util.find_spec("pytest_asyncio") is None:
        return pytest.fixture
    import pytest_asyncio  # noqa: PLC0415 - it may be missing

    return pytest_asyncio.fixture


@pytest.fixture
def duco_simulator_options() -> Mapping[str, Any]:
    """How `duco_simulator` is made: override it to have another arm, or another clock.

        @pytest.fixture
        def duco_simulator_options():
            return {"model": "gcr20_1100", "speed": 5.0}

    Returns:
        Arguments of `aioduco.sim.Simulator`. By default the clock is as fast as the machine
        allows: a motion of a second takes some hundredths. A test that interrupts a motion in
        its middle wants one that is slower.
    """
    return {"speed": float("inf")}


@pytest.fixture
def duco_simulator(duco_simulator_options: Mapping[str, Any]) -> Iterator[Simulator]:
    """A simulated controller with its arm, powered off, on a port of its own."""
    from aioduco.sim import Simulator  # noqa: PLC0415 - it brings MuJoCo

    with Simulator(**duco_simulator_options) as simulator:
        yield simulator


@pytest.fixture
def duco_proxy(duco_simulator: Simulator) -> Iterator[FaultProxy]:
    """A fault proxy before the simulated controller; without faults until a test adds one."""
    from aioduco.testing import FaultProxy  # noqa: PLC0415 - not for who has no need of it

    with FaultProxy(duco_simulator.host, duco_simulator.port) as proxy:
        yield proxy


def _line(request: pytest.FixtureRequest, simulator: Simulator) -> Simulator | FaultProxy:
    """What is connected to: the simulated controller, or the proxy if the test has one."""
    if "duco_proxy" in request.fixturenames:
        proxy: FaultProxy = request.getfixturevalue("duco_proxy")
        return proxy
    return simulator


@_async_fixture()
async def duco_robot(
    request: pytest.FixtureRequest, duco_simulator: Simulator
) -> AsyncIterator[Robot]:
    """A robot connected to the simulated controller, ready to move.

    It is connected by way of `duco_proxy` if the test asks for that too. After the test its arm
    is stopped, and the connections closed.
    """
    from aioduco import connect  # noqa: PLC0415 - not for who has no need of it

    line = _line(request, duco_simulator)
    async with connect(line.host, line.port, clock=duco_simulator.clock) as robot:
        await robot.bring_up()
        yield robot


@pytest.fixture
def duco_sync_robot(
    request: pytest.FixtureRequest, duco_simulator: Simulator
) -> Iterator[SyncRobot]:
    """The same for programs that wait: a robot of `aioduco.sync`, ready to move."""
    from aioduco.sync import connect  # noqa: PLC0415 - not for who has no need of it

    line = _line(request, duco_simulator)
    with connect(line.host, line.port, clock=duco_simulator.clock) as robot:
        robot.bring_up()
        yield robot


@pytest.fixture
def duco_preflight() -> Callable[..., PreflightReport]:
    """`aioduco.preflight.preflight`, with settings as keywords: `duco_preflight(file, scene=cell)`.

    It takes the program's file, then its arguments as a list; the report's `ok` and `findings` tell
    what would go wrong.
    """
    from aioduco.preflight import PreflightSettings, preflight  # noqa: PLC0415 - brings MuJoCo

    def run(program: str, arguments: tuple[str, ...] = (), **settings: Any) -> PreflightReport:
        return preflight(program, arguments, PreflightSettings(**settings), quiet=True)

    return run
