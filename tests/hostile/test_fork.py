"""A program that forks keeps its robot, and its children can do nothing to it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from client.bench import Bench

from aioduco.testing import eventually, no_leaks
from hostile import forking

#: s after which a program counts as hung
HUNG = 60.0

pytestmark = pytest.mark.linux("os.fork")

LOOPS = pytest.mark.parametrize("loop", ["asyncio", "uvloop"])
GUARDS = pytest.mark.parametrize("guard", ["", "process"], ids=["alone", "guard"])


@pytest.fixture
def bench() -> Iterator[Bench]:
    with no_leaks(), Bench() as bench:
        bench.motion_time = 0.5
        yield bench


@dataclass
class Ended:
    """How the program ended."""

    code: int
    told: dict[str, Any]
    errors: str


def run(bench: Bench, folder: Path, guard: str, loop: str, child: str, **options: Any) -> Ended:
    """The program, from its start to its end; one that hangs says where it does."""
    out, errors = folder / "out", folder / "errors"
    with out.open("w") as told, errors.open("w") as complaints:
        program = subprocess.Popen(
            [
                *(sys.executable, str(Path(forking.__file__))),
                *(bench.host, str(bench.port), guard, loop, child),
            ],
            stdout=told,
            stderr=complaints,
            start_new_session=True,
            **options,
        )
        try:
            code = program.wait(HUNG)
        except subprocess.TimeoutExpired:
            # with its children, which would be left behind
            os.killpg(program.pid, signal.SIGABRT)
            program.wait()
            pytest.fail(f"the program hung:\n{errors.read_text()}")
    text = out.read_text()
    return Ended(code, json.loads(text) if text else {}, errors.read_text())


def undisturbed(bench: Bench, ended: Ended) -> None:
    """The robot did what its own program wanted, and nothing else."""
    assert ended.code == 0, ended.errors
    assert ended.told["task"] == "finished"
    assert ended.told["again"] == "finished"
    assert bench.commands == ["movej2", "movej2", "movej2", "stop"]
    assert not bench.moving()


#: each pair of a child, a loop and a guard
PAIRS = [
    (child, guard, ("asyncio", "uvloop")[(index + bool(guard)) % 2])
    for index, child in enumerate([*forking.CHILDREN, "multiprocessing"])
    for guard in ("", "process")
]


@pytest.mark.parametrize(("child", "guard", "loop"), PAIRS)
def test_a_forked_child_that_ends_leaves_its_parents_robot_alone(
    bench: Bench, tmp_path: Path, guard: str, loop: str, child: str
) -> None:
    if sys.version_info >= (3, 14) and child in {"leave", "forget"}:
        pytest.skip("from Python 3.14 on, sys.exit in a coroutine ends no forked child")
    ended = run(bench, tmp_path, guard, loop, child)
    undisturbed(bench, ended)
    assert ended.told["child"] == forking.CODE, ended.errors
    assert "Traceback" not in ended.errors


@pytest.mark.slow
@LOOPS
@GUARDS
def test_a_program_leaves_its_robot_while_a_forked_child_lives_on(
    bench: Bench, tmp_path: Path, guard: str, loop: str
) -> None:
    theirs, ours = os.pipe()
    try:
        environment = {**os.environ, "AIODUCO_TEST_PIPE": str(theirs)}
        ended = run(bench, tmp_path, guard, loop, "live_on", pass_fds=[theirs], env=environment)
        undisturbed(bench, ended)
        # the child holds none of its parent's connections open
        eventually(lambda: bench._server.connections == 0)
    finally:
        os.close(theirs)
        os.close(ours)
