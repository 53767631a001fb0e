from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import pytest
from cycle_time import USUAL, set_cycle, set_power_times
from thriftpy2.thrift import TApplicationException
from thriftpy2.transport import TTransportException

from aioduco._wire.rpc import Op, RpcClient
from aioduco.errors import ConnectionLost, ControllerError
from aioduco.kinematics import Arm, arm, models
from aioduco.models.enums import TaskState
from aioduco.sim.simulator import CYCLE, Simulator

from .cycles import Cycles
from .raw import RawClient

#: types of the fixtures that are functions
Aside = Callable[..., Future[Any]]
Connect = Callable[[Any], "Program"]
Started = Callable[..., tuple[Simulator, "Program"]]

#: what a function of 1.3.7 answers to an argument out of its range (manual 1.3.7)
OUT_OF_RANGE = 0


@pytest.fixture(scope="module")
def real_cycle() -> Iterator[None]:
    """The cycle that a user's simulator has."""
    cycle = set_cycle(CYCLE)
    yield
    set_cycle(cycle)


@pytest.fixture
def real_power() -> Iterator[None]:
    """The times of power that a user's simulator has."""
    times = set_power_times(USUAL)
    yield
    set_power_times(times)


class Wire:
    """A connection that sends anything: what makes no sense, too, which the SDK's own refuses."""

    def __init__(self, sim: Any) -> None:
        self._client = RawClient(sim.port, timeout=30.0)

    def call(self, name: str, args: tuple[Any, ...]) -> Any:
        """Call a function; errors are those of the SDK."""
        try:
            return self._client.call(name, *args)
        except TApplicationException as exc:
            raise ControllerError(name, str(exc.message), exc.type) from exc
        except (OSError, EOFError, TTransportException) as exc:
            raise ConnectionLost(f"{name}: {exc!r}") from exc

    def close(self) -> None:
        self._client.close()


class Program(RpcClient):
    """A client that blocks, as the vendor's: every function, on one connection."""

    def __init__(self, connection: Wire) -> None:
        super().__init__(connection.call)
        self.connection = connection

    def to(self, *joints: float, v: float = 1.0, r: float = 0.0, block: bool = True) -> int:
        """movej2, with what most tests do not care about left out."""
        return self.movej2(joints, v, 2.0, r, block, Op(), False)

    def line(self, pose: list[float], *, v: float = 0.2, r: float = 0.0, block: bool = True) -> int:
        """movel, likewise."""
        return self.movel(pose, v, 1.0, r, [], "", "", block, Op(), False)

    def ended(self, id_: int) -> TaskState:
        """Wait until a task has ended; how it did."""
        assert id_ >= 1000
        while not (state := TaskState(self.get_noneblock_taskstate(id_))).ended:
            pass
        return state

    def bring_up(self) -> None:
        assert self.power_on(True) == 4
        assert self.enable(True) == 4


@contextlib.contextmanager
def a_program(sim: Any) -> Iterator[Program]:
    """A program with a connection of its own, in a block."""
    connection = Wire(sim)
    try:
        yield Program(connection)
    finally:
        connection.close()


@contextlib.contextmanager
def standing_time(sim: Simulator) -> Iterator[None]:
    """A block in which only `advance` moves simulated time.

    So that what is commanded, and what is read, is of one instant, however late the program's next
    call comes: a simulator without the clock goes through a motion of a second within milliseconds.
    """
    sim.lock_time()
    try:
        yield
    finally:
        sim.unlock_time()


def let_pass(sim: Simulator, seconds: float) -> None:
    """Wait for so much simulated time."""
    end = sim.time + seconds
    sim.wait_until(lambda: sim.time > end)


def advance_until(
    sim: Simulator, predicate: Callable[[], bool], timeout: float = 10.0, *, every: int = 1
) -> None:
    """Run cycles until a condition holds, while time is locked; it is checked at every so many."""
    end = sim.time + timeout
    while not predicate():
        assert sim.time < end, f"it did not come to hold within {timeout} s of simulated time"
        sim.advance(every)


@pytest.fixture(params=[arm(model) for model in models()], ids=lambda each: each.name)
def any_arm(request: pytest.FixtureRequest) -> Arm:
    """Each of the arms."""
    assert isinstance(request.param, Arm)
    return request.param


@pytest.fixture
def sim() -> Iterator[Simulator]:
    """A simulator that runs as fast as it can."""
    with Simulator(speed=math.inf) as sim:
        yield sim


@pytest.fixture
def started(connect: Connect) -> Iterator[Started]:
    """Start simulators, with a program whose arm is enabled, on the fast clock by default."""
    with contextlib.ExitStack() as stack:

        def start(*args: Any, **options: Any) -> tuple[Simulator, Program]:
            sim = stack.enter_context(Simulator(*args, **{"speed": math.inf, **options}))
            program = connect(sim)
            program.bring_up()
            return sim, program

        yield start


@pytest.fixture(scope="module")
def strict() -> Iterator[Program]:
    """A program whose arm is enabled, at a simulator that forgives nothing.

    One for all tests of a file: it refuses what they ask for, and is then as it was.
    """
    with Simulator(speed=math.inf, strict=True) as sim, a_program(sim) as program:
        program.bring_up()
        yield program
        assert sim.forgiven == {}


@pytest.fixture(scope="module")
def cell() -> Iterator[Simulator]:
    """One simulator for all tests of a file."""
    with Simulator(speed=math.inf) as sim:
        yield sim


@pytest.fixture
def program(cell: Simulator, connect: Connect) -> Program:
    """A program whose arm was switched off and on: nothing is under way."""
    program = connect(cell)
    program.power_off(True)
    program.bring_up()
    return program


@pytest.fixture
def connect() -> Iterator[Connect]:
    """Open programs' connections to a simulator; they are closed at the end."""
    with contextlib.ExitStack() as stack:
        yield lambda sim: stack.enter_context(a_program(sim))


@pytest.fixture
def aside() -> Iterator[Aside]:
    """Run a call in a thread with a connection of its own, as programs have to."""
    with ThreadPoolExecutor() as pool:

        def run(sim: Simulator, call: Callable[[Program], Any]) -> Any:
            with a_program(sim) as program:
                return call(program)

        yield lambda sim, call: pool.submit(run, sim, call)


@pytest.fixture
def cycles(monkeypatch: pytest.MonkeyPatch) -> Cycles:
    """What the drives are told and what the arm does from now on, cycle by cycle."""
    return Cycles(monkeypatch)


@pytest.fixture
def robot(sim: Simulator, connect: Connect) -> Program:
    """A program whose robot is enabled."""
    program = connect(sim)
    program.bring_up()
    return program
