"""An interrupt at any line leaves no program that hangs and no moving arm."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
import pytest
from client.bench import Bench

import aioduco
from aioduco.testing import eventually, no_leaks
from hostile import interrupted, interrupted_calls

#: s after which a program counts as hung
HUNG = 60.0


@pytest.fixture
def bench() -> Iterator[Bench]:
    with no_leaks(), Bench() as bench:
        bench.motion_time, bench.braking_time = 600.0, 0.1
        yield bench


@contextmanager
def interrupted_program(bench: Bench, where: str) -> Iterator[Callable[[int], str]]:
    """The program; a function that runs it once, and returns where it was interrupted, or ""."""
    with subprocess.Popen(
        [sys.executable, str(Path(interrupted.__file__)), bench.host, str(bench.port), where],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as program:
        stdin, stdout = program.stdin, program.stdout
        assert stdin is not None
        assert stdout is not None

        def run(number: int) -> str:
            print(number, file=stdin, flush=True)
            place, _, status = stdout.readline().partition(" ")
            assert int(status or program.wait()) != 0, f"{number}: {place}"
            eventually(lambda: not bench.moving(), what=f"the arm stands after {place}")
            return place

        try:
            yield run
        except BaseException:
            for each in (*psutil.Process(program.pid).children(), program):
                each.send_signal(signal.SIGABRT)  # one that hangs says where
            raise


@pytest.mark.timeout(300)
def test_an_interrupt_anywhere_on_the_way_out(bench: Bench, thorough: bool) -> None:
    # leaving takes some 4500 of them; the steps have no common factor with what repeats in it
    numbers = range(11, 4600, 163) if thorough and hasattr(os, "fork") else (11,)
    with interrupted_program(bench, str(Path(aioduco.__file__).parent) + os.sep) as run:
        for number in numbers:
            run(number)


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.skipif(not hasattr(os, "fork"), reason="each number takes a fork")
def test_an_interrupt_anywhere_in_the_locks_of_the_standard_library(bench: Bench) -> None:
    """Leaving begins anew after an interrupt: a lock that one left held would hold it for ever."""
    with interrupted_program(bench, threading.__file__) as run:
        for number in range(4, 84, 10):
            assert run(number)


@pytest.mark.slow
@pytest.mark.parametrize("first", [1, 3, 5, 7])
def test_two_interrupts_anywhere_in_a_blocking_call(
    bench: Bench, first: int, thorough: bool
) -> None:
    """No lock of a wait is left held, or let go of: the call stops the arm, and the next one works.

    The lines of the standard library count, too: it is there that such locks are.
    """
    # to be cancelled and undone takes some 140 lines
    numbers = range(first, 140, 8 if thorough else 32)
    started = subprocess.Popen(
        [
            *(sys.executable, str(Path(interrupted_calls.__file__))),
            *(bench.host, str(bench.port), *map(str, numbers)),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        told, errors = started.communicate(timeout=HUNG)
    except subprocess.TimeoutExpired:
        started.send_signal(signal.SIGABRT)  # it says where it hangs
        told, errors = started.communicate()
        pytest.fail(f"the program hung; it had told {told!r}:\n{errors}")
    assert told.splitlines() == ["KeyboardInterrupt False"] * 2 * len(numbers), errors
    assert started.returncode == 0
    assert not bench.moving()
