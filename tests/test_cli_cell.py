"""`--cell`: commands that take their robot, limits and surroundings from the file of a cell."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from test_cli import process, run
from test_cli_robot import ready_arm
from typer.testing import Result

from aioduco import Cell
from aioduco.cli.cell_file import is_cell, simulated_parts
from aioduco.sim import Simulator

TEXT = """\
arm = "gcr5_910"

[robots.left]
host = "{host}"
port = {port}

[points.ready] # the start
joints_deg = [20, -10, 100, 0, -90, 0]
[points.pick]
pose_mm_deg = [550, 100, 250, 180, 0, 0]

[[scene.thing]]
kind = "box"
name = "bench"

[[limit]]
kind = "plane"
point = [0, 0, 0.1]
normal = [0, 0, 1]
name = "table"

[[waypoint]]
joints_deg = [20, -10, 100, 0, -90, 0]
"""


@pytest.fixture(autouse=True)
def no_robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("AIODUCO_HOST", "192.0.2.77")  # a cell comes before it
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    (tmp_path / "aioduco").mkdir()
    return tmp_path / "aioduco" / "robots.toml"


def written(folder: Path, sim: Simulator | None = None) -> Path:
    host, port = ("192.0.2.1", 7003) if sim is None else (sim.host, sim.port)
    path = folder / "cell.toml"
    path.write_text(TEXT.format(host=host, port=port), encoding="utf-8")
    return path


def told(answer: Result) -> str:
    return " ".join(answer.output.replace("│", " ").split())


def test_a_command_finds_its_robot_in_the_cell(tmp_path: Path) -> None:
    with ready_arm() as sim:
        file = written(tmp_path, sim)
        for words in (("status",), ("status", "left")):
            answer = run(*words, "--cell", str(file))
            assert (answer.exit_code, f"left ({sim.host}" in answer.output) == (0, True)
        wrong = run("status", "lefft", "--cell", str(file))
        assert (wrong.exit_code, "did you mean 'left'" in told(wrong)) == (2, True)
        # a mistake elsewhere does not hold back a stop
        file.write_text(file.read_text().replace("normal", "nrmal"))
        assert run("stop", "--cell", str(file)).exit_code == 0
        broken = run("move", "joints", *"000000", "--cell", str(file), "--yes")
        assert (broken.exit_code, "did you mean 'normal'" in told(broken)) == (2, True)


@pytest.mark.slow
def test_a_command_that_moves_keeps_the_limits_of_the_cell(tmp_path: Path) -> None:
    with ready_arm() as sim:
        file = written(tmp_path, sim)
        down = ("0", "60", "90", "0", "-90", "0", "--deg", "--yes", "--cell", str(file))
        refused = run("move", "joints", *down)
        assert (refused.exit_code, "table" in told(refused)) == (1, True)
        called = run("call", "movej2", "[0, 1, 1.57, 0, -1.57, 0]", "v=1", "a=1", "--yes",
                     "--cell", str(file))  # fmt: skip
        assert (called.exit_code, "table" in told(called)) == (1, True)
        assert not sim.tasks
        checked = run("check", "left", "--move", "--yes", "--cell", str(file))
        assert (checked.exit_code, "--cell" in told(checked)) == (2, True)
        assert not sim.tasks
        text = file.read_text().replace("[0, 0, 0.1]", "[0, 0, 0.75]")
        file.write_text(text.replace("[0, 0, 1]", "[0, 0, -1]"))
        recorded = run("check", "left", "--motions", str(tmp_path / "run.mcap"), "--reach", "1.5",
                       "--yes", "--cell", str(file))  # fmt: skip
        assert (recorded.exit_code, "table" in told(recorded)) == (1, True)
        assert not sim.tasks


@pytest.mark.slow
def test_points_of_a_cell_are_taught_in_their_file(tmp_path: Path) -> None:
    with ready_arm() as sim:
        file = written(tmp_path, sim)
        before = file.read_text()
        words = ("teach", "--cell", str(file), "--no-guide")
        done = run(*words, typed="ready\npick\n\n\x1b[A\nabove the part\nq\n")
        assert done.exit_code == 0, done.output
        assert "not stored: name is '\\x1b[A'" in done.stderr
        here, tip = sim.joints, sim.arm.fkine(sim.joints.array)
    cell = Cell.load(file)
    assert list(cell) == ["ready", "pick", "above the part"]
    assert cell.joints("ready").almost_equal(here, 1e-5)
    assert cell.joints("above the part").almost_equal(here, 1e-5)
    assert cell.pose("pick").matrix == pytest.approx(tip, abs=1e-5)
    assert "[points.ready] # the start\n" in file.read_text()
    assert file.read_text().splitlines()[:7] == before.splitlines()[:7]


def test_waypoints_are_not_taught_into_the_file_of_a_cell(tmp_path: Path) -> None:
    file = written(tmp_path)
    before = file.read_text()
    refused = run("teach", "127.0.0.1", "--port", "1", "-o", str(file))
    assert (refused.exit_code, "--cell" in told(refused)) == (2, True), refused.output
    assert file.read_text() == before


@pytest.mark.slow
@pytest.mark.parametrize("option", ["--cell", "-o"])
def test_what_a_person_edits_while_points_are_taught_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, option: str
) -> None:
    with ready_arm() as sim:
        file = written(tmp_path, sim) if option == "--cell" else tmp_path / "points.toml"
        at = () if option == "--cell" else (sim.host, "--port", str(sim.port))

        def person() -> Iterator[str]:
            yield "one"
            before = file.read_text()
            file.write_text(f"{before}[[\n")
            yield "another"
            file.write_text(f"{before}# edited\n")
            yield "last"

        hands = person()
        monkeypatch.setattr("builtins.input", lambda _: next(hands, "q"))
        done = run("teach", *at, option, str(file), "--no-guide")
    assert (done.exit_code, done.stderr.count("not stored: ")) == (0, 1), done.output
    found = [word for word in ("one", "another", "# edited", "last") if word in file.read_text()]
    assert found == ["one", "# edited", "last"]


@pytest.mark.slow
def test_a_pose_that_another_tool_than_the_cells_is_taught_by_is_said(tmp_path: Path) -> None:
    with ready_arm() as sim:
        file = written(tmp_path, sim)
        words = ("teach", "--cell", str(file), "--no-guide")
        assert "tip" not in run(*words, typed="pick\nq\n").stderr
        file.write_text(f"{file.read_text()}\n[tool]\ntcp_mm_deg = [0, 0, 140, 0, 0, 0]\n")
        assert "tip" not in run(*words, typed="ready\nq\n").stderr
        said = run(*words, typed="pick\nq\n").stderr
    assert "the controller's tool has its tip at x 0.0  y 0.0  z 0.0 mm" in said
    assert "the cell's at x 0.0  y 0.0  z 140.0 mm" in said


def test_points_and_waypoints_of_a_cell_are_checked(tmp_path: Path) -> None:
    file = written(tmp_path)
    found = run("check", str(file))
    assert "ready" in found.output
    assert run("play", str(file), "--check").exit_code == 0
    file.write_text(file.read_text().replace("0.1]", "0.8]"))
    beyond = run("play", str(file), "--check")
    assert (beyond.exit_code, "table" in told(beyond)) == (1, True)


@pytest.mark.parametrize("text", ["x = 1\n", "[["])
def test_a_wrong_file_ends_each_command_by_one_code(tmp_path: Path, text: str) -> None:
    """2 for what a person writes, as for an option; 1 for what was recorded or measured."""
    wrong, data = tmp_path / "wrong.toml", tmp_path / "run.mcap"
    wrong.write_text(text)
    data.write_text(text)
    arm = "127.0.0.1 --port 1"
    ends = {
        command: run(*command.format(file=wrong, data=data).split()).exit_code
        for command in (
            "play {file} --check",
            f"payload {arm} --poses {{file}} --yes",
            "status --cell {file}",
            "fleet status {file}",
            f"twin {arm} --limits {{file}}",
            "sim --profile {file}",
            "play {data} --check",
            "twin --judge {data}",
            f"calibrate {{data}} --output {tmp_path / 'arm.toml'}",
        )
    }
    assert ends == {command: 1 if "{data}" in command else 2 for command in ends}


def test_options_come_before_what_the_cell_says(tmp_path: Path) -> None:
    file = written(tmp_path)
    usual = {"model": "gcr5_910", "mounting": "floor", "pedestal": 0.0, "tool": None}
    found = simulated_parts(file, None, **usual)
    assert [each.name for each in found["scene"]] == ["bench"]
    assert simulated_parts(file, None, **{**usual, "model": "gcr3_618"})["model"] == "gcr3_618"
    # with a profile, no option says the model
    assert simulated_parts(file, None, **{**usual, "model": None})["model"] == "gcr5_910"
    assert simulated_parts(None, None, **usual) == usual


def test_a_simulated_robot_of_a_cell_is_where_its_programs_look_for_it(tmp_path: Path) -> None:
    file = tmp_path / "cell.toml"
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        file.write_text(TEXT.format(host="127.0.0.1", port=port), encoding="utf-8")
        assert f"cannot listen on 127.0.0.1:{port}" in told(run("sim", "--cell", str(file)))


@pytest.mark.slow
def test_a_simulator_says_that_programs_of_its_cell_go_to_the_arm(tmp_path: Path) -> None:
    file = written(tmp_path)  # with the address of an arm
    with process("sim", "--cell", str(file), "--port", "0") as sim:
        assert sim.stderr is not None
        assert "move the arm at 192.0.2.1:7003, and not this one" in sim.stderr.readline()
    file.write_text(file.read_text("utf-8").replace("192.0.2.1", "127.0.0.1"), encoding="utf-8")
    with process("sim", "--cell", str(file), "--port", "0") as sim:
        assert sim.stdout is not None
        sim.stdout.readline()
        sim.terminate()
        assert sim.communicate(timeout=20)[1] == ""


@pytest.mark.slow
def test_a_preflight_is_flown_in_the_cell(tmp_path: Path) -> None:
    file = written(tmp_path)
    # the flange gets 30 mm into it
    text = file.read_text().replace('name = "bench"', 'name = "bench"\nat = [0.55, 0.1, 0.23]')
    file.write_text(text)
    program = tmp_path / "main.py"
    program.write_text(
        "import aioduco.sync\n"
        "from aioduco import Cell\n"
        f"cell = Cell.load({str(file)!r})\n"
        "with aioduco.sync.connect_cell(cell) as robot:\n"
        "    robot.bring_up()\n"
        "    robot.motion.movej_pose2(cell.pose('pick'), v=1.0, a=2.0,"
        " q_near=cell.joints('ready'))\n"
    )
    flown = run("preflight", str(program), "--cell", str(file), "--quiet")
    assert (flown.exit_code, "bench" in told(flown)) == (1, True), flown.output


def test_a_misspelt_robot_is_not_taken_for_a_host(no_robots: Path) -> None:
    no_robots.write_text('[left]\nhost = "192.0.2.1"\n')
    answer = run("status", "lefft")
    assert (answer.exit_code, "did you mean 'left'" in told(answer)) == (2, True)
    assert "lefft:7003" in told(answer)


@pytest.mark.slow
def test_a_misspelt_function_or_arm_is_answered_with_the_nearest() -> None:
    assert "did you mean 'get_tcp_pose'" in told(run("call", "get_tcp_pos", "--describe"))
    assert "--host gives the arm's address" in told(run("call", "192.168.1.10", "get_tcp_pose"))
    assert "did you mean 'gcr5_910'" in told(run("sim", "--model", "gcr5_901"))


def test_what_is_a_cell_and_what_is_not(tmp_path: Path) -> None:
    assert is_cell(written(tmp_path))
    other = tmp_path / "other.toml"
    for text in ("[home]\njoints = [0, 0, 0, 0, 0, 0]\n", "[[waypoint]]\n", "no toml", ""):
        other.write_text(text)
        assert not is_cell(other), text
    other.write_text("[points]\njoints = [0, 0, 0, 0, 0, 0]\n")  # a point that is called points
    assert not is_cell(other)
