"""Programs that are frozen: their interpreter is the program, which must not start itself."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

import pytest
from client.bench import HOME, Bench

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

GUARD = """
    async with aioduco.connect({host!r}, {port}, guard="process") as robot:
        await robot.motion.movej2({HOME}, v=1.0, a=1.0)
"""
STREAM = """
    async with aioduco.connect({host!r}, {port}) as robot:
        async with robot.servo.joints(v=1.0, a=5.0, rate=100) as stream:
            await stream.send({HOME})
"""
#: what an interpreter does that is frozen into a program: whatever it is told, it runs the program
PROGRAM = """
import sys
sys.frozen = {frozen}
sys.executable = {launcher!r}
import anyio, aioduco
{support}
with open({starts!r}, "a") as starts:
    starts.write("a start of the motion program\\n")
async def main():{body}
try:
    anyio.run(main)
except aioduco.DucoError as exc:
    print(type(exc).__name__, exc)
else:
    print("done")
"""


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench() as bench:
        bench.answer("servoj", 4)
        yield bench


class Frozen:
    """A frozen program: what it said, and how often it was started."""

    def __init__(
        self, bench: Bench, folder: Path, body: str, support: str, *, says_so: bool = True
    ) -> None:
        launcher, script, starts = folder / "launcher", folder / "program.py", folder / "starts"
        launcher.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{script}" "$@"\n')
        launcher.chmod(0o755)
        script.write_text(
            PROGRAM.format(
                frozen=says_so,
                launcher=str(launcher),
                support=support,
                starts=str(starts),
                body=body.format(host=bench.host, port=bench.port, HOME=HOME),
            )
        )
        done = subprocess.run(
            [str(launcher)], capture_output=True, text=True, timeout=60, check=False
        )
        self.said = done.stdout + done.stderr
        self.starts = len(starts.read_text().splitlines())


BODIES = pytest.mark.parametrize("body", [GUARD, STREAM], ids=["guard", "stream"])


@BODIES
def test_a_frozen_program_that_calls_freeze_support_has_guard_and_lanes(
    bench: Bench, tmp_path: Path, body: str
) -> None:
    program = Frozen(bench, tmp_path, body, "aioduco.freeze_support()")
    assert program.said == "done\n"
    assert program.starts == 1
    assert bench.received("movej2" if body is GUARD else "servoj")


@BODIES
def test_a_frozen_program_without_it_is_refused_and_not_started_again(
    bench: Bench, tmp_path: Path, body: str
) -> None:
    program = Frozen(bench, tmp_path, body, "")
    assert program.starts == 1
    assert not bench.commands
    assert program.said.startswith("GuardLost" if body is GUARD else "LaneFailed")
    assert "aioduco.freeze_support()" in program.said
    assert ("without a guard" if body is GUARD else 'lane="thread"') in program.said


@BODIES
def test_a_program_that_does_not_say_that_it_is_frozen_moves_nothing_when_started_by_mistake(
    bench: Bench, tmp_path: Path, body: str
) -> None:
    """It is started once, in place of the process; there it opens no robot, and starts nothing."""
    program = Frozen(bench, tmp_path, body, "", says_so=False)
    assert program.starts == 2
    assert not bench.received("movej2")
    assert not bench.received("servoj")
    assert program.said.startswith("GuardLost" if body is GUARD else "LaneFailed")


def test_a_program_that_is_not_frozen_may_call_it() -> None:
    code = "import aioduco; aioduco.freeze_support(); print('done')"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout == "done\n"
