"""An interrupt at any line of the package leaves neither a program that hangs nor a moving arm."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from client.bench import Bench

from aioduco.testing import eventually, no_leaks
from hostile import interrupted

#: s after which a program counts as hung
HUNG = 60.0


@pytest.fixture
def bench() -> Iterator[Bench]:
    with no_leaks(), Bench() as bench:
        bench.motion_time, bench.braking_time = 600.0, 0.1
        yield bench


# leaving takes some 3500 lines; the steps have no common factor with what repeats in it
@pytest.mark.parametrize("number", range(11, 3600, 127))
def test_an_interrupt_anywhere_on_the_way_out(bench: Bench, number: int) -> None:
    program = subprocess.Popen(
        [
            *(sys.executable, str(Path(interrupted.__file__))),
            *(bench.host, str(bench.port), str(number)),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        where, errors = program.communicate(timeout=HUNG)
    except subprocess.TimeoutExpired:
        program.send_signal(signal.SIGABRT)
        where, errors = program.communicate()
        pytest.fail(f"the program hung after an interrupt at {where}:\n{errors}")
    assert program.returncode != 0
    eventually(lambda: not bench.moving())
