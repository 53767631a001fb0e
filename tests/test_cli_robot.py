"""The commands that read and move an arm."""

from __future__ import annotations

import json
import math
import os
import re
import shlex
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import typer
from for_each import for_each
from interpreter import python
from patient import COMMAND_LINE
from test_cli import address, process, run, wait_until_it_moves

import aioduco
import aioduco.sync
from aioduco.cli.addresses import RobotAddress, robot_at
from aioduco.cli.robots_file import robots_file
from aioduco.cli.status import readiness
from aioduco.models.enums import ProgramState, RobotState
from aioduco.recording.playback import WaypointFile
from aioduco.sim import Simulator
from aioduco.testing import eventually

HOME = (0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0)


def at(sim: Simulator) -> str:
    return f"{sim.host}:{sim.port}"


@contextmanager
def ready_arm(**options: Any) -> Iterator[Simulator]:
    """An arm that is powered and enabled."""
    with Simulator(joints=HOME, **options) as sim:
        with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as robot:
            robot.bring_up()
        yield sim


@pytest.fixture(autouse=True)
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of settings of its own, with no robots in it yet."""
    monkeypatch.delenv("AIODUCO_HOST", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    folder = tmp_path / "aioduco"
    folder.mkdir()
    return folder / "robots.toml"


# -- which robot ---------------------------------------------------------------------------------


def test_a_robot_is_an_address_a_name_the_environment_or_a_default(
    config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert str(robot_at(None)) == "127.0.0.1:7003"
    config.write_text('default = "left"\n[left]\nhost = "10.0.0.1"\n[right]\nhost="r"\nport=7\n')
    assert str(robot_at(None)) == "left (10.0.0.1:7003)"
    monkeypatch.setenv("AIODUCO_HOST", "right")
    assert str(robot_at(None)) == "right (r:7)"
    assert str(robot_at(None, 9)) == "right (r:9)"
    for given, host, port in (
        ("left", "10.0.0.1", 7003),
        ("10.0.0.2", "10.0.0.2", 7003),
        ("arm.lan:7004", "arm.lan", 7004),
        ("::1", "::1", 7003),
        ("[::1]", "::1", 7003),
        ("[::1]:7004", "::1", 7004),
    ):
        found = robot_at(given)
        assert (found.host, found.port) == (host, port), given
        assert robot_at(given, port) == found
    with pytest.raises(typer.BadParameter, match=r"arm.lan:7004.*--port is 8114"):
        robot_at("arm.lan:7004", 8114)
    monkeypatch.setenv("XDG_CONFIG_HOME", "not/absolute")
    monkeypatch.setenv("HOME", "/home/somebody")
    assert str(robots_file()) == "/home/somebody/.config/aioduco/robots.toml"


def test_an_address_of_numbers_is_that_address_whatever_the_file_is(config: Path) -> None:
    """It was taken for the name of another arm, and a file that hangs held up a stop."""
    config.write_text('["10.0.0.1"]\nhost = "10.0.0.2"\n')
    assert robot_at("10.0.0.1").host == "10.0.0.1"
    config.unlink()
    os.mkfifo(config)
    assert robot_at("10.0.0.1:7004").port == 7004


@for_each(
    "text, said",
    [
        ("[left", "cannot be read"),
        ('left = "10.0.0.1"', "[left] needs a line such as host"),
        ("[left]\nport = 1", "[left] needs a line such as host"),
        ('[left]\nhost = "a"\nport = 70000', "port = 70000"),
        ('[left]\nhost = "a"\nspeed = 1', "'speed'"),
        ('default = "right"\n[left]\nhost = "a"', "there are left"),
        ('[default]\nhost = "a"\n[left]\nhost = "a"', "a robot cannot be called default"),
        ("default = 3", "default is the name of a robot"),
        ('[left]\nhost = ""', "host of [left] is ''"),
        ('[left]\nhost = "a b"', "host of [left]"),
    ],
)
def test_a_file_of_robots_that_is_wrong_is_a_wrong_option(
    config: Path, text: str, said: str
) -> None:
    config.write_text(text)
    answer = run("status", "left")
    assert answer.exit_code == 2
    assert said in " ".join(answer.output.replace("│", " ").split())


@pytest.mark.cases(3)
@pytest.mark.parametrize(
    "words",
    [
        ("status", ""),
        ("stop", ""),
        ("stop", " "),
        ("pause", ""),
        ("call", "get_tcp_pose", "--host", ""),
    ],
)
def test_an_empty_address_is_no_other_arm(
    words: tuple[str, ...], config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Such as that of an unset variable of a script."""
    monkeypatch.setenv("AIODUCO_HOST", "10.0.0.9")
    config.write_text('default = "left"\n[left]\nhost = "10.0.0.1"\n')
    answer = run(*words)
    assert answer.exit_code == 2
    assert "is a variable empty?" in " ".join(answer.output.replace("│", " ").split())
    monkeypatch.setenv("AIODUCO_HOST", "")
    with pytest.raises(typer.BadParameter, match="AIODUCO_HOST is ''"):
        robot_at(None)


def test_an_address_needs_no_file_of_robots(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config.write_text("[left")
    assert str(robot_at("10.0.0.3")) == "10.0.0.3:7003"
    assert str(robot_at("[::1]:7004")) == "[::1]:7004"
    with pytest.raises(typer.BadParameter, match="cannot be read"):
        robot_at("left")

    def nobody() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CONFIG_HOME")
    monkeypatch.setattr(Path, "home", nobody)
    assert robots_file() is None
    assert str(robot_at("10.0.0.3")) == "10.0.0.3:7003"
    assert str(robot_at(None)) == "127.0.0.1:7003"
    with pytest.raises(typer.BadParameter):
        robot_at("left robot")


# -- looking -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_status_says_how_the_arm_is() -> None:
    with Simulator(joints=HOME) as sim:
        shown = run("status", at(sim), "--json")
        found = json.loads(shown.stdout)
        assert found["joints"] == pytest.approx(HOME, abs=1e-6)
        assert (found["robot"], found["ready"], found["moving"]) == ("POWER_OFF", False, False)
        assert (found["host"], found["port"]) == (sim.host, sim.port)
        assert run("status", at(sim), "--ready").exit_code == 1
        sim.emergency_stop()
        eventually(lambda: "EMERGENCY STOP" in run("status", at(sim)).stdout)
        assert "90.00°" in run("status", at(sim)).stdout
        gone = at(sim)
    assert run("status", gone).exit_code == 1


@pytest.mark.slow
def test_a_safety_stop_without_its_cause_is_not_ready() -> None:
    """After a collision was reset, the safety stop remains, and the controller refuses motions."""
    with ready_arm() as sim:
        assert run("status", at(sim), "--ready").exit_code == 0
        sim.collide(3)
        eventually(lambda: json.loads(run("status", at(sim), "--json").stdout)["collision_joint"])
        assert run("call", "collision_detection_reset", "--yes", *address(sim)).exit_code == 0
        found = run("status", at(sim), "--ready")
        assert "robot ENABLE, program STOPPED, safety STOP2" in found.stdout
        assert "aioduco recover" in found.stdout
        assert found.exit_code == 1
        refused = run("move", "joints", *map(str, HOME), "--yes", *address(sim))
        assert refused.exit_code == 1
        assert f"safety STOP2; nothing was sent; see the states; `aioduco recover {at(sim)}`" in (
            " ".join(refused.stderr.split())
        )


@pytest.mark.slow
def test_inputs_and_outputs_are_read_and_set() -> None:
    with Simulator() as sim:
        sim.set_digital_input(3, True)
        eventually(
            lambda: json.loads(run("io", "read", "--json", *address(sim)).stdout)["inputs"][2]
        )
        assert "inputs        3" in run("io", "read", *address(sim)).stdout
        assert run("io", "set", "5", "on", *address(sim)).exit_code == 3
        assert not sim.get_digital_output(5)
        assert run("io", "set", "5", "on", *address(sim), typed="y\n").exit_code == 0
        assert sim.get_digital_output(5)
        assert run("io", "set", "2", "on", "--tool", "--yes", *address(sim)).exit_code == 0
        assert run("io", "set-analog", "voltage", "1", "2.5", "-y", *address(sim)).exit_code == 0
        found = json.loads(run("io", "read", "--json", *address(sim)).stdout)
        assert found["tool_outputs"] == [False, True]
        assert found["voltages_out"][0] == pytest.approx(2.5)


@pytest.mark.slow
def test_an_arm_is_shown_live_until_told_to_end() -> None:
    """That watchers read what the arm does is tested with `robot.publish`."""
    with Simulator() as sim, process("view", "--foxglove", at(sim), "--listen", "0") as view:
        assert view.stdout is not None
        said = view.stdout.readline()
        port = said.partition(" is on ws://127.0.0.1:")[2].split(";")[0]
        taken = run("view", "--foxglove", at(sim), "--listen", port)
        assert taken.exit_code == 1
        assert f"127.0.0.1:{port} cannot be opened" in taken.output
        view.send_signal(signal.SIGINT)
        _, errors = view.communicate(timeout=60)
    assert (view.returncode, errors) == (0, "")


def test_what_to_view_with_is_to_be_said() -> None:
    answer = run("view", "192.0.2.1")
    assert answer.exit_code == 2
    assert "--foxglove" in answer.output


# -- leading -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_an_arm_is_brought_up_and_recovered_once_that_is_confirmed() -> None:
    with Simulator(speed=10) as sim:
        declined = run("bring-up", at(sim), typed="n\n")
        assert declined.exit_code == 3
        assert "brakes" in declined.stderr
        assert sim.view.robot.name == "POWER_OFF"
        done = run("bring-up", at(sim), "--yes", "--json")
        assert json.loads(done.stdout)["robot"] == "ENABLE"
        sim.emergency_stop()
        pressed = run("recover", at(sim), "--yes")
        assert (pressed.exit_code, "emergency stop" in pressed.stderr) == (5, True)
        sim.release_emergency_stop()
        recovered = run("recover", at(sim), typed="y\n")
        assert recovered.exit_code == 0
        assert "tare again with nothing touched" in recovered.stderr
        sim.collide(3)
        again = run("bring-up", at(sim), "--yes", "--json")
        assert again.exit_code == 0, again.stderr
        advice = json.loads(again.stdout)["advice"]
        assert "After the collision it may still touch something" in advice
        tare = advice.split("`")[1].removeprefix("aioduco ")
        assert run(*shlex.split(tare), "--yes").exit_code == 0, advice
        assert "tare again with nothing touched" in again.stderr
        assert sim.view.robot.name == "ENABLE"


@pytest.mark.slow
def test_who_stops_pauses_and_resumes_leaves_the_supervision_to_the_program() -> None:
    """An arm that a program moves is paused, resumed and stopped from a shell."""
    with ready_arm() as sim:
        with aioduco.sync.connect(
            sim.host, sim.port, heartbeat=30.0, call_timeout=30.0, clock=sim.clock
        ) as robot:
            away = (2.0, *HOME[1:])
            task = robot.motion.movej2.start(away, v=0.05, a=1.0)
            wait_until_it_moves(sim)
            assert run("pause", at(sim)).exit_code == 0
            assert not sim.moving
            paused = sim.joints
            assert run("resume", at(sim), typed="n\n").exit_code == 3
            assert sim.joints.almost_equal(paused, 1e-3)
            assert run("resume", at(sim), "--yes").exit_code == 0
            # Leaving the command has stopped nothing, and the program's heartbeat still counts.
            sim.wait_until(lambda: abs(sim.joints.j1 - paused.j1) > 0.05, timeout=30)
            stopped = run("stop", at(sim), "--json")
            assert json.loads(stopped.stdout)["program"] == "STOPPED"
            assert not sim.moving
            with pytest.raises(aioduco.TaskStopped):
                task.wait()
        assert sim.view.program is ProgramState.STOPPED
        again = run("resume", at(sim), "--yes")
        assert (again.exit_code, "nothing was paused" in again.stderr) == (1, True)
        again = run("pause", at(sim))
        assert (again.exit_code, again.stdout) == (1, "")
        assert "nothing was paused: the arm stands, and may be moved" in again.stderr
        again = run("resume", at(sim), "--yes", "--json")
        assert (again.exit_code, json.loads(again.stdout)["program"]) == (1, "STOPPED")


# -- moving --------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_move_says_what_turns_and_asks() -> None:
    motion = ("move", "joints", "30", "0", "90", "0", "-90", "0", "--deg", "-v", "2", "-a", "5")
    with ready_arm() as sim:
        declined = run(*motion, *address(sim), typed="\n")
        assert declined.exit_code == 3
        for what in ("Joint 1 turns by 30°", "115 °/s", "emergency stop"):
            assert what in declined.stderr
        assert sim.joints.almost_equal(HOME, 1e-6)
        done = run(*motion, *address(sim), "--yes", "--json")
        ended = json.loads(done.stdout)
        assert ended["outcome"] == "FINISHED"
        assert ended["joints"][0] == pytest.approx(math.radians(30), abs=1e-3)
        back = ("move", "joints", "-0.1", "0", "0", "0", "0", "0", "--by", "-v", "2", "-a", "5")
        assert run(*back, *address(sim), "-y").exit_code == 0
        assert sim.joints.j1 == pytest.approx(math.radians(30) - 0.1, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("play", "points.toml", "--no-rehearse"),
        ("payload", "--poses", "points.toml"),
        ("demo", "--host"),
        ("teleop",),
        ("teach",),
        ("tool", "touch"),
    ],
    ids=lambda words: words[0],
)
def test_an_arm_that_was_stopped_by_the_button_during_the_question_stays_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    """The command switched it on again, and moved it, or let it give way to a hand."""
    monkeypatch.chdir(tmp_path)
    file = WaypointFile.new()
    for name in "abcdef":
        file.add(name, HOME)
    file.save("points.toml")
    with ready_arm(speed=math.inf) as sim:

        def confirm(*_: object, **__: object) -> bool:
            sim.emergency_stop()
            sim.release_emergency_stop()
            return True

        monkeypatch.setattr("typer.confirm", confirm)
        done = run(*words, f"{sim.host}:{sim.port}")
        assert (done.exit_code, "the arm is no longer as" in done.stderr) == (1, True), done.output
        with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as robot:
            assert robot.state.get_robot_state().robot is not RobotState.ENABLE


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("move", "joints", "0", "0", "0", "0", "0", "0.1", "--by", "--host"),
        ("move", "pose", "0", "0", "-0.01", "0", "0", "0", "--by", "--host"),
        ("play", "points.toml", "--no-rehearse"),
        ("demo", "--no-plot", "--host"),
        ("jog", "j1", "+", "--step", "0.1", "--host"),
        ("check", "--motions", "run.mcap"),
        ("payload", "--poses", "points.toml"),
    ],
    ids=lambda words: words[0] + words[1],
)
def test_an_arm_that_was_moved_during_the_question_is_not_moved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    """The command moved it to what was said of another place, by any way there was."""
    monkeypatch.chdir(tmp_path)
    file = WaypointFile.new()
    for number in range(8):
        file.add(f"p{number}", HOME)
    file.save("points.toml")
    with ready_arm(speed=math.inf) as sim:

        def confirm(*_: object, **__: object) -> bool:
            with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as robot:
                robot.motion.movej2((1.0, *HOME[1:]), v=1.0, a=1.0)
            return True

        monkeypatch.setattr("typer.confirm", confirm)
        done = run(*words, f"{sim.host}:{sim.port}")
        assert (done.exit_code, "the arm is elsewhere than" in done.stderr) == (1, True), (
            done.output
        )
        assert sim.joints.almost_equal((1.0, *HOME[1:]), 1e-3)


@pytest.mark.slow
def test_a_tool_that_came_into_use_during_the_question_is_not_moved(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The arm turned over to bring its tip to where the flange was to stay."""
    with ready_arm(speed=math.inf) as sim:

        def confirm(*_: object, **__: object) -> bool:
            with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as robot:
                robot.frames.set_tool_data("long", (0, 0, 0.2, 0, 0, 0), (1, 0, 0, 0.1))
            return True

        monkeypatch.setattr("typer.confirm", confirm)
        words = ("move", "pose", "0", "0", "0", "0", "0", "0", "--by", "--joints")
        done = run(*words, *address(sim))
        assert (done.exit_code, "its tool" in done.stderr) == (1, True), done.output
        assert sim.joints.almost_equal(HOME, 1e-3)


@pytest.mark.slow
def test_the_tool_is_moved_and_jogged() -> None:
    with ready_arm() as sim:
        begin = json.loads(run("status", at(sim), "--json").stdout)["pose"]
        up = ("move", "pose", "0", "0", "-20", "0", "0", "0", "--mm", "--by", "--speed", "0.5")
        done = run(*up, *address(sim), typed="y\n")
        assert done.exit_code == 0, done.output
        assert "It is 20 mm away" in done.stderr
        assert "finished after" in done.stdout
        there = json.loads(run("status", at(sim), "--json").stdout)["pose"]
        assert math.dist(there[:3], begin[:3]) == pytest.approx(0.02, abs=1e-3)
        step = ("jog", "j1", "-", "--step", "2", "--deg", "--percent", "20")
        assert run(*step, *address(sim)).exit_code == 3
        now = sim.joints.j1
        assert run(*step, *address(sim), "--yes").exit_code == 0
        assert sim.joints.j1 - now == pytest.approx(math.radians(-2), abs=1e-3)
        jogged = run("jog", "z", "+", "--step", "5", "--mm", "--frame", "tool", "-y", *address(sim))
        assert jogged.exit_code == 0, jogged.output


@pytest.mark.slow
def test_a_pose_in_a_work_object_is_told_in_it() -> None:
    """It was told in the base's frame, beside a target and a distance in the work object."""
    with ready_arm(speed=math.inf) as sim:
        with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as robot:
            robot.frames.set_wobj("table", (0.1, 0.2, 0.3, 0, 0, 0.5))
            there = robot.state.get_tcp_pose_coord().shifted(z=0.02)
        done = run("move", "pose", *map(str, there), "--yes", "--json", *address(sim))
        told = json.loads(done.stdout)["pose"]
        assert there.almost_equal(told, position=1e-3, rotation=1e-3)


def test_an_arm_that_is_not_ready_is_not_moved() -> None:
    with Simulator() as sim:
        answer = run("move", "joints", *"000000", "--yes", *address(sim))
    assert answer.exit_code == 1
    assert "robot POWER_OFF" in answer.output
    assert "aioduco bring-up" in answer.output


@pytest.fixture(scope="module")
def standing() -> Iterator[Simulator]:
    with ready_arm() as sim:
        yield sim


@for_each(
    "words, said",
    [
        ("move joints 0 0", "takes 6 values"),
        ("move joints 9 0 0 0 0 0 --yes", "from -6.283 to 6.283 rad"),
        ("jog j7 + --yes", "j1 to j6"),
        ("jog j1 + --step 1 --mm", "radians"),
        ("jog x + --step 1 --deg", "metres"),
        ("move joints nan 0 0 0 0 0", "joints[0] is nan"),
        ("move joints 0 0 1.57 0 -1.57 0 --speed 50", "speed is 50.0"),
        ("move joints 90 0 0 0 0 0", "(radians, not degrees)"),
        ("move pose inf 0 0 0 0 0", "x is inf"),
        ("move pose 0 0 -50 0 0 0 --by", "a finite number in m, and within"),
        ("move pose 0 0 0 0 0 0 --by --acceleration nan", "acceleration is nan"),
        ("jog z + --step 50", "(millimetres?)"),
        ("io set 5 on --tool", "number is 5"),
        ("io set-analog voltage 1 20", "value is 20.0"),
        ("io set-analog voltage 1 -1", "value is -1.0"),
        ("io set-analog voltage -1 1", "greater than or equal to 1"),
        ("io set -1 on", "greater than or equal to 1"),
        ("jog j1 -1", "is not one of"),
        ("call movej2 [0,0,0,0,0,0] v=100 a=1 --yes", "v is 100"),
    ],
)
def test_what_cannot_be_done_is_a_wrong_option_of_which_nothing_is_asked(
    words: str, said: str, standing: Simulator
) -> None:
    answer = run(*words.split(), *address(standing))
    told = " ".join(answer.stderr.replace("│", " ").split())
    assert (answer.exit_code, said in told) == (2, True), answer.output
    assert "Move the arm?" not in answer.output
    assert standing.joints.almost_equal(HOME, 1e-6)


@contextmanager
def move() -> Iterator[tuple[Simulator, subprocess.Popen[str]]]:
    """A command that moves the arm, which does."""
    with ready_arm() as sim:
        words = ("move", "joints", "2", "0", "1.5", "0", "-1.5", "0", "--yes", *address(sim))
        with process(*words) as moving:
            wait_until_it_moves(sim)
            yield sim, moving


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_move_that_is_told_to_end_leaves_a_standing_arm(number: signal.Signals) -> None:
    with move() as (sim, moving):
        moving.send_signal(number)
        _, errors = moving.communicate(timeout=60)
        assert (moving.returncode, not sim.moving) == (128 + number, True), errors
        assert "the arm was stopped, and stands" in errors


@pytest.mark.slow
@pytest.mark.linux("SIGHUP")
@pytest.mark.usefixtures("hangups")
def test_a_move_whose_terminal_is_closed_leaves_a_standing_arm() -> None:
    with move() as (sim, moving):
        assert moving.stderr is not None
        moving.stderr.close()
        moving.send_signal(signal.SIGHUP)
        assert moving.wait(60) == 128 + signal.SIGHUP
        assert not sim.moving


@pytest.mark.slow
@pytest.mark.linux("SIGHUP")
def test_a_move_under_nohup_goes_on_without_its_terminal() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with move() as (_, moving):
            moving.send_signal(signal.SIGHUP)
            _, errors = moving.communicate(timeout=60)
            assert moving.returncode == 0, errors
    finally:
        signal.signal(signal.SIGHUP, before)


# -- for shells ----------------------------------------------------------------------------------


@for_each("shell", ["bash", "zsh", "fish"])
def test_a_shell_completes_the_commands(shell: str) -> None:
    script = run("completion", shell)
    assert script.exit_code == 0
    assert f"complete_{shell}" in script.stdout


COMPLETED = "import sys; from aioduco.cli import main; sys.argv = ['aioduco']; main()"


@pytest.mark.slow
def test_commands_and_names_of_robots_are_completed(config: Path) -> None:
    config.write_text('[left]\nhost = "a"\n[lower]\nhost = "b"\n[right]\nhost = "c"\n')

    def completed(*words: str) -> list[str]:
        typed = " ".join(("aioduco", *words))
        done = python(
            "-c",
            COMPLETED,
            env={
                "XDG_CONFIG_HOME": str(config.parents[1]),
                "_AIODUCO_COMPLETE": "complete_bash",
                "COMP_WORDS": typed,
                "COMP_CWORD": str(len(words)),
            },
        )
        assert done.stderr == ""
        return done.stdout.split()

    assert completed("bring") == ["bring-up"]
    assert completed("status", "l") == ["left", "lower"]
    assert completed("move", "joints", "--host", "r") == ["right"]
    assert "get_tcp_pose" in completed("call", "get_tcp")


HEAVY = """
import sys
from aioduco.cli.app import app
heavy = {"numpy", "mujoco", "matplotlib", "thriftpy2", "foxglove", "PIL", "scipy", "aioduco.sync"}
print(sorted(heavy & set(sys.modules)))
"""


@pytest.mark.slow
def test_the_command_line_loads_little_before_it_knows_what_to_do() -> None:
    done = python("-W", "error", "-c", HEAVY)
    assert (done.returncode, done.stdout, done.stderr) == (0, "[]\n", "")


@for_each("device", ["gamepad", "spacemouse"])
def test_a_missing_device_is_a_wrong_option_before_anything_is_asked(device: str) -> None:
    answer = run("teleop", "127.0.0.1:1", "--device", device, "--path", "/no/device", "--yes")
    assert (answer.exit_code, "cannot connect" in answer.stderr) == (2, False)
    assert "/no/device" in answer.stderr


@pytest.mark.slow
def test_the_tool_is_led_by_keys_after_a_question() -> None:
    with ready_arm() as sim:
        refused = run("teleop", at(sim), typed="n\n")
        assert refused.exit_code == 3, refused.output
        assert "Lead the arm?" in refused.stderr
        assert sim.joints.array == pytest.approx(HOME, abs=1e-3)
        program = subprocess.Popen(
            [*COMMAND_LINE, "teleop", at(sim), "--yes", "--joints"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        assert program.stdin is not None
        assert program.stdout is not None
        assert b"q ends" in program.stdout.readline(), program.communicate()
        keys = program.stdin.fileno()

        def turned() -> bool:
            os.write(keys, b"u")
            return abs(sim.joints.j6) > 0.01

        eventually(turned, 30.0)
        said, errors = program.communicate(b"q", timeout=30)
        assert (program.returncode, errors) == (0, b"")
        assert b"led " in said
        assert not sim.view.moving


@for_each(
    "changed, words",
    [
        ({"program": ProgramState.PAUSED}, "aioduco resume arm:7004.*aioduco stop arm:7004"),
        ({"program": ProgramState.RUNNING}, "aioduco stop arm:7004"),
        ({"program": ProgramState.TASK_RUNNING}, "a motion runs"),
        ({"robot": RobotState.POWER_OFF}, "aioduco bring-up arm:7004"),
        ({"robot": RobotState.DISABLE}, "aioduco bring-up"),
        ({"robot": RobotState.POWER_OFF, "emergency_stop": True}, "release the emergency stop"),
        ({"collision_joint": 2}, "see that the arm is free, then `aioduco recover arm:7004`"),
        ({"robot": RobotState.UPDATE}, "see the states"),
        ({"ready": True}, "a motion would start"),
    ],
)
def test_status_names_the_command_that_helps(changed: dict[str, Any], words: str) -> None:
    found = {
        "ready": False,
        "emergency_stop": False,
        "collision_joint": None,
        "robot": RobotState.ENABLE,
        "program": ProgramState.STOPPED,
    }
    assert re.search(words, readiness(RobotAddress("arm", 7004), found | changed))
