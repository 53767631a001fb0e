"""`aioduco tool touch` and `aioduco payload`: the dialogue, and what is written."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_runner import CliRunner
from for_each import for_each
from test_cli_robot import HOME, at, ready_arm

import aioduco.sync
from aioduco import Load, Pose
from aioduco.cli import payload
from aioduco.cli.app import app
from aioduco.models.rotation import matrix_from_rotvec
from aioduco.recording.playback import WaypointFile
from aioduco.sim import Simulator
from aioduco.testing import eventually

TIP = np.array([0.01, -0.02, 0.15])
TOOL = matrix_from_rotvec(np.array([0.3, 0.2, 0.5]))
POINT = np.array([0.45, 0.15, 0.25])
TILTS = [(0.0, 0.0), (0.6, 0.0), (-0.6, 0.0), (0.0, 0.6), (0.0, -0.6), (0.4, 0.4)]


@pytest.fixture
def arm(monkeypatch: pytest.MonkeyPatch) -> Iterator[Simulator]:
    """An arm 20 times as fast as the wall, whose own time is slept for."""
    for name, value in {"_EVERY": 0.0, "_SPEED": 3.0, "_ACCELERATION": 5.0}.items():
        monkeypatch.setattr(f"aioduco.cli.payload.{name}", value)
    with ready_arm(speed=20.0) as sim:

        def sleep(_: aioduco.sync.Robot, seconds: float) -> None:
            end = sim.time + seconds
            eventually(lambda: sim.time >= end)

        monkeypatch.setattr(aioduco.sync.Robot, "sleep", sleep)
        yield sim


@contextmanager
def mover(sim: Simulator) -> Iterator[aioduco.sync.Robot]:
    """Another program that moves the arm."""
    with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as robot:
        yield robot


def flange(tilt: tuple[float, float], turn: float, to: tuple[float, ...] = (0, 0, 0)) -> Pose:
    """The flange for a place of the tool, from the tip along its axes, at the point."""
    rotation = (
        matrix_from_rotvec(np.array([np.pi, 0.0, 0.0]))
        @ matrix_from_rotvec(np.array([*tilt, 0.0]))
        @ matrix_from_rotvec(np.array([0.0, 0.0, turn]))
    )
    return Pose.from_rotation(POINT - rotation @ (TIP + TOOL @ to), rotation)


TOUCHES = [flange(tilt, 0.4 * k) for k, tilt in enumerate(TILTS)]
AXES = [flange((0.0, 0.0), 0.0, (0.0, 0.0, 0.06)), flange((0.0, 0.0), 0.0, (0.05, 0.0, 0.06))]


def moved_to(robot: aioduco.sync.Robot, sim: Simulator, pose: Pose) -> str:
    """Move there, and answer by an empty line."""
    robot.motion.movej2(sim.arm.ikine(pose, HOME), v=2.0, a=5.0)
    return ""


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], None]:
    """Answer each question for a line by the next of these calls."""

    def given(answers: list[Callable[[], str]]) -> None:
        left = iter(answers)
        monkeypatch.setattr("builtins.input", lambda: next(left)())  # noqa: PLW0108 - the next each time

    return given


def invoke(*words: str, confirm: str = "") -> Any:
    return CliRunner().invoke(app, words, input=confirm)


@pytest.mark.slow
def test_a_tool_is_touched_and_written(arm: Simulator, typed: Any) -> None:
    with mover(arm) as robot:

        def go(pose: Pose) -> Callable[[], str]:
            return lambda: moved_to(robot, arm, pose)

        slipped = flange((0.2, 0.1), 0.0, (0.0, 0.02, 0.0))
        touches = [go(pose) for pose in (*TOUCHES[:4], slipped)]
        touches += [lambda: "d", *(go(pose) for pose in TOUCHES[4:]), lambda: "q"]
        typed([*touches, *(go(pose) for pose in AXES)])
        words = ("tool", "touch", at(arm), "--no-guide", "--axes", "--name", "pen", "--json")
        ended = invoke(*words, "--load", "0.4", "0", "0", "0.05", confirm="y\n")
        assert ended.exit_code == 0, ended.output
        offset, kept = robot.frames.get_tcp_offset(), robot.frames.get_tool_load()
    assert offset.almost_equal(Pose.from_rotation(TIP, TOOL), position=1e-4, rotation=1e-3)
    assert np.allclose(kept, (0.4, 0.0, 0.0, 0.05))
    told = json.loads(ended.stdout.splitlines()[0])  # the runner echoes the answer
    assert np.allclose(told["tip"], TIP, atol=1e-4)
    assert "in touch 5 it is" in ended.stderr
    assert "Write it?" in ended.stderr


@pytest.mark.slow
def test_nothing_is_written_without_a_yes(arm: Simulator, typed: Any) -> None:
    with mover(arm) as robot:

        def touched() -> None:
            typed([*(lambda p=p: moved_to(robot, arm, p) for p in TOUCHES), lambda: "q"])

        touched()
        ended = invoke("tool", "touch", at(arm), "--no-guide", "--name", "pen", confirm="n\n")
        assert ended.exit_code == 3
        touched()
        ended = invoke("tool", "touch", at(arm), "--no-guide")
        assert ended.exit_code == 0
        assert "nothing was written" in ended.stderr
        assert robot.frames.get_tcp_offset() == Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("words", [("tool", "touch"), ("payload",)])
def test_they_end_when_the_arm_was_stopped(
    arm: Simulator, typed: Any, words: tuple[str, ...]
) -> None:
    """They went on, with an arm that no hand could move; payload let it give way anew."""

    def stopped() -> str:
        with aioduco.sync.connect(arm.host, arm.port, heartbeat=None) as other:
            other.stop()
        return ""

    typed([*[lambda: ""] * 2, stopped])
    ended = invoke(*words, at(arm), "--yes")
    assert (ended.exit_code, "no hand guides it any more" in ended.stderr) == (1, True)


def test_touches_from_one_side_are_refused(arm: Simulator, typed: Any) -> None:
    typed([*[lambda: ""] * 6, lambda: "q"])
    ended = invoke("tool", "touch", at(arm), "--yes")
    assert ended.exit_code == 1
    assert "hardly turn the tool" in ended.stderr
    assert "gave no tip" in ended.stderr
    assert not arm.moving


TURNS = [
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (0.0, -0.4, 0.3, 0.6, 0.5, 0.0),
    (0.0, 0.3, -0.4, -0.6, -0.5, 0.8),
    (0.0, -0.4, 0.6, 0.2, -0.7, 1.6),
    (0.0, 0.4, -0.2, -0.7, 0.6, -0.8),
    (0.0, 0.3, 0.3, 0.6, -0.5, -1.6),
    (0.0, -0.4, -0.4, -0.3, 0.8, 0.8),
    (0.0, 0.0, 0.5, -0.8, 0.0, 2.4),
]


@pytest.mark.slow
@pytest.mark.parametrize("sensor", ["torque", "force"])
def test_a_hidden_load_is_found_and_written(arm: Simulator, tmp_path: Path, sensor: str) -> None:
    file = WaypointFile.new()
    for number, turn in enumerate(TURNS):
        file.add(f"p{number}", np.add(HOME, turn))
    file.save(tmp_path / "around.toml")
    tool, hidden = Load(0.8, 0.0, 0.0, 0.06), Load(1.5, 0.02, -0.01, 0.15)
    arm.load(*_mounted(tool.with_load(hidden)))
    with mover(arm) as robot:
        robot.frames.set_tool_data("grip", (0.0, 0.0, 0.12, np.pi, 0.0, 0.0), tool)
        words = ("payload", at(arm), "--poses", str(tmp_path / "around.toml"), "--sensor", sensor)
        ended = invoke(*words, "--held", confirm="y\ny\n")
        assert ended.exit_code == 0, ended.output
        mass = re.search(r"([\d.]+) kg at", ended.stdout)
        assert mass is not None, ended.stdout
        assert float(mass[1]) == pytest.approx(2.3, abs=0.01)
        # the drives know the load now: they see no more of it
        assert np.abs(robot.state.get_ext_torque()).max() < 0.1
        ended = invoke(*words, "--tool", "both", "--yes", *_set(sensor, hidden))
        assert ended.exit_code == 0, ended.output
        assert np.allclose(robot.frames.get_tool_load(), tool.with_load(hidden), atol=0.01)


def _mounted(load: Load) -> tuple[float, tuple[float, ...]]:
    return load.mass, load[1:]


def _set(sensor: str, held: Load) -> tuple[str, ...]:
    """What a person says of the load that the controller knows already."""
    if sensor == "force":
        return ()
    there = held.in_tool((0.0, 0.0, 0.12, np.pi, 0.0, 0.0))
    return ("--set-load", *map(str, there))


@pytest.mark.slow
def test_an_arm_of_a_cell_is_mounted_as_the_cell_says(arm: Simulator, tmp_path: Path) -> None:
    """It was measured as of an arm on the floor; here an arm on the floor is said to hang."""
    file = tmp_path / "cell.toml"
    poses = [np.degrees(np.add(HOME, turn)).tolist() for turn in TURNS]
    file.write_text(
        f'[robots.left]\nhost = "{arm.host}"\nport = {arm.port}\nmodel = "gcr5_910"\n'
        'mounting = "ceiling"\n' + "".join(f"[[waypoint]]\njoints_deg = {pose}\n" for pose in poses)
    )
    arm.load(1.5, (0.0, 0.0, 0.1))
    words = ("payload", "left", "--cell", str(file), "--poses", str(file), "--yes")
    upside_down = invoke(*words)
    assert (upside_down.exit_code, "-1.500 kg" in upside_down.stderr) == (1, True)
    said = invoke(*words, "--mounting", "floor")
    assert (said.exit_code, "1.500 kg" in said.stdout) == (0, True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("taught_with", "model", "said"),
    [
        ("gcr10_1300", (), "those of a gcr10_1300"),
        ("", ("--model", "gcr20_1400"), "place of its fla"),
    ],
)
def test_a_load_is_not_measured_with_another_arm(
    arm: Simulator, tmp_path: Path, taught_with: str, model: tuple[str, ...], said: str
) -> None:
    file = WaypointFile.new(arm=taught_with)
    for number, turn in enumerate(TURNS):
        file.add(f"p{number}", np.add(HOME, turn))
    file.save(tmp_path / "around.toml")
    here = arm.joints
    ended = invoke("payload", at(arm), "--poses", str(tmp_path / "around.toml"), *model, "--yes")
    assert (ended.exit_code, said in ended.stderr) == (1, True)
    assert arm.joints == here


def test_a_load_is_not_made_up(arm: Simulator, typed: Any) -> None:
    typed([*[lambda: ""] * 12, lambda: "q"])
    ended = invoke("payload", at(arm), "--yes")
    assert ended.exit_code == 1
    assert "the poses differ too little" in ended.stderr
    assert not arm.moving
    ended = invoke("payload", at(arm), "--tool", "a", "--held")
    assert ended.exit_code == 2


@pytest.mark.slow
def test_too_few_poses_by_hand_find_nothing(arm: Simulator, typed: Any) -> None:
    typed([*[lambda: ""] * 2, lambda: "w", *[lambda: ""] * 2, lambda: "q"])
    ended = invoke("payload", at(arm), "--yes")
    assert ended.exit_code == 1
    assert "Enter or q?" in ended.stderr, "a slip of a finger does not end it"
    assert "2 poses were read, but 6 or more are needed" in ended.stderr


@pytest.mark.slow
def test_a_pose_at_which_the_arm_moves_is_left_out(
    arm: Simulator, typed: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    reads, real = iter([True, False]), payload._mean

    def moved(robot: Any, sensor: Any) -> Any:
        if next(reads):
            robot.motion.movej2(np.add(HOME, 0.1), v=2.0, a=5.0)
        return real(robot, sensor)

    monkeypatch.setattr(payload, "_mean", moved)
    typed([*[lambda: ""] * 4, lambda: "q"])
    ended = invoke("payload", at(arm), "--yes")
    assert ended.exit_code == 1
    assert "pose 1 is left out: the arm moved while it was read" in ended.stderr
    assert "pose 2 is read" in ended.stderr
    assert "1 poses were read, but" in ended.stderr


def test_a_controller_without_external_torques_is_told_from_a_load(typed: Any) -> None:
    typed([*[lambda: ""] * 2, lambda: "q"])
    with ready_arm(generation="oldest") as sim:
        ended = invoke("payload", at(sim), "--model", "gcr5_910", "--yes")
    assert (ended.exit_code, "it is older; try --sensor force" in ended.stderr) == (1, True)


def test_the_poses_of_a_payload_may_stand_in_a_cell(tmp_path: Path) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(
        'arm = "gcr5_910"\n[robots.left]\nhost = "127.0.0.1"\n'
        + 6 * "[[waypoint]]\njoints_deg = [0, 0, 90, 0, 90, 0]\n"
    )
    answer = CliRunner().invoke(app, ["payload", "127.0.0.1:1", "--poses", str(file), "--yes"])
    assert (answer.exit_code, "cannot connect to 127.0.0.1:1" in answer.stderr) == (1, True)


@pytest.mark.slow
def test_poses_behind_a_table_are_not_gone_to(arm: Simulator, tmp_path: Path) -> None:
    below = np.degrees(np.add(HOME, (0.0, 1.2, 0.2, 0.0, 0.0, 0.0))).tolist()
    file = tmp_path / "cell.toml"
    file.write_text(
        f'[robots.left]\nhost = "{arm.host}"\nport = {arm.port}\nmodel = "gcr5_910"\n'
        '[[scene.thing]]\nkind = "box"\nname = "bench"\nat = [0.7, 0.1, 0.1]\n'
        "size = [0.6, 1.2, 0.2]\n" + 6 * f'[[waypoint]]\nname = "low"\njoints_deg = {below}\n'
    )
    before = arm.joints
    words = ("payload", "left", "--cell", str(file), "--poses", str(file))
    ended = invoke(*words, confirm="y\n")
    told = " ".join(ended.stderr.split())
    assert ended.exit_code == 1, ended.output
    assert "checked against the scene of the cell" in told
    assert re.search(r"on the way from where the arm stands to low, .*bench.*: nothing moved", told)
    assert "without --poses" in told
    assert np.allclose(arm.joints, before)


def test_poses_without_a_cell_are_said_to_be_unknown(arm: Simulator, tmp_path: Path) -> None:
    file = WaypointFile.new()
    for number in range(6):
        file.add(f"p{number}", HOME)
    file.save(tmp_path / "around.toml")
    ended = invoke("payload", at(arm), "--poses", str(tmp_path / "around.toml"), confirm="n\n")
    assert ended.exit_code == 3
    assert "not known without --cell" in " ".join(ended.stderr.split())


def test_too_few_poses_and_a_load_that_is_none_are_said_before_the_arm_moves(
    tmp_path: Path,
) -> None:
    file = WaypointFile.new()
    for number in range(5):
        file.add(f"p{number}", HOME)
    file.save(tmp_path / "around.toml")
    few = invoke("payload", "127.0.0.1:1", "--poses", str(tmp_path / "around.toml"), "--yes")
    assert (few.exit_code, "has 5 poses, but 6 or more" in few.stderr) == (2, True)
    for mass in ("-1", "nan"):
        wrong = invoke("payload", "127.0.0.1:1", "--set-load", mass, "0", "0", "0", "--yes")
        assert wrong.exit_code == 2
        assert "--set-load" in wrong.stderr


@for_each(
    "words",
    [
        ("tool", "touch", "--name", "x", "--load", "-1", "0", "0", "0"),
        ("tool", "touch", "--name", "x" * 33),
        ("payload", "--tool", "x" * 33),
    ],
)
def test_what_could_not_be_written_is_refused_before_a_person_works(words: tuple[str, ...]) -> None:
    wrong = invoke(*words, "127.0.0.1:1", "--yes")
    assert wrong.exit_code == 2
    assert "nothing was sent" in wrong.stderr
