"""A program that forks while its stream runs goes on streaming; its child has no effect."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from aioduco.sim import Simulator
from aioduco.testing import eventually, no_leaks
from hostile import fork_in_stream


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with no_leaks(), Simulator(joints=fork_in_stream.START) as sim:
        yield sim


@pytest.mark.slow
@pytest.mark.linux("os.fork")
@pytest.mark.parametrize("run_in", ["process", "thread"])
def test_a_stream_goes_on_when_its_program_forks(sim: Simulator, run_in: str) -> None:
    program = [sys.executable, str(Path(fork_in_stream.__file__)), sim.host, str(sim.port), run_in]
    ended = subprocess.run(program, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 0, ended.stderr
    told = json.loads(ended.stdout)
    assert told["child"] == 7, ended.stderr
    last = 2e-4 * (2 * fork_in_stream.COUNT - 1)
    assert told["commanded"] == pytest.approx(last)
    eventually(lambda: not sim.moving)
    assert sim.joints[0] == pytest.approx(last, abs=2e-3)
