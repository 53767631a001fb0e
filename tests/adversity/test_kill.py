"""A program that is killed or interrupted leaves a standing arm.

One that is frozen, hangs, or ends by itself: tests/shipped, tests/hostile and tests/supervision.
"""

from __future__ import annotations

import itertools
import os
import random
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO

import pytest

from aioduco.sim import Simulator
from aioduco.testing import eventually

from . import program
from .arm import idle, unrest

#: s; long enough for a busy machine to beat in time
HEARTBEAT = 1.0
#: s of simulated time in which the arm stands, amply: far from the heartbeat time of a program with
#: a guard. benchmarks/guard.py measures how soon
SOON = 10.0
#: s, more than a program takes to leave its robot
_LEAVING = 30.0
#: s within which a guard has ended: it stops the arm, sees it stand, and looks on whether it stays
#: at rest, each for up to its ABANDONED_LIMIT while a busy controller answers late
_GUARD_ENDS = 120.0


@dataclass(frozen=True)
class Watch:
    """Who watches over the program.

    With the guard the heartbeat is much longer than what the tests allow: if the arm stands in
    time, it is the guard's doing.
    """

    guard: str = ""
    heartbeat: float = HEARTBEAT

    def __str__(self) -> str:
        return "guard" if self.guard else "heartbeat" if self.heartbeat else "nobody"


BEAT = Watch()
NOBODY = Watch(heartbeat=0.0)
GUARD = Watch("process", heartbeat=60.0)
BOTH = pytest.mark.parametrize("watch", [BEAT, GUARD], ids=str)


@dataclass
class Running:
    """The program in a process of its own."""

    process: subprocess.Popen[bytes]
    guard: int

    def signal(self, number: int) -> None:
        """Send it a signal."""
        self.process.send_signal(number)

    def kill(self) -> None:
        """Kill it, and see it gone."""
        self.process.kill()
        self.process.wait()

    def hangs(self) -> bool:
        """Whether it has not ended for longer than it may take to leave its robot."""
        try:
            self.process.wait(_LEAVING)
        except subprocess.TimeoutExpired:
            return True
        return False

    def wait(self) -> int:
        """Its exit code, when it has ended."""
        return self.process.wait()


@contextmanager
def running(sim: Simulator, watch: Watch) -> Iterator[Running]:
    """The program in a process of its own, from its first motion on."""
    options = [sim.host, str(sim.port), str(watch.heartbeat), watch.guard]
    with subprocess.Popen(
        [sys.executable, str(Path(program.__file__)), *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as child:
        try:
            line = _stream(child.stdout).readline()
            assert line, _stream(child.stderr).read()
            yield Running(child, int(line))
        finally:
            child.kill()
            _stream(child.stdout).close()
            _stream(child.stderr).close()


def _stream(stream: IO[bytes] | None) -> IO[bytes]:
    assert stream is not None
    return stream


def stands_soon(sim: Simulator, began: float) -> None:
    """The arm comes to rest long before the heartbeat of a guarded program is missed."""
    eventually(lambda: idle(sim) and not sim.moving, what=lambda: unrest(sim))
    assert sim.time - began < SOON
    assert sim.joints[0] < program.LEFT[0] - 0.02, "it came to the end of its motion"


def at_a_moment(sim: Simulator, choice: str) -> None:
    """Let the arm move on for a while."""
    due = sim.time + random.Random(choice).uniform(0.0, 0.8)
    sim.wait_until(partial(_later, sim, due))


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize("number", range(2))
@BOTH
def test_the_arm_stands_after_a_kill(sim: Simulator, seed: int, watch: Watch, number: int) -> None:
    with running(sim, watch) as child:
        at_a_moment(sim, f"{seed}/{number}")
        child.kill()
        began = sim.time
        stands_soon(sim, began)
        eventually(lambda: sim.connections == 0, timeout=_GUARD_ENDS)


@pytest.mark.slow
def test_without_a_heartbeat_the_arm_goes_on(sim: Simulator) -> None:
    """What the other tests see is the heartbeat's doing, or the guard's."""
    with running(sim, NOBODY) as child:
        child.kill()
        eventually(lambda: sim.connections == 0)
        began = sim.time
        sim.wait_until(lambda: sim.time > began + 1.5 * HEARTBEAT)
        assert not idle(sim)
        assert sim.moving


@pytest.mark.slow
def test_the_arm_stands_after_a_kill_of_program_and_guard(sim: Simulator, seed: int) -> None:
    """The heartbeat ends with the guard; the program, frozen first, can do nothing."""
    with running(sim, Watch("process", HEARTBEAT)) as child:
        at_a_moment(sim, f"{seed}")
        child.signal(signal.SIGSTOP)
        began = sim.time
        with suppress(ProcessLookupError):  # one that has ended has stopped the arm
            os.kill(child.guard, signal.SIGKILL)
        stands_soon(sim, began)
        child.kill()


def _later(sim: Simulator, due: float) -> bool:
    return sim.time >= due


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gaps", "watch"),
    [
        ((0.0,), BEAT),
        ((0.2,), GUARD),
        ((0.0, 0.0), GUARD),
        ((0.1, 0.003), BEAT),
        ((0.1, 0.003), GUARD),
        ((0.0, 0.02), BEAT),
        *itertools.product([(0.1, 0.001, 0.003), (0.0, 0.0, 0.02, 0.002)], [NOBODY, GUARD]),
    ],
    ids=str,
)
def test_the_arm_stands_after_a_program_that_was_interrupted(
    sim: Simulator, gaps: tuple[float, ...], watch: Watch
) -> None:
    """By Ctrl-C after each of these times; the third breaks the event loop itself."""
    with running(sim, watch) as child:
        for gap in gaps:
            due = sim.time + gap
            sim.wait_until(partial(_later, sim, due))
            child.signal(signal.SIGINT)
        if len(gaps) > 1 and child.hangs():
            # as asyncio does, without this package too, if a second Ctrl-C loses a task's turn
            assert idle(sim), unrest(sim)
            assert not sim.moving, unrest(sim)
            child.signal(signal.SIGINT)
        assert child.wait() != 0
        # at once, as long as the loop lives: the program saw it stand
        assert len(gaps) > 2 or (idle(sim) and not sim.moving), unrest(sim)
        stands_soon(sim, sim.time)
