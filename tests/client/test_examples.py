"""Each example runs to its end and prints what it should, and nothing else."""

from __future__ import annotations

import asyncio
import importlib.util
import json
import re
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import anyio
import pytest
from example_modules import example
from interpreter import python
from moments import complaints
from terminals import terminal

import aioduco.sync
from aioduco._wire import rpc
from aioduco.sim import Simulator
from aioduco.testing import eventually_async

from .bench import Bench

EXAMPLES = Path(__file__).parents[2] / "examples"
PATIENT = str(Path(__file__).parents[1] / "patient.py")

SAYS = {
    "01_connect_and_move.py": ["ready: robot ENABLE", "finished", "back, within 0.0"],
    "02_stop_from_another_task.py": ["stopped by the other task: movej2", "moving: False"],
    "03_blended_motions.py": [
        "radius 0 mm: ",
        "(finished, finished, finished, finished)",
        "radius 20 mm: ",
        "(blended, blended, blended, finished)",
    ],
    "07_plain_script.py": ["ready: robot ENABLE", "down: finished", "round: blended, blended, fin"],
}


#: on a simulated arm of their own alone: with its gripper, a second one, or what goes wrong; how
#: fast that arm may be, since streams and pictures keep to the wall's time
ALONE = {
    "pick_and_place.py": (4, ["part 2: placed", "3 of 3 placed"]),
    "gripper_robotiq.py": (4, ["holds something: True", "fingers 40 mm apart"]),
    "two_arms.py": (
        4,
        ["left: in the shared place, 3", "right: in the shared place, 3", "both are"],
    ),
    "polish.py": (1, ["4 lines, -1"]),
    "visual_servoing.py": (1, ["beside the tool", "over it within 2 mm"]),
    "teach_and_replay.py": (1, ["kept: ", "the way again: ", "the places again: 3 of 3"]),
    "behaviour_tree.py": (4, ["to the parts: TaskFailed", "fetched 3 of 3"]),
}

NEEDS_ARM = ("gripper_dh.py", "gripper_of_your_own.py", "measure_payload.py", "twin_beside_arm.py")


def run(*command: str, speed: int | None = None) -> str:
    """Run an example; one that makes its own arms tells how fast these may be."""
    own = () if speed is None else ("--speed", str(speed))
    done = python("-W", "error", PATIENT, *own, *command, timeout=110)
    assert complaints(done.stderr) == ""
    assert done.returncode == 0
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", SAYS)
def test_on_a_given_address(name: str) -> None:
    # slow where the next motion is to be sent while one runs: a busy machine is late with it
    speed = 0.5 if name.startswith(("03", "07")) else 2.0
    with Simulator(speed=speed) as sim:
        said = run(str(EXAMPLES / name), sim.host, str(sim.port))
    for words in SAYS[name]:
        assert words in said


@pytest.mark.slow
def test_a_load_is_measured_by_the_arm_that_the_controller_reports() -> None:
    with Simulator("gcr10_1300", speed=20.0) as sim:
        sim.load(1.5, (0.01, 0.02, 0.1))
        said = run(str(EXAMPLES / "measure_payload.py"), sim.host, str(sim.port))
    found = [float(number) for number in re.findall(r"=([-\d.e]+)", said)]
    assert found == pytest.approx((1.5, 0.01, 0.02, 0.1), abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", NEEDS_ARM)
def test_an_example_for_an_arm_says_that_it_needs_an_address(name: str) -> None:
    done = python(str(EXAMPLES / name))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"usage: {name} ")


@pytest.mark.slow
@pytest.mark.parametrize("name", ALONE)
def test_with_more_than_an_arm(name: str) -> None:
    if name == "behaviour_tree.py":
        pytest.importorskip("py_trees", reason="needs pip install 'aioduco[examples]'")
    speed, says = ALONE[name]
    said = run(str(EXAMPLES / name), speed=speed)
    for words in says:
        assert words in said


async def test_a_program_that_is_ended_while_it_grips_moves_nothing_more(
    bench: Bench, robot: aioduco.Robot
) -> None:
    """The arm went up after Ctrl-C."""
    bench.answer("getRobotIOStatus", rpc.IOStatus(digitalInputs=[False] * 16))
    module = example("pick_and_place")
    work = asyncio.create_task(module.reach(robot, module.FROM[0], closed=True))
    await eventually_async(lambda: bench.received("set_standard_digital_out"))
    motions = len(bench.received("movel"))
    work.cancel()
    with pytest.raises(asyncio.CancelledError):
        await work
    assert len(bench.received("movel")) == motions


@pytest.mark.slow
def test_a_job_goes_on_after_a_fault_and_after_its_end(tmp_path: Path) -> None:
    job = tmp_path / "job.json"
    said = run(str(EXAMPLES / "resume_job.py"), str(job), speed=4)
    assert re.search(r"step (\d): TaskFailed\nstep \1: done\n", said)
    assert "the job is done" in said
    job.write_text('{"done": 4}', encoding="utf-8")
    with Simulator(speed=2.0) as sim:
        said = run(str(EXAMPLES / "resume_job.py"), str(job), sim.host, str(sim.port))
    assert said == "step 5: done\nthe job is done\n"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["behaviour_tree.py", "resume_job.py"])
def test_a_stop_by_somebody_else_ends_it_where_nobody_can_be_asked(
    name: str, tmp_path: Path
) -> None:
    job = [str(tmp_path / "job.json")] if name == "resume_job.py" else []
    if not job:
        pytest.importorskip("py_trees", reason="needs pip install 'aioduco[examples]'")
    with Simulator() as sim:
        address = sim.host, str(sim.port)
        command = [sys.executable, PATIENT, str(EXAMPLES / name), *job, *address]
        with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE) as program:
            sim.wait_until(lambda: abs(sim.joints[0]) > 0.1, 60.0)
            with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as operator:
                operator.stop()
            stopped = sim.joints
            said, _ = program.communicate(timeout=50)
        assert b"TaskStopped" in said
        assert program.returncode == 1
        assert sim.joints == pytest.approx(stopped, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["behaviour_tree.py", "resume_job.py", "teach_and_replay.py"])
def test_one_ctrl_c_ends_it_while_it_waits_for_a_line(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A line was read in a thread that nothing ended: it took a second Ctrl-C."""
    monkeypatch.chdir(tmp_path)
    job = ["job.json"] if name == "resume_job.py" else []
    if name == "behaviour_tree.py":
        pytest.importorskip("py_trees", reason="needs pip install 'aioduco[examples]'")
    words = str(EXAMPLES / name), *job
    with (
        Simulator() as sim,
        terminal(*words, sim.host, str(sim.port), command=(sys.executable, PATIENT)) as shown,
    ):
        if name != "teach_and_replay.py":
            sim.wait_until(lambda: abs(sim.joints[0]) > 0.1, 60.0)
            sim.collide(joint=1)
        shown.until_it_shows(b"Enter")
        shown.program.send_signal(signal.SIGINT)
        assert shown.exit_code() == -signal.SIGINT
        assert not sim.moving


@pytest.mark.slow
def test_a_log_of_lines_of_json() -> None:
    lines = [
        json.loads(line) for line in run(str(EXAMPLES / "log_to_json.py"), speed=4).splitlines()
    ]
    assert {"call", "motion"} <= {line["kind"] for line in lines}
    assert [line["outcome"] for line in lines if line["kind"] == "motion"] == ["finished"]


@pytest.mark.slow
def test_pressing_on_a_table() -> None:
    said = run(str(EXAMPLES / "press_on_table.py"), speed=1)
    about = r"-(19|20|21) N\n"
    assert re.fullmatch(f"pressing: {about}moved by 50 mm: {about}let go: 0 N\n", said)


def test_a_port_that_is_no_number_is_a_wrong_argument() -> None:
    """By argparse, and not by a traceback, which says nothing of a port."""
    files = [*EXAMPLES.glob("*.py"), EXAMPLES / "manual" / "cabinet.py"]
    assert not [file.name for file in files if "int(sys.argv" in file.read_text("utf-8")]
    done = python(str(EXAMPLES / "01_connect_and_move.py"), "127.0.0.1", "70O3")
    assert done.returncode == 2
    assert done.stderr.endswith("argument port: invalid int value: '70O3'\n")


def test_two_arms_are_two_or_simulated() -> None:
    for arguments, code, told in (
        (("nowhere.invalid",), 2, "addresses of two arms"),
        (("--help",), 0, "two simulated arms"),
    ):
        done = python(str(EXAMPLES / "two_arms.py"), *arguments)
        assert (done.returncode, told in done.stdout + done.stderr) == (code, True), done


async def test_no_arm_goes_into_the_shared_place_while_the_other_leaves_it() -> None:
    """One that the program found there was on its way out, when the other one went in."""
    module = example("two_arms")
    sent: list[tuple[str, aioduco.Joints]] = []
    out = asyncio.Event()

    def arm(name: str) -> SimpleNamespace:
        async def movej2(goal: aioduco.Joints, **_: float) -> None:
            sent.append((name, goal))
            await (out.wait() if name == "left" else asyncio.sleep(0))

        return SimpleNamespace(motion=SimpleNamespace(movej2=movej2))

    place = anyio.Lock()
    async with anyio.create_task_group() as tasks:
        for name in ("left", "right"):
            tasks.start_soon(module.work, name, arm(name), place)
        await anyio.wait_all_tasks_blocked()
        assert ("right", module.SHARED) not in sent
        out.set()
    assert sent.count(("right", module.SHARED)) == module.ROUNDS


def test_each_is_in_the_table_of_the_page() -> None:
    page = (EXAMPLES.parent / "docs" / "index.md").read_text(encoding="utf-8")
    for path in EXAMPLES.glob("*.py"):
        assert f"{path.name}`" in page, path
        lines = path.read_text(encoding="utf-8").splitlines()
        assert len(lines) < 130, path
        assert lines[0].startswith('"""'), path


def test_each_is_short_and_opens_with_its_goal() -> None:
    for path in EXAMPLES.glob("0[1-37]_*.py"):
        lines = path.read_text(encoding="utf-8").splitlines()
        assert len(lines) <= 62, path
        assert path.name in SAYS


_EXECUTED = """
import sys
import nbclient, nbformat

book = nbformat.read(sys.argv[1], as_version=4)
nbclient.NotebookClient(book, timeout=None, kernel_name="python3").execute()
for cell in book.cells:
    for output in cell.get("outputs", ()):
        print(output.get("text", "") or output.get("data", {}).get("text/plain", ""))
"""


@pytest.mark.slow
def test_the_notebook_runs_from_its_first_cell_to_its_last(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("nbclient", "ipykernel"):  # looked for, since importing them warns
        if importlib.util.find_spec(name) is None:
            pytest.skip("needs pip install 'aioduco[examples]'")
    monkeypatch.delenv("AIODUCO_HOST", raising=False)
    path = EXAMPLES / "notebook.ipynb"
    cells = json.loads(path.read_text("utf-8"))["cells"]
    assert not any(cell.get("outputs") for cell in cells), "it is kept without outputs"
    assert sum(len(cell["source"]) for cell in cells) < 120
    done = python("-c", _EXECUTED, str(path), timeout=110)
    assert done.returncode == 0, done.stderr
    assert "50 mm down" in done.stdout
    assert "FINISHED finished" in done.stdout
