"""What the guard and the lanes of streams import: what the program has, and nothing else."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from client.bench import HOME, Bench

import aioduco
from aioduco import _spawn

if TYPE_CHECKING:
    from collections.abc import Iterator

GUARD = """
    async with aioduco.connect({host!r}, {port}, guard="process") as robot:
        await robot.motion.movej2({HOME}, v=1.0, a=1.0)
"""
STREAM = """
    async with aioduco.connect({host!r}, {port}) as robot:
        async with robot.servo.joints(v=1.0, a=5.0, rate=100) as stream:
            await stream.send({HOME})
"""
#: a file with the name of something that each process imports: it says so and ends the process
STRAY = "import os, pathlib; pathlib.Path({ran!r}).touch(); os._exit(9)"


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench() as bench:
        bench.answer("servoj", 4)
        yield bench


def program(bench: Bench, kind: str, begin: str = "") -> str:
    body = {"guard": GUARD, "stream": STREAM}[kind]
    body = body.format(host=bench.host, port=bench.port, HOME=HOME)
    return f"{begin}\nimport anyio, aioduco\nasync def main():{body}anyio.run(main)\nprint('done')"


def run(command: list[str], cwd: Path) -> str:
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=60, check=False)
    return done.stdout + done.stderr


@pytest.mark.parametrize("kind", ["guard", "stream"])
@pytest.mark.parametrize("name", ["anyio", "json", "thriftpy2"])
def test_a_stray_file_in_the_current_folder_is_not_run(
    bench: Bench, tmp_path: Path, kind: str, name: str
) -> None:
    here, elsewhere = tmp_path / "here", tmp_path / "elsewhere"
    for folder in (here, elsewhere):
        folder.mkdir()
    ran = tmp_path / "ran"
    (here / f"{name}.py").write_text(STRAY.format(ran=str(ran)))
    script = elsewhere / "program.py"
    script.write_text(program(bench, kind))
    assert run([sys.executable, str(script)], here) == "done\n"
    assert not ran.exists()


@pytest.mark.parametrize("kind", ["guard", "stream"])
@pytest.mark.parametrize("isolated", [True, False], ids=["-I", "without"])
def test_packages_that_only_the_program_knows_of_are_found(
    bench: Bench, tmp_path: Path, kind: str, isolated: bool
) -> None:
    """A plain interpreter without any package; the program has put them on its own path."""
    folders = sorted(set(_spawn._places().values()))
    script = tmp_path / "program.py"
    script.write_text(program(bench, kind, f"import sys\nsys.path[:0] = {folders!r}"))
    base: str = sys._base_executable  # type: ignore[attr-defined]  # the only way to its file
    flags = ["-I"] if isolated else []
    assert run([base, *flags, str(script)], tmp_path) == "done\n"


def test_all_that_the_processes_import_is_taken_from_where_the_program_has_it() -> None:
    code = (
        "import sys; before = set(sys.modules)\n"
        "import anyio, anyio._backends._asyncio\n"
        "import aioduco.supervision.guard.process, aioduco.streaming.worker.main\n"
        "from aioduco._wire import idl; idl.path()\n"
        "new = {name.partition('.')[0] for name in set(sys.modules) - before}\n"
        "new -= set(sys.stdlib_module_names)\n"
        "print(*sorted(n for n in new if getattr(sys.modules.get(n), '__file__', None)))"
    )
    said = run([sys.executable, "-c", code], Path.cwd())
    assert set(said.split()) <= set(_spawn._PACKAGES)
    assert {"aioduco", "anyio", "thriftpy2"} <= set(said.split())


async def test_a_guard_that_cannot_begin_says_why(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_spawn, "_BEGIN", "import a_package_that_nobody_has")
    with pytest.raises(aioduco.GuardLost, match="No module named 'a_package_that_nobody_has'"):
        await aioduco.connect(bench.host, bench.port, guard="process").open()


async def test_a_lane_that_cannot_begin_says_why(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_spawn, "_BEGIN", "import a_package_that_nobody_has")
    async with aioduco.connect(bench.host, bench.port) as robot:
        stream = robot.servo.joints(v=1.0, a=5.0, rate=100)
        with pytest.raises(aioduco.LaneFailed, match="No module named 'a_package_that_nobody_has'"):
            await stream.__aenter__()
