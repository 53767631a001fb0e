"""The demonstration, `aioduco demo`: on its own arm, on another one, and ended in its middle."""

from __future__ import annotations

import json
import logging
import os
import signal
import socket
import subprocess
from pathlib import Path

import pytest
from interpreter import python
from moments import complaints
from patient import COMMAND_LINE
from terminals import terminal
from test_cli import PNG, address, process, run, wait_until_it_moves

import aioduco
import aioduco.sync
from aioduco.cli.demo_run import LEFT, Choreography
from aioduco.models.enums import RobotState
from aioduco.sim import Simulator


@pytest.mark.slow
@pytest.mark.timeout(330)  # the program's own limit ends it first, and shows what it said
def test_demo_without_a_terminal(tmp_path: Path) -> None:
    """The whole of it: an arm in a process of its own, plain lines, a plot, and a result."""
    plot, result = tmp_path / "demo.png", tmp_path / "demo.json"
    # Slowly: a motion is stopped in its middle, and a line has to come before the last one ends,
    # for which a busy machine then has seconds.
    words = ("demo", "--speed", "0.25", "--plot", str(plot), "--json", str(result))
    done = python(*COMMAND_LINE[1:], *words, stdin=subprocess.DEVNULL, timeout=300)
    told = result.read_text(encoding="utf-8") if result.exists() else done.stdout
    assert (done.returncode, complaints(done.stderr)) == (0, ""), told
    assert "\x1b" not in done.stdout, "no colours and no cursor movements outside a terminal"
    assert len(done.stdout.splitlines()) < 50

    report = json.loads(told)
    outcomes = [motion["outcome"] for motion in report["motions"]]
    assert report["ok"] is True
    assert {"finished", "blended", "stopped"} == set(outcomes)
    assert all(motion["name"] in done.stdout for motion in report["motions"])
    assert all(motion["duration"] > 0 for motion in report["motions"])
    assert report["carried"] is True
    assert "the gripper holds the box" in done.stdout
    assert 0 < report["greatest_tracking_error"] < 5e-3

    assert plot.read_bytes().startswith(PNG)
    assert plot.stat().st_size < 200_000, "small enough for the README"


IMPORTS = """
import importlib.abc, sys, threading
import anyio, anyio.abc, anyio._core._signals
import aioduco
from aioduco.cli.app import app
from aioduco.cli import demo_run as run

# A busy machine takes its time over a beat.
defaults = aioduco.connect.__kwdefaults__
defaults |= {"heartbeat": 20.0, "loop_stall_limit": 15.0, "call_timeout": 10.0}

found = []

class Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        found.append((name, threading.current_thread() is threading.main_thread()))

perform, opened = run.perform, aioduco.Robot.__aenter__

async def performing(*arguments):
    sys.meta_path.insert(0, Finder())
    return await perform(*arguments)

async def opening(robot):
    await opened(robot)
    found.append(("OPEN", True))
    return robot

run.perform, aioduco.Robot.__aenter__ = performing, opening
sys.argv = ["aioduco", "demo", "--speed", "8", "--no-plot", "--json", "-"]
try:
    app()
finally:
    sys.meta_path.pop(0)
    print([name for name, _ in found].count("OPEN"), file=sys.stderr)
    later = found[found.index(("OPEN", True)) + 1:]
    others = [name for name, on_loop in found if on_loop] + [name for name, _ in later]
    # What rich loads to draw a table of characters is small too, and what the watchdog of the loop
    # loads to say that a busy machine held it up.
    small = ("aioduco.supervision.", "aioduco._process.program_lines", "rich._unicode_data", "OPEN")
    print([name for name in others if not name.startswith(small)], file=sys.stderr)
"""


@pytest.mark.slow
def test_demo_loads_all_before_its_event_loop_runs_and_gives_its_result_alone_on_the_output() -> (
    None
):
    """Loading holds up the loop; a robot that is open has no time for that.

    How the demonstration ends is another test's: the simulated clock runs fast here.
    """
    done = python("-W", "error", "-c", IMPORTS)
    said = complaints(done.stderr)
    assert said.endswith("\n1\n[]\n")
    assert "to the start" in said
    report = json.loads(done.stdout)
    assert done.returncode == (0 if report["ok"] else 1), report


def test_demo_asks_before_it_moves_an_arm_that_it_did_not_make() -> None:
    with Simulator() as sim:
        for typed in ("n\n", "", "\n"):
            answer = run("demo", *address(sim), "--no-plot", "--json", "-", typed=typed)
            assert answer.exit_code == 3
            assert "Move the arm?" in answer.stderr
            assert "Move the arm?" not in answer.stdout  # only the result is written there
            assert "nothing was sent that moves the arm" in answer.output
            assert sim.view.robot is RobotState.POWER_OFF
        said = answer.output
    for what in (
        "robot POWER_OFF",
        "this plan is for a gcr5_910",
        "safety",
        "turns by",
        "°/s",
        "mm/s",
        "emergency stop",
    ):
        assert what in said


@pytest.mark.slow
def test_the_demo_names_commands_for_its_arm_in_its_error() -> None:
    with Simulator() as sim:
        sim.emergency_stop()
        answer = run("demo", *address(sim), "--no-plot", "--yes", "--json", "-")
        assert answer.exit_code == 1
        where = f"{sim.host}:{sim.port}"
        assert f"then call `aioduco bring-up {where}` again" in json.loads(answer.stdout)["error"]
    assert logging.lastResort is not None
    warning = logging.makeLogRecord({"msg": "call robot.recover() to go on"})
    assert logging.lastResort.format(warning) == f"call `aioduco recover {where}` to go on"


@pytest.mark.slow
def test_demo_runs_on_another_arm_once_that_is_confirmed() -> None:
    with Simulator("gcr10_1300", speed=1) as sim:
        answer = run("demo", *address(sim), "--model", "gcr10_1300", "--no-plot", typed="y\n")
        assert answer.exit_code == 0, answer.output
        assert not sim.moving
        assert sim.get_digital_output(1) is False


@pytest.mark.slow
def test_demo_is_slower_on_an_arm_that_it_did_not_make(monkeypatch: pytest.MonkeyPatch) -> None:
    plans: list[Choreography] = []

    async def perform(robot: aioduco.Robot, plan: Choreography, shown: object) -> None:
        plans.append(plan)

    monkeypatch.setattr("aioduco.cli.demo_run.perform", perform)
    run("demo", "--no-plot")
    run("demo", "--host", "192.0.2.1", "--yes", "--no-plot")
    simulated, careful = plans
    assert careful.start == simulated.start
    for speed in ("joint_speed", "joint_acceleration", "line_speed", "line_acceleration"):
        assert getattr(careful, speed) == getattr(simulated, speed) / 4


def test_demo_without_a_controller_says_so() -> None:
    with socket.create_server(("127.0.0.1", 0)) as closed:
        port = closed.getsockname()[1]
    parts = ("--host", "127.0.0.1", "--port", str(port))
    for words in (parts, (*parts, "--yes"), ("--host", f"127.0.0.1:{port}")):
        answer = run("demo", *words, "--no-plot")
        assert answer.exit_code == 1
        assert f"cannot connect to 127.0.0.1:{port}" in answer.output.replace("\n", "")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "status", "times"),
    [(signal.SIGINT, 130, 1), (signal.SIGINT, 130, 3), (signal.SIGTERM, 143, 1)],
)
def test_demo_leaves_a_standing_arm_when_it_is_told_to_end(
    number: signal.Signals, status: int, times: int
) -> None:
    """Also when Ctrl-C is pressed again while the arm is being stopped."""
    with Simulator(joints=LEFT) as sim:
        with process("demo", *address(sim), "--yes", "--no-plot", "--json", "-") as demo:
            wait_until_it_moves(sim)
            for _ in range(times):
                demo.send_signal(number)
            output, _ = demo.communicate(timeout=60)
        assert demo.returncode == status
        assert not sim.moving
        report = json.loads(output)
        assert report["error"] == "interrupted: the arm was stopped, and stands"
        assert report["motions"][-1]["outcome"] == "stopped"


@pytest.mark.slow
def test_demo_reports_what_went_wrong() -> None:
    with Simulator(joints=LEFT) as sim:
        with process("demo", *address(sim), "--yes", "--no-plot") as demo:
            wait_until_it_moves(sim)
            sim.collide(3)
            output, errors = demo.communicate(timeout=60)
        assert (demo.returncode, errors) == (1, "")
        assert "error: movej2" in output
        assert not sim.moving


@pytest.mark.slow
def test_demo_on_a_terminal_shows_the_arm_while_it_moves(tmp_path: Path) -> None:
    """With a Ctrl-C typed there, which its own simulator must survive."""
    plot = str(tmp_path / "demo.png")
    with terminal("demo", "--plot", plot, command=COMMAND_LINE) as demo:
        demo.until_it_shows(b"over the pick")
        os.killpg(demo.program.pid, signal.SIGINT)
        demo.until_it_shows(b"interrupted: the arm was stopped, and stands")
        assert demo.exit_code() == 130
    assert b"J6" in demo.seen
    assert b"mm" in demo.seen
