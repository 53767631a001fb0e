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
from interpreter import python

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
def run(name, main):
    try:
        anyio.run(main)
    except (aioduco.DucoError, RuntimeError) as exc:
        print(f"{{name}}: {{type(exc).__name__}}", *str(exc).splitlines())
    else:
        print(f"{{name}}: done")
"""
#: one of its parts
PART = """
async def {name}():{body}
run("{name}", {name})
"""
#: the error of each part without its process
ERRORS = {
    "guard": "GuardLost",
    "stream": "WorkerFailed",
    "planner": "PlanningError",
    "pictures": "RenderError",
    "simulator": "RuntimeError",
    "tap": "RuntimeError",
    "preflight": "PreflightError",
}


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench() as bench:
        bench.answer("servoj", 4)
        yield bench


class Frozen:
    """A frozen program of several parts, and how often it was started."""

    def __init__(
        self,
        bench: Bench,
        folder: Path,
        parts: dict[str, str],
        support: str = "",
        *,
        says_so: bool = True,
        without: tuple[str, ...] = (),
    ) -> None:
        launcher, script, starts = folder / "launcher", folder / "program.py", folder / "starts"
        launcher.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{script}" "$@"\n')
        launcher.chmod(0o755)
        begin = PROGRAM.format(
            frozen=says_so,
            launcher=str(launcher),
            support=support,
            without=without,
            starts=str(starts),
        )
        bodies = {
            name: body.format(host=bench.host, port=bench.port, HOME=HOME)
            for name, body in parts.items()
        }
        script.write_text(begin + "".join(PART.format(name=n, body=b) for n, b in bodies.items()))
        done = subprocess.run(
            [str(launcher)], capture_output=True, text=True, timeout=100, check=False
        )
        lines = (done.stdout + done.stderr).splitlines()
        self.said = {name: said for name, _, said in (line.partition(": ") for line in lines)}
        assert list(self.said) == list(parts), lines
        self.starts = len(starts.read_text().splitlines())

    @property
    def errors(self) -> dict[str, str]:
        """The error of each part."""
        return {name: said.partition(" ")[0] for name, said in self.said.items()}


ROBOT = {"guard": GUARD, "stream": STREAM}
OTHERS = {"planner": PLANNER, "pictures": PICTURES, "simulator": SIMULATOR, "tap": TAP}
PROGRAMS = {"preflight": PREFLIGHT, "sweep": SWEEP}
SUPPORT = "aioduco.freeze_support()"


@pytest.mark.slow
def test_a_frozen_program_that_calls_freeze_support_has_guard_and_lanes(
    bench: Bench, tmp_path: Path
) -> None:
    """Also without any of the extras that other processes need."""
    program = Frozen(bench, tmp_path, ROBOT, SUPPORT, without=EXTRAS)
    assert program.said == dict.fromkeys(ROBOT, "done")
    assert program.starts == 1
    assert bench.received("movej2")
    assert bench.received("servoj")


@pytest.mark.slow
def test_it_has_planners_pictures_simulators_and_taps_too(bench: Bench, tmp_path: Path) -> None:
    program = Frozen(bench, tmp_path, OTHERS, SUPPORT)
    assert program.said == dict.fromkeys(OTHERS, "done")
    assert program.starts == 1


@pytest.mark.slow
@pytest.mark.parametrize("support", [SUPPORT, ""], ids=["told", "untold"])
def test_it_tries_no_program_since_it_would_run_itself(
    bench: Bench, tmp_path: Path, support: str
) -> None:
    program = Frozen(bench, tmp_path, PROGRAMS, support)
    assert program.starts == 1
    for said in program.said.values():
        assert said.startswith("PreflightError this is a frozen program")


@pytest.mark.slow
def test_a_frozen_program_without_it_is_refused_and_not_started_again(
    bench: Bench, tmp_path: Path
) -> None:
    program = Frozen(bench, tmp_path, ROBOT | OTHERS)
    assert program.starts == 1
    assert not bench.commands
    assert program.errors == {name: ERRORS[name] for name in ROBOT | OTHERS}
    assert all(SUPPORT in said for said in program.said.values())
    assert "without a guard" in program.said["guard"]
    assert 'run_in="thread"' in program.said["stream"]


@pytest.mark.slow
def test_a_program_that_does_not_say_that_it_is_frozen_moves_nothing_when_started_by_mistake(
    bench: Bench, tmp_path: Path
) -> None:
    """It is started in place of each process; there it opens no robot, and starts nothing."""
    parts = ROBOT | OTHERS | {"preflight": PREFLIGHT}
    # glfw, which MuJoCo imports, would start it too: it asks its interpreter for a version.
    program = Frozen(bench, tmp_path, parts, says_so=False, without=("glfw",))
    assert program.starts == 1 + len(parts)
    assert not bench.received("movej2")
    assert not bench.received("servoj")
    assert program.errors == ERRORS


def test_a_program_that_is_not_frozen_may_call_it() -> None:
    code = "import aioduco; aioduco.freeze_support(); print('done')"
    done = python("-c", code)
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
    done = python("-c", code)
    assert done.returncode == 1
    assert "the program went on" not in done.stdout
