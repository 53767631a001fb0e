"""An interrupt at any line of the package leaves neither a program that hangs nor a moving arm."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from client.bench import Bench

from aioduco.testing import eventually, no_leaks
from hostile import interrupted, interrupted_calls

#: s after which a program counts as hung
HUNG = 60.0


@pytest.fixture
def bench() -> Iterator[Bench]:
    with no_leaks(), Bench() as bench:
        bench.motion_time, bench.braking_time = 600.0, 0.1
        yield bench


@pytest.mark.timeout(300)
def test_an_interrupt_anywhere_on_the_way_out(bench: Bench, thorough: bool) -> None:
    # leaving takes some 3500 lines; the steps have no common factor with what repeats in it
    numbers = range(11, 3600, 127) if thorough and hasattr(os, "fork") else (11,)
    with subprocess.Popen(
        [sys.executable, str(Path(interrupted.__file__)), bench.host, str(bench.port)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdin is not None
        assert program.stdout is not None
        try:
            for number in numbers:
                print(number, file=program.stdin, flush=True)
                where, _, status = program.stdout.readline().partition(" ")
                assert int(status or program.wait()) != 0, f"{number}: {where}"
                eventually(lambda: not bench.moving(), what=f"the arm stands after {where}")
        except BaseException:
            for each in (*psutil.Process(program.pid).children(), program):
                each.send_signal(signal.SIGABRT)  # one that hangs says where
            raise


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
