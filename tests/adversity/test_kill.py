"""A program that is killed, frozen, interrupted or hangs leaves a standing arm."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
from contextlib import contextmanager
from functools import partial
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
#: s of simulated time in which an arm at 0.3 rad/s with 4 rad/s² comes to rest, amply
BRAKING = 0.6


@pytest.fixture
def sim() -> Iterator[Simulator]:
    # as fast as the wall: heartbeats are
    with no_leaks(), Simulator(speed=1.0) as sim:
        yield sim


@contextmanager
def running(
    sim: Simulator, end: str = "never", heartbeat: float = HEARTBEAT
) -> Iterator[subprocess.Popen[bytes]]:
    """The program in a process of its own, from its first motion on."""
    options = [sim.host, str(sim.port), str(heartbeat), end]
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
    with running(sim, "hang") as child:
        began = sim.time
        stands_soon(sim, began + HEARTBEAT)
        assert child.wait() != 0
        assert idle(sim), unrest(sim)


@pytest.mark.parametrize("end", ["error", "leave"])
def test_the_arm_stands_when_a_program_that_fails_has_ended(sim: Simulator, end: str) -> None:
    with running(sim, end) as child:
        assert child.wait() != 0
        # at once: the program saw it stand
        assert idle(sim), unrest(sim)
        assert not sim.moving


@pytest.mark.parametrize("end", ["vanish", "forget"])
def test_the_arm_stands_after_a_program_that_did_not_close(sim: Simulator, end: str) -> None:
    with running(sim, end) as child:
        child.wait()
        began = sim.time
        eventually(lambda: sim.connections == 0)
        stands_soon(sim, began)


def interrupt(sim: Simulator, child: subprocess.Popen[bytes], gaps: tuple[float, ...]) -> None:
    """Press Ctrl-C once after each of these times, and wait for the end of the program."""
    for gap in gaps:
        due = sim.time + gap
        sim.wait_until(partial(_later, sim, due))
        child.send_signal(signal.SIGINT)
    assert child.wait() != 0


def _later(sim: Simulator, due: float) -> bool:
    return sim.time >= due


@pytest.mark.parametrize("gaps", [(0.0,), (0.2,), (0.0, 0.0), (0.1, 0.003), (0.0, 0.02)])
def test_the_arm_stands_when_an_interrupted_program_has_ended(
    sim: Simulator, gaps: tuple[float, ...]
) -> None:
    with running(sim) as child:
        interrupt(sim, child, gaps)
        assert idle(sim), unrest(sim)
        assert not sim.moving


def test_the_arm_stands_after_a_program_that_was_interrupted_thrice(sim: Simulator) -> None:
    """The third interrupt breaks the event loop itself; the stop has been sent by then."""
    with running(sim) as child:
        interrupt(sim, child, (0.1, 0.001, 0.003))
        stands_soon(sim, sim.time)
