"""A program that is killed, frozen, interrupted or hangs leaves a standing arm."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING

import pytest

from aioduco.sim import Simulator
from aioduco.testing import eventually, no_leaks

from . import program
from .arm import idle, unrest

if TYPE_CHECKING:
    from collections.abc import Iterator

#: s; the shortest that a controller takes
HEARTBEAT = 0.2
#: s of simulated time in which an arm at 0.5 rad/s with 4 rad/s² comes to rest, amply
BRAKING = 0.6


@pytest.fixture
def sim() -> Iterator[Simulator]:
    # as fast as the wall: heartbeats are
    with no_leaks(), Simulator(speed=1.0) as sim:
        yield sim


@contextmanager
def running(
    sim: Simulator, heartbeat: float = HEARTBEAT, hang: float = 0.0
) -> Iterator[subprocess.Popen[bytes]]:
    """The program in a process of its own, from its first motion on."""
    options = [sim.host, str(sim.port), str(heartbeat), str(hang)]
    with subprocess.Popen(
        [sys.executable, str(Path(program.__file__)), *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as child:
        try:
            assert _stream(child.stdout).readline() == b"moving\n", _stream(child.stderr).read()
            yield child
        finally:
            child.kill()
            _stream(child.stdout).close()
            _stream(child.stderr).close()


def _stream(stream: IO[bytes] | None) -> IO[bytes]:
    assert stream is not None
    return stream


def stands_soon(sim: Simulator, began: float) -> None:
    """The arm comes to rest within the heartbeat time, and the time that it takes to brake."""
    eventually(lambda: idle(sim) and not sim.moving, what=lambda: unrest(sim))
    assert sim.time - began < HEARTBEAT + BRAKING


@pytest.mark.parametrize("number", range(5))
def test_the_arm_stands_after_a_kill(sim: Simulator, seed: int, number: int) -> None:
    moment = random.Random(f"{seed}/{number}").uniform(0.0, 0.8)
    with running(sim) as child:
        began = sim.time
        sim.wait_until(lambda: sim.time >= began + moment)
        child.kill()
        child.wait()
        began = sim.time
        eventually(lambda: sim.connections == 0)
        stands_soon(sim, began)


def test_without_a_heartbeat_the_arm_goes_on(sim: Simulator) -> None:
    """What the other tests see is the heartbeat's doing."""
    with running(sim, heartbeat=0.0) as child:
        child.kill()
        child.wait()
        eventually(lambda: sim.connections == 0)
        began = sim.time
        sim.wait_until(lambda: sim.time > began + HEARTBEAT + BRAKING)
        assert not idle(sim)
        assert sim.moving


@pytest.mark.parametrize("number", range(2))
def test_the_arm_stands_while_the_program_is_frozen_and_after(
    sim: Simulator, seed: int, number: int
) -> None:
    moment = random.Random(f"{seed}/{number}").uniform(0.0, 0.5)
    with running(sim) as child:
        began = sim.time
        sim.wait_until(lambda: sim.time >= began + moment)
        child.send_signal(signal.SIGSTOP)
        began = sim.time
        stands_soon(sim, began)
        child.send_signal(signal.SIGCONT)
        # it finds its motion stopped, and must not go on as if nothing had been
        assert child.wait() != 0
        assert idle(sim), unrest(sim)
        assert not sim.moving


def test_the_arm_stands_while_the_event_loop_hangs(sim: Simulator) -> None:
    with running(sim, hang=1.5) as child:
        began = sim.time
        stands_soon(sim, began + HEARTBEAT)
        assert child.wait() != 0
        assert idle(sim), unrest(sim)


@pytest.mark.parametrize("times", [1, 2, 3])
def test_the_arm_stands_when_an_interrupted_program_has_ended(sim: Simulator, times: int) -> None:
    with running(sim) as child:
        for _ in range(times):
            child.send_signal(signal.SIGINT)
        assert child.wait() != 0
        assert idle(sim), unrest(sim)
        assert not sim.moving
