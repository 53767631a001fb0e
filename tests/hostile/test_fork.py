"""A program that forks keeps its robot, and its children cannot use it."""

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

from aioduco.recording import read
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
    told: list[dict[str, Any]]
    errors: str


def run(bench: Bench, folder: Path, guard: str, loop: str, *child: str, **options: Any) -> Ended:
    """The program, from its start to its end; one that hangs says where it does."""
    out, errors = folder / "out", folder / "errors"
    with out.open("w") as told, errors.open("w") as complaints:
        program = subprocess.Popen(
            [
                *(sys.executable, str(Path(forking.__file__))),
                *(bench.host, str(bench.port), guard, loop, *child),
            ],
            stdout=told,
            stderr=complaints,
            cwd=folder,
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
    lines = out.read_text().splitlines()
    return Ended(code, [json.loads(line) for line in lines], errors.read_text())


def undisturbed(bench: Bench, ended: Ended, robots: int = 1) -> None:
    """The robots did what their own program wanted, and nothing else."""
    assert ended.code == 0, ended.errors
    assert [(told["task"], told["again"]) for told in ended.told] == [("finished",) * 2] * robots
    assert bench.commands == ["movej2", "movej2", "movej2", "stop"] * robots
    assert not bench.moving()


#: what the children do, of which each guard has half with either loop
ENDING = [*forking.CHILDREN, "multiprocessing"]


@LOOPS
@GUARDS
def test_a_forked_child_that_ends_leaves_its_parents_robot_alone(
    bench: Bench, tmp_path: Path, guard: str, loop: str
) -> None:
    children = ENDING[(loop == "uvloop") ^ (guard == "process") :: 2]
    if sys.version_info >= (3, 14):  # from there on, sys.exit in a coroutine ends no forked child
        children = [child for child in children if child not in {"leave", "forget"}]
    ended = run(bench, tmp_path, guard, loop, *children)
    undisturbed(bench, ended, len(children))
    assert [told["child"] for told in ended.told] == [forking.CODE] * len(children), ended.errors
    assert "Traceback" not in ended.errors
    assert all(read(tmp_path / f"{child}.mcap").complete for child in children)


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
