from __future__ import annotations

import contextlib
import math
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import pytest

from aioduco._wire.connection import Connection
from aioduco._wire.rpc import Op, RpcClient
from aioduco.sim.simulator import Simulator

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from concurrent.futures import Future


class Program(RpcClient):
    """A client that blocks, as the vendor's: every function, on one connection."""

    def __init__(self, connection: Connection) -> None:
        super().__init__(lambda name, args: connection.call(name, args, 30.0))
        self.connection = connection

    def to(self, *joints: float, v: float = 1.0, r: float = 0.0, block: bool = True) -> int:
        """movej2, with what most tests do not care about left out."""
        return self.movej2(joints, v, 2.0, r, block, Op(), False)

    def line(self, pose: list[float], *, v: float = 0.2, r: float = 0.0, block: bool = True) -> int:
        """movel, likewise."""
        return self.movel(pose, v, 1.0, r, [], "", "", block, Op(), False)

    def bring_up(self) -> None:
        assert self.power_on(True) == 4
        assert self.enable(True) == 4


@pytest.fixture
def sim() -> Iterator[Simulator]:
    """A simulator that runs as fast as it can."""
    with Simulator(speed=math.inf) as sim:
        yield sim


@pytest.fixture
def connect() -> Iterator[Callable[..., Program]]:
    """Open programs' connections to a simulator; they are closed at the end."""
    with contextlib.ExitStack() as stack:

        def connect(sim: Any) -> Program:
            connection = Connection(sim.host, sim.port)
            connection.open()
            stack.callback(connection.close)
            return Program(connection)

        yield connect


@pytest.fixture
def aside() -> Iterator[Callable[..., Future[Any]]]:
    """Run a call in a thread with a connection of its own, as programs have to."""
    with ThreadPoolExecutor() as pool:

        def run(sim: Simulator, call: Callable[[Program], Any]) -> Any:
            connection = Connection(sim.host, sim.port)
            connection.open()
            try:
                return call(Program(connection))
            finally:
                connection.close()

        yield lambda sim, call: pool.submit(run, sim, call)


@pytest.fixture
def robot(sim: Simulator, connect: Callable[..., Program]) -> Program:
    """A program whose robot is enabled."""
    program = connect(sim)
    program.bring_up()
    return program
