"""Modules, clusters elsewhere, cut connections, and a test of somebody else's project."""

from __future__ import annotations

import contextlib
import json
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_runner import CliRunner
from for_each import for_each
from interpreter import python

from aioduco.cli.app import app
from aioduco.errors import ParameterError
from aioduco.testing.preflight import PreflightError, PreflightSettings, preflight
from aioduco.testing.preflight import sweep as module

from .trying import tried

BEGIN = """import sys
import aioduco, aioduco.sync
HOME, THERE = [0, 0, 1.6, 0, -1.5, 0], [0.3, 0, 1.6, 0, -1.5, 0]
with aioduco.sync.connect("192.0.2.1") as robot:
    robot.bring_up()
    robot.motion.movej2(HOME, v=1.0, a=2.0)
"""
CARELESS = f"{BEGIN}    robot.motion.movej2(THERE, v=1.0, a=2.0)  # CUT\n"
CAREFUL = f"""{BEGIN}
    try:
        robot.motion.movej2(THERE, v=1.0, a=2.0)
    except aioduco.OutcomeUnknown:
        robot.motion.movej2(THERE, v=1.0, a=2.0)
"""
#: the connection is cut when the fourth command was done: power on, enable, and two motions
CUT = 4
MODULE = """from cell import parts
assert __name__ == "__main__" and sys.argv[1:] == ["part", "7"]
assert open("parts.txt").read() == parts.NAME
"""
OUTSIDE = """
def test_the_program(duco_preflight):
    report = duco_preflight("program.py", ["7"], vary=("faults",), seed=4)
    assert [finding.kind for finding in report.findings] == ["error"]
"""

#: a result that is longer than a file may be
LONG = f"""import resource
{BEGIN}
resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
raise SystemExit("long " * 20_000)
"""
#: a thread that a busy computer does not let run at once, and clocks that are not replaced
LATE = """import sys, os, threading, time
import aioduco.sync
class Late(threading.Thread):
    def _set_ident(self):  # before `start` returns
        sum(range(5_000_000))
        super()._set_ident()
with aioduco.sync.connect("192.0.2.1"):
    begun, really = time.monotonic(), os.times().elapsed
    Late().start()
    passed = time.monotonic() - begun
    assert passed < os.times().elapsed - really + 0.1, passed
"""

#: classes of this package, and the modules of their functions
ORIGINAL = f"""import types
{BEGIN}
for name, module in list(sys.modules.items()):
    kinds = vars(module).values() if name.startswith("aioduco.") else ()
    for kind in [each for each in kinds if isinstance(each, type) and each.__module__ == name]:
        for function in vars(kind).values():
            if isinstance(function, types.FunctionType):
                place = function.__globals__["__name__"]
                assert place == name or "preflight" not in place, f"{{kind}} {{function}}"
"""


def aioduco_preflight(folder: Path, *arguments: str) -> tuple[int, str, dict[str, Any]]:
    """Exit status, what was said, and the result as JSON."""
    result = folder / "result.json"
    with contextlib.chdir(folder):
        done = CliRunner().invoke(app, ["preflight", "--json", str(result), *arguments])
    return done.exit_code, done.output, json.loads(result.read_text()) if result.is_file() else {}


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    """A folder with a package, whose module reads a file there."""
    (tmp_path / "cell").mkdir()
    (tmp_path / "cell/__init__.py").touch()
    (tmp_path / "cell/parts.py").write_text("NAME = 'bolt'\n")
    (tmp_path / "parts.txt").write_text("bolt")
    (tmp_path / "cell/run.py").write_text(f"{CARELESS}{MODULE}")
    return tmp_path


#: a module that imports the vendor's class from its own package
VENDORS = """import sys
from .DucoCobot import DucoCobot
robot = DucoCobot("192.168.1.10", 7003)
assert robot.open() == 0
assert robot.power_on(True) == robot.enable(True) == 4
assert robot.movej2([0.3, 0, 1.6, 0, -1.5, 0], 1.0, 2.0, 0.0, True) == 4
assert sys.argv[1:] == ["part"]
robot.close()
"""


@pytest.mark.slow
def test_a_module_for_the_vendors_class(cell: Path) -> None:
    (cell / "cell/theirs.py").write_text(VENDORS)
    status, said, result = aioduco_preflight(
        cell, "--quiet", "--vendor", "-m", "cell.theirs", "--", "part"
    )
    assert (status, result.get("ok")) == (0, True), said


@pytest.mark.slow
def test_a_module_runs_as_python_runs_it(cell: Path) -> None:
    run = ("-m", "cell.run", "--", "part", "7")
    status, said, result = aioduco_preflight(cell, "--quiet", *run)
    assert (status, result.get("ok")) == (0, True), said
    assert {call["where"]["file"] for call in result["calls"] if call["where"]} == {
        str(cell / "cell/run.py")
    }
    status, said, result = aioduco_preflight(cell, "--quiet", "-m", "cell.walk")
    assert (status, [one["kind"] for one in result["findings"]]) == (1, ["error"]), said
    assert "cell.walk" in result["findings"][0]["text"]


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_cluster_elsewhere_runs_in_the_same_folder_and_a_killed_worker_costs_no_result(
    cell: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Its workers were started in another folder. Of these seeds one cuts a command here."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setenv("TMPDIR", str(tmp_path))  # what the killed one leaves
    run, killed = module.sweep, list[int]()
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0", host="127.0.0.1"
    ) as cluster:

        def killing(*given: Any, done: Callable[[Any], None], **more: Any) -> module.SweepReport:
            def done_and_kill(result: Any) -> None:
                done(result)
                if not killed:
                    killed.append(next(iter(cluster.workers.values())).pid)
                    os.kill(killed[0], signal.SIGKILL)

            return run(*given, done=done_and_kill, **more)

        monkeypatch.setattr(module, "sweep", killing)
        status, said, result = aioduco_preflight(
            cell, "--runs", "3", "--seed", "3", "--vary", "faults,start,latency",
            "--timeout", "200", "--scheduler", cluster.scheduler_address,
            "-m", "cell.run", "--", "part", "7",
        )  # fmt: skip
    assert killed
    assert (status, [each["seed"] for each in result["results"]]) == (1, [3, 4, 5]), said
    lines = [[(one["kind"], one["line"]) for one in each["findings"]] for each in result["results"]]
    assert lines == [[], [("error", len(CARELESS.splitlines()))], []]
    assert "1 of 3 variations failed" in said


@pytest.mark.slow
@pytest.mark.parametrize("program", [CARELESS, CAREFUL], ids=["careless", "careful"])
def test_a_cut_connection_is_found_where_the_program_does_not_expect_it(
    tmp_path: Path, program: str
) -> None:
    report = tried(tmp_path, program, vary=("faults",), seed=4)
    assert report.variation["faults"] == [CUT]
    found = [(finding.kind, finding.line) for finding in report.findings]
    marked = [number for number, line in enumerate(program.splitlines(), 1) if "# CUT" in line]
    assert found == [("error", line) for line in marked], report.findings
    assert all("OutcomeUnknown" in finding.text for finding in report.findings)


@pytest.mark.slow
def test_the_fixture_in_a_project_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(CARELESS)
    (tmp_path / "test_outside.py").write_text(OUTSIDE)
    done = python("-m", "pytest", "-q", "-p", "no:cacheprovider", "test_outside.py", cwd=tmp_path)
    assert "1 passed" in done.stdout, done.stdout + done.stderr


@pytest.mark.slow
def test_no_function_of_this_package_is_replaced(tmp_path: Path) -> None:
    report = tried(tmp_path, ORIGINAL)
    assert report.ok, report.findings
    assert report.motions


@pytest.mark.slow
def test_the_start_of_a_thread_takes_no_time_of_the_program(tmp_path: Path) -> None:
    """It waits for the thread: simulated minutes passed until a busy computer let that run."""
    report = tried(tmp_path, LATE)
    assert report.ok, report.findings


@pytest.mark.slow
@pytest.mark.linux("limits of a process")
def test_a_result_that_does_not_fit_on_the_disk_is_none(tmp_path: Path) -> None:
    with pytest.raises(PreflightError, match="before it was over"):
        tried(tmp_path, LONG)


@for_each(
    "given",
    [
        *({"allowed": "table"}, {"reachable": "192.0.2.1:80"}, {"vary": "start"}, {"vary": (1,)}),
        *({"seed": 1.5}, {"seed": "1"}, {"vendor": 1}, {"module": "yes"}, {"cwd": 5}),
        *({"joints": [0.0] * 5}, {"joints": "abcdef"}, {"pedestal": "high"}),
    ],
)
def test_a_setting_of_another_type_is_refused(given: dict[str, Any]) -> None:
    """The letters of one text were the bodies, the addresses and the quantities."""
    with pytest.raises(ParameterError, match=next(iter(given))):
        PreflightSettings(**given)


def test_arguments_are_not_the_letters_of_one_text() -> None:
    with pytest.raises(ParameterError, match="arguments"):
        preflight(__file__, "--slow")


def test_settings_of_numpy_and_a_path_are_values_for_json(tmp_path: Path) -> None:
    settings = PreflightSettings(
        joints=np.zeros(6), pedestal=np.float32(0.5), patience=np.float32(5), seed=np.int64(3),  # type: ignore[arg-type]
        vendor=np.bool_(True), cwd=tmp_path, allowed=["table"],  # type: ignore[arg-type]
    )  # fmt: skip
    plain = json.loads(json.dumps(settings.plain()))
    assert (plain["seed"], plain["cwd"], plain["joints"]) == (3, str(tmp_path), [0.0] * 6)
    assert (plain["vendor"], plain["allowed"], plain["pedestal"]) == (True, ["table"], 0.5)
