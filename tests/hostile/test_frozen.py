"""Programs that are frozen: their interpreter is the program, which must not start itself."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from client.bench import HOME, Bench

import aioduco
from aioduco._process import frozen
from aioduco._process.spawn import MARK

from .processes import GUARD, PICTURES, PLANNER, SIMULATOR, STREAM, TAP

PREFLIGHT = """
    from aioduco.testing.preflight import preflight
    preflight(__file__, quiet=True)
"""
SWEEP = """
    from aioduco.testing.preflight import PreflightSettings
    from aioduco.testing.preflight.sweep import sweep
    sweep(__file__, (), PreflightSettings(), 1)
"""
#: the error of each without the process
ERRORS = {
    GUARD: "GuardLost",
    STREAM: "WorkerFailed",
    PLANNER: "PlanningError",
    PICTURES: "RenderError",
    SIMULATOR: "RuntimeError",
    TAP: "RuntimeError",
    PREFLIGHT: "PreflightError",
    SWEEP: "PreflightError",
}
#: what a stranger to each of the extras has not
EXTRAS = ("mujoco", "ompl", "ruckig")
#: what an interpreter does that is frozen into a program: whatever it is told, it runs the program
PROGRAM = """
import sys
sys.frozen = {frozen}
sys.executable = {launcher!r}
sys.modules.update(dict.fromkeys({without!r}))
import anyio, aioduco
{support}
with open({starts!r}, "a") as starts:
    starts.write("a start of the motion program\\n")
async def main():{body}
try:
    anyio.run(main)
except (aioduco.DucoError, RuntimeError) as exc:
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
        self,
        bench: Bench,
        folder: Path,
        body: str,
        support: str,
        *,
        says_so: bool = True,
        without: tuple[str, ...] = (),
    ) -> None:
        launcher, script, starts = folder / "launcher", folder / "program.py", folder / "starts"
        launcher.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{script}" "$@"\n')
        launcher.chmod(0o755)
        script.write_text(
            PROGRAM.format(
                frozen=says_so,
                launcher=str(launcher),
                support=support,
                without=without,
                starts=str(starts),
                body=body.format(host=bench.host, port=bench.port, HOME=HOME),
            )
        )
        done = subprocess.run(
            [str(launcher)], capture_output=True, text=True, timeout=60, check=False
        )
        self.said = done.stdout + done.stderr
        self.starts = len(starts.read_text().splitlines())


ROBOT = {"guard": GUARD, "stream": STREAM}
OTHERS = {"planner": PLANNER, "pictures": PICTURES, "simulator": SIMULATOR, "tap": TAP}
PROGRAMS = {"preflight": PREFLIGHT, "sweep": SWEEP}


def bodies(*kinds: dict[str, str]) -> pytest.MarkDecorator:
    every = {name: body for kind in kinds for name, body in kind.items()}
    return pytest.mark.parametrize("body", every.values(), ids=every)


@pytest.mark.slow
@bodies(ROBOT)
def test_a_frozen_program_that_calls_freeze_support_has_guard_and_lanes(
    bench: Bench, tmp_path: Path, body: str
) -> None:
    """Also without any of the extras that other processes need."""
    program = Frozen(bench, tmp_path, body, "aioduco.freeze_support()", without=EXTRAS)
    assert program.said == "done\n"
    assert program.starts == 1
    assert bench.received("movej2" if body is GUARD else "servoj")


@pytest.mark.slow
@bodies(OTHERS)
def test_it_has_planners_pictures_simulators_and_taps_too(
    bench: Bench, tmp_path: Path, body: str
) -> None:
    program = Frozen(bench, tmp_path, body, "aioduco.freeze_support()")
    assert program.said == "done\n"
    assert program.starts == 1


@pytest.mark.slow
@bodies(PROGRAMS)
@pytest.mark.parametrize("support", ["aioduco.freeze_support()", ""], ids=["told", "untold"])
def test_it_tries_no_program_since_it_would_run_itself(
    bench: Bench, tmp_path: Path, body: str, support: str
) -> None:
    program = Frozen(bench, tmp_path, body, support)
    assert program.starts == 1
    assert program.said.startswith("PreflightError this is a frozen program")


@pytest.mark.slow
@bodies(ROBOT, OTHERS)
def test_a_frozen_program_without_it_is_refused_and_not_started_again(
    bench: Bench, tmp_path: Path, body: str
) -> None:
    program = Frozen(bench, tmp_path, body, "")
    assert program.starts == 1
    assert not bench.commands
    assert program.said.startswith(ERRORS[body])
    assert "aioduco.freeze_support()" in program.said
    assert {GUARD: "without a guard", STREAM: 'run_in="thread"'}.get(body, "") in program.said


@pytest.mark.slow
@bodies(ROBOT, OTHERS, {"preflight": PREFLIGHT})
def test_a_program_that_does_not_say_that_it_is_frozen_moves_nothing_when_started_by_mistake(
    bench: Bench, tmp_path: Path, body: str
) -> None:
    """It is started once, in place of the process; there it opens no robot, and starts nothing."""
    # glfw, which MuJoCo imports, would start it too: it asks its interpreter for a version.
    program = Frozen(bench, tmp_path, body, "", says_so=False, without=("glfw",))
    assert program.starts == 2
    assert not bench.received("movej2")
    assert not bench.received("servoj")
    assert program.said.startswith(ERRORS[body])


def test_a_program_that_is_not_frozen_may_call_it() -> None:
    code = "import aioduco; aioduco.freeze_support(); print('done')"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout == "done\n"


def test_each_process_can_be_started_by_a_frozen_program() -> None:
    package = Path(aioduco.__file__).parent
    started = {
        module
        for file in package.rglob("*.py")
        for module in re.findall(
            r"\b(?:Linked)?Process\(\s*\"(aioduco\.[\w.]+)\"", file.read_text("utf-8")
        )
    }
    # a frozen program cannot be tried out: see above
    assert started - {"aioduco.testing.preflight.child"} == set(frozen._MAINS)
    for name, load in frozen._MAINS.items():
        assert load() is import_module(name).main


@pytest.mark.slow
def test_a_frozen_program_without_a_console_ends_its_process() -> None:
    """Without one, Python has no standard error."""
    code = (
        "import sys, aioduco\n"
        f"sys.argv = ['program', {MARK!r}, 'aioduco.supervision.guard.process', 'no descriptor']\n"
        "sys.frozen, sys.stderr = True, None\n"
        "try:\n    aioduco.freeze_support()\n"
        "finally:\n    print('the program went on')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 1
    assert "the program went on" not in done.stdout
