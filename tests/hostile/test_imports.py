"""What the processes of this package import: what the program has, and nothing else."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import pytest
from client.bench import HOME, Bench

import aioduco
from aioduco._process import spawn
from aioduco.planning import Planner, Scene, planner
from aioduco.sim.simulator import Simulator
from aioduco.testing.preflight import PreflightError, preflight

from .processes import GUARD, PICTURES, PLANNER, SIMULATOR, STREAM

PREFLIGHT = """
    from aioduco.testing.preflight import preflight
    assert preflight({tried!r}, quiet=True).ok
"""
KINDS = {
    "guard": GUARD,
    "stream": STREAM,
    "planner": PLANNER,
    "pictures": PICTURES,
    "simulator": SIMULATOR,
    "preflight": PREFLIGHT,
}
#: a program that is tried out; its own folder and PYTHONPATH are for it
TRIED = """
import its_helper, aioduco.sync
with aioduco.sync.connect("192.0.2.1") as robot:
    robot.state.get_tcp_pose()
"""
#: processes, and files with the names of what they import; `ctypes` is what an interpreter imports
#: that glfw starts, which MuJoCo imports
STRAYS = [
    (("guard", "stream", "preflight"), ("anyio", "json", "mujoco", "thriftpy2")),
    (("planner", "pictures", "simulator"), ("ctypes", "mujoco", "ompl", "OpenGL", "pickle")),
]
#: such a file says that it is run, and ends the process
STRAY = "import os, pathlib; pathlib.Path({ran!r}).touch(); os._exit(9)"


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench() as bench:
        bench.answer("servoj", 4)
        yield bench


def program(bench: Bench, kinds: Iterable[str], tried: Path, begin: str = "") -> str:
    (tried.parent / "its_helper.py").touch()
    tried.write_text(TRIED)
    # a busy machine may hold up the event loop, of which the program's robot would log
    quiet = "import logging; logging.getLogger('aioduco').setLevel(logging.ERROR)"
    code = [begin, "import anyio, aioduco", quiet]
    for kind in kinds:
        body = KINDS[kind].format(host=bench.host, port=bench.port, HOME=HOME, tried=str(tried))
        code.append(f"async def main():{body}anyio.run(main)\nprint({kind!r})")
    return "\n".join(code)


def run(command: list[str], cwd: Path) -> str:
    done = subprocess.run(
        command, cwd=cwd, capture_output=True, text=True, timeout=100, check=False
    )
    return done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(("kinds", "strays"), STRAYS, ids=["robot", "others"])
def test_stray_files_in_the_current_folder_are_not_run(
    bench: Bench,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    kinds: tuple[str, ...],
    strays: tuple[str, ...],
) -> None:
    monkeypatch.delenv("MUJOCO_GL")  # as programs have it, not these tests
    here, elsewhere = tmp_path / "here", tmp_path / "elsewhere"
    for folder in (here, elsewhere):
        folder.mkdir()
    ran = tmp_path / "ran"
    ran.mkdir()
    for name in strays:
        (here / f"{name}.py").write_text(STRAY.format(ran=str(ran / name)))
    script = elsewhere / "program.py"
    # The program's own import of MuJoCo is as it is anywhere; here it is to start nothing.
    begin = "import sys\nsys.modules['glfw'] = None" if "ctypes" in strays else ""
    script.write_text(program(bench, kinds, elsewhere / "tried.py", begin))
    said = run([sys.executable, str(script)], here)
    assert said.startswith("".join(f"{kind}\n" for kind in kinds)), said  # then perhaps warnings
    assert list(ran.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kinds", "flags"),
    # What is isolated finds least; where the others look, only a program of the first kinds may.
    [(tuple(KINDS), ("-I",)), (("guard", "stream"), ())],
    ids=["isolated", "as others"],
)
def test_packages_that_only_the_program_knows_of_are_found(
    bench: Bench, tmp_path: Path, kinds: tuple[str, ...], flags: tuple[str, ...]
) -> None:
    """A plain interpreter without any package; the program has put them on its own path."""
    folders = sorted(set(spawn._places().values()))
    script = tmp_path / "program.py"
    begin = f"import sys\nsys.path[:0] = {folders!r}"
    script.write_text(program(bench, kinds, tmp_path / "tried.py", begin))
    base: str = sys._base_executable  # type: ignore[attr-defined]  # the only way to its file
    assert run([base, *flags, str(script)], tmp_path) == "".join(f"{kind}\n" for kind in kinds)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("modules", "more", "some"),
    [
        (
            "anyio._backends._asyncio, aioduco.supervision.guard.process, aioduco.streaming.worker",
            (),
            {"anyio"},
        ),
        ("aioduco.planning.worker", planner._PACKAGES, {"ompl"}),
        ("aioduco.sim.view.drawing, mujoco.egl", spawn.MUJOCO_PACKAGES, {"mujoco", "OpenGL"}),
        ("aioduco.sim.spawned, aioduco.sim.view.render", spawn.MUJOCO_PACKAGES, {"mujoco"}),
        (
            "aioduco.testing.preflight.child, aioduco.compat._runner",
            spawn.MUJOCO_PACKAGES,
            {"mujoco"},
        ),
    ],
    ids=["robot", "planner", "pictures", "simulator", "preflight"],
)
def test_all_that_the_processes_import_is_taken_from_where_the_program_has_it(
    modules: str, more: tuple[str, ...], some: set[str]
) -> None:
    code = (
        "import sys; before = set(sys.modules)\n"
        f"import {modules}\n"
        "from aioduco._wire import idl; idl.path()\n"
        "from importlib.machinery import PathFinder\n"
        "new = {name.partition('.')[0] for name in set(sys.modules) - before}\n"
        "new -= set(sys.stdlib_module_names)\n"
        "new -= {name for name in new if sys.modules[name].__spec__ is None}  # in place of one\n"
        "found = filter(PathFinder.find_spec, new)\n"
        "print(*sorted(n for n in found if not n.startswith('_sysconfigdata')))"
    )
    said = run([sys.executable, "-c", code], Path.cwd())
    assert set(said.split()) <= {*spawn._PACKAGES, *more}
    assert {"aioduco", *some} <= set(said.split())


@pytest.mark.slow
def test_a_program_that_is_tried_finds_modules_as_it_would_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By PYTHONPATH too; and what the simulator starts beside it knows nothing of the process."""
    library, tried = tmp_path / "library", tmp_path / "tried.py"
    library.mkdir()
    (library / "its_helper.py").touch()
    tried.write_text(f"{TRIED}import os; assert 'AIODUCO_PROCESS' not in os.environ\n")
    monkeypatch.setenv("PYTHONPATH", str(library))
    report = preflight(tried, quiet=True)
    assert report.ok, report.findings


async def test_a_guard_that_cannot_begin_says_why(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spawn, "_BEGIN", "import a_package_that_nobody_has")
    with pytest.raises(aioduco.GuardLost, match="No module named 'a_package_that_nobody_has'"):
        await aioduco.connect(bench.host, bench.port, guard="process").open()


async def test_a_lane_that_cannot_begin_says_why(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spawn, "_BEGIN", "import a_package_that_nobody_has")
    async with aioduco.connect(bench.host, bench.port) as robot:
        stream = robot.servo.joints(v=1.0, a=5.0, rate=100)
        with pytest.raises(
            aioduco.WorkerFailed, match="No module named 'a_package_that_nobody_has'"
        ):
            await stream.__aenter__()


@pytest.mark.cases(4)
@pytest.mark.parametrize(
    ("start", "error"),
    [
        (lambda: Planner(Scene()).plan_blocking(HOME, aioduco.Joints.of(HOME)), "PlanningError"),
        (lambda: Scene().picture(HOME), "RenderError"),
        (lambda: Simulator.spawn().start(), "RuntimeError"),
        (lambda: preflight(__file__, quiet=True), "PreflightError"),
    ],
    ids=["planner", "pictures", "simulator", "preflight"],
)
def test_each_other_process_that_cannot_begin_says_why(
    monkeypatch: pytest.MonkeyPatch, start: Callable[[], object], error: str
) -> None:
    monkeypatch.setattr(spawn, "_BEGIN", "import a_package_that_nobody_has")
    errors = (aioduco.PlanningError, aioduco.RenderError, RuntimeError, PreflightError)
    with pytest.raises(errors, match="No module named 'a_package_that_nobody_has'") as raised:
        start()
    assert type(raised.value).__name__ == error
