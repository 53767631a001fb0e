"""The command `aioduco`: in this process where it only answers, as a process where it runs."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest
import typer
from cli_runner import CliRunner
from client.bench import Bench
from for_each import for_each
from patient import COMMAND_LINE
from PIL import Image
from terminals import ENDS
from typer.testing import Result

import aioduco
import aioduco.sync
from aioduco._wire import idl
from aioduco.cli.app import app
from aioduco.cli.call import function_of
from aioduco.cli.demo_run import LEFT
from aioduco.cli.exit_codes import ended_by_errors, write_file
from aioduco.cli.sim_do import control_port_of
from aioduco.compat import DucoCobot
from aioduco.kinematics import models
from aioduco.models.force_sample import FORCE_REQUEST
from aioduco.models.names import SPELLINGS, place
from aioduco.recording.playback import WaypointFile
from aioduco.sim import Simulator

COMMAND = (sys.executable, "-W", "error", "-m", "aioduco.cli")
PNG = b"\x89PNG\r\n\x1a\n"


def run(*arguments: str, typed: str = "") -> Result:
    return CliRunner().invoke(app, list(arguments), input=typed)


@contextmanager
def process(*arguments: str, **options: Any) -> Iterator[subprocess.Popen[str]]:
    """The command in a process that does not outlive the test."""
    with subprocess.Popen(
        [*COMMAND_LINE, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    ) as started:
        try:
            yield started
        finally:
            started.kill()


def wait_until_it_moves(sim: Simulator) -> None:
    """Wait until the arm is well on its way, so that its program knows of the motion too."""
    begin = sim.joints.array
    sim.wait_until(lambda: abs(sim.joints.array - begin).max() > 0.05, timeout=60)


def address(sim: Simulator) -> tuple[str, ...]:
    return ("--host", sim.host, "--port", str(sim.port))


def test_version() -> None:
    assert run("--version").stdout == f"{aioduco.__version__}\n"


@pytest.mark.parametrize("command", ["sim", "demo"])
def test_an_unknown_arm_is_refused_and_the_known_ones_are_listed(command: str) -> None:
    answer = run(command, "--model", "ur5")
    assert answer.exit_code == 2
    said = answer.output.replace("\n", " ")
    assert all(model in said for model in models())


@pytest.mark.parametrize(
    ("command", "absent", "said"),
    [
        (("sim",), {"mujoco"}, "mujoco: pip install 'aioduco[cli,sim]'"),
        (("sim", "--render", "out.gif"), {"PIL"}, "PIL: pip install 'aioduco[cli,plot]'"),
        (("demo",), {"matplotlib"}, "matplotlib: pip install 'aioduco[cli,plot]'"),
        (
            ("demo",),
            {"mujoco", "matplotlib"},
            "mujoco and matplotlib: pip install 'aioduco[cli,sim,plot]'",
        ),
        (("plot", __file__), {"matplotlib"}, "pip install 'aioduco[cli,plot]'"),
    ],
)
def test_missing_extra_is_named(
    monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...], absent: set[str], said: str
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name in absent else 1)
    answer = run(*command)
    assert answer.exit_code == 1
    assert said in answer.output


# -- sim -----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("number", ENDS)
def test_sim_says_where_it_listens_and_ends_when_told(number: signal.Signals) -> None:
    with process("sim", "--port", "0") as sim:
        assert sim.stdout is not None
        words = sim.stdout.readline().split()
        host, port = words[3].rstrip(",").split(":")
        assert words[:3] == ["simulated", "gcr5_910", "on"]
        with socket.create_connection((host, int(port)), timeout=5):
            sim.send_signal(number)
            _, errors = sim.communicate(timeout=20)
    assert (sim.returncode, errors) == (0, "")


@pytest.mark.slow
def test_sim_serves_what_it_is_told_and_does_what_a_shell_tells_it() -> None:
    ports = ("--port", "0", "--status-port", "0", "--force-port", "0")
    with process("sim", *ports, "--generation", "4.3") as sim:
        assert sim.stdout is not None
        said = sim.stdout.readline()
        host, port, status, forces, commands = re.findall(
            r" on (\S+):(\d+),.* status frames on (\d+),.* from UDP (\d+),.* commands on (\d+);",
            said,
        )[0]
        with DucoCobot(host, int(port)) as robot:
            assert robot.get_robot_version().startswith("4.3")
        with socket.create_connection((host, int(status)), timeout=5) as frames:
            assert frames.recv(1)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
            asking.settimeout(20.0)
            asking.sendto(FORCE_REQUEST, (host, int(forces)))
            assert len(asking.recv(256)) == 48
        done = run("sim-do", "--control-port", commands, "push", "0", "0", "-20")
        assert (done.exit_code, done.output) == (0, "ok\n")
        assert "emergency stop" in run("sim-do", "--control-port", commands).output
        for wrong in (("input", "99", "on"), ("where", "\udcff")):
            refused = run("sim-do", "--control-port", commands, *wrong)
            assert (refused.exit_code, refused.output.split(":")[0]) == (1, "error")
        sim.send_signal(signal.SIGTERM)
        assert sim.communicate(timeout=60)[1] == ""
    assert sim.returncode == 0
    nobody = run("sim-do", "--control-port", commands, "estop")
    assert nobody.exit_code == 1
    assert f"no simulator takes commands on 127.0.0.1:{commands}" in nobody.output
    assert (control_port_of(7003), control_port_of(0), control_port_of(60_000)) == (17003, 0, 0)


def test_sim_says_so_when_a_file_is_no_program(tmp_path: Path) -> None:
    (tmp_path / "wrong.json").write_text('[["jump"]]', encoding="utf-8")
    answer = run("sim", "--port", "0", "--programs", str(tmp_path))
    assert answer.exit_code == 1
    assert "there is no function 'jump'" in answer.output


def test_sim_says_so_when_the_port_is_taken() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        answer = run("sim", "--port", str(port))
    assert answer.exit_code == 1
    assert f"cannot listen on 127.0.0.1:{port}" in answer.output


@pytest.mark.slow
def test_panel_says_whether_its_page_or_the_controller_is_missing() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    answer = run("panel", f"127.0.0.1:{port}", "--listen", "0")
    assert answer.exit_code == 1
    assert f"cannot connect to 127.0.0.1:{port}" in answer.output
    assert "cannot listen" not in answer.output


@pytest.mark.slow
def test_sim_draws_what_the_arm_did(tmp_path: Path) -> None:
    film, cell = tmp_path / "out.gif", tmp_path / "cell.xml"
    cell.write_text('<mujoco><worldbody><geom size="0.1" pos="0 1 1"/></worldbody></mujoco>')
    options = ("--port", "0", "--speed", "10", "--scene", str(cell), "--mounting", "0,0,0.5,0,0,0")
    with process("sim", *options, "--render", str(film)) as sim:
        assert sim.stdout is not None
        port = int(sim.stdout.readline().split()[3].rstrip(",").rpartition(":")[2])
        with aioduco.sync.connect("127.0.0.1", port) as robot:
            robot.bring_up()
            robot.motion.movej2((1.0, *LEFT[1:]), v=2.0, a=5.0)
        sim.send_signal(signal.SIGINT)
        said, errors = sim.communicate(timeout=60)
    assert (sim.returncode, errors) == (0, "")
    assert f"written to {film}" in said
    with Image.open(film) as animation:
        assert animation.size == (480, 360)
        assert getattr(animation, "n_frames", 1) > 5


@pytest.mark.slow
def test_sim_draws_how_the_arm_stands(tmp_path: Path) -> None:
    last = tmp_path / "last.png"
    with process("sim", "--port", "0", "--render", str(last)) as sim:
        assert sim.stdout is not None
        sim.stdout.readline()
        sim.send_signal(signal.SIGTERM)
        _, errors = sim.communicate(timeout=60)
    assert (sim.returncode, errors) == (0, "")
    assert last.read_bytes().startswith(PNG)


def test_sim_without_a_display_shows_no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    answer = run("sim", "--port", "0", "--view")
    assert answer.exit_code == 1
    assert "there is no display" in answer.output


# -- call


def test_a_function_is_called_by_its_name_and_read_as_json() -> None:
    with Simulator(speed=10) as sim:
        shown = run("call", "get_actual_joints_position", "--json", "--port", str(sim.port))
        joints = json.loads(shown.stdout)
        assert list(joints.values()) == pytest.approx(list(sim.joints.array), abs=1e-9)
        status = run("call", "getRobotStatus", "--json", "--port", str(sim.port))
        assert json.loads(status.stdout)["joints"] == pytest.approx(joints, abs=1e-9)


@pytest.mark.slow
def test_a_call_that_moves_the_arm_asks_first() -> None:
    motion = ("call", "movej2", "[0.3, 0, 1.5, 0, -1.5, 0]", "v=2", "a=5")
    with Simulator(speed=10) as sim:
        port = ("--port", str(sim.port))
        for name in ("power_on", "enable"):
            assert run("call", name, "--yes", *port).exit_code == 0
        begin = sim.joints
        declined = run(*motion, *port, typed="n\n")
        assert declined.exit_code == 3
        assert "robot.motion.movej2([0.3, 0, 1.5, 0, -1.5, 0], v=2, a=5)" in declined.stderr
        assert sim.joints.almost_equal(begin, 1e-6)
        done = run(*motion, *port, "--yes")
        assert (done.exit_code, done.stdout) == (0, "Outcome.FINISHED\n")
        assert sim.joints.j1 == pytest.approx(0.3, abs=1e-3)


@for_each(
    "words, beats",
    [
        ("get_tcp_pose", False),
        ("set_standard_digital_out 1 true --yes", False),
        ("pause --yes", False),
        ("movej2 [0,0,1.5,0,-1.5,0] v=1 a=1 --yes", True),
    ],
)
def test_a_call_that_moves_nothing_sends_no_heartbeat(words: str, beats: bool) -> None:
    """Its end stopped the arm of another program, or of the pendant, that sends none."""
    with Bench() as bench:
        done = run("call", *words.split(), "--host", f"{bench.host}:{bench.port}")
        assert done.exit_code == 0, done.output
        assert bool(bench.received("rpc_heartbeat")) == beats


@for_each(
    "words, waits", [("movej2 [0,0,1.5,0,-1.5,0] v=1 a=1 --yes", True), ("get_tcp_pose", False)]
)
def test_a_motion_that_waits_for_a_pause_to_end_says_so(words: str, waits: bool) -> None:
    with Bench() as bench:
        bench.states[1] = int(aioduco.ProgramState.PAUSED)
        done = run("call", *words.split(), "--host", f"{bench.host}:{bench.port}")
        assert done.exit_code == 0, done.output
        assert (f"`aioduco resume {bench.host}:{bench.port}` goes on" in done.stderr) == waits


@for_each(
    "words, function, answer, shown",
    [
        ("set_tool_digital_out 1 True", "set_tool_digital_out", 4, "null"),  # as --describe has it
        ("tool_read_raw_data_485 2", "tool_read_raw_data_485", [1, -1], "[1, 255]"),
    ],
)
def test_values_are_taken_and_shown_as_they_are_meant(
    words: str, function: str, answer: Any, shown: str
) -> None:
    with Bench() as bench:
        bench.answer(function, answer)
        at = f"{bench.host}:{bench.port}"
        done = run("call", *words.split(), "--yes", "--json", "--host", at)
        assert done.exit_code == 0, done.output
        assert done.stdout.strip() == shown


def test_every_function_of_the_robot_can_be_called_by_its_name() -> None:
    """The command, the page of functions and the objects agree."""
    page = (Path(__file__).parents[1] / "docs" / "functions.md").read_text("utf-8")
    robot = aioduco.sync.connect("192.0.2.1")
    names = [*SPELLINGS, *(name for name in idl.functions() if place(name))]
    assert len(names) > 226
    for name in names:
        where = place(name)
        assert where is not None
        assert callable(function_of(robot, where)), name
        assert f"`{where}`" in page
    described = run("call", "move1", "--describe").stdout
    assert described.startswith("robot.motion.movel(pose: PoseLike, v: Real")
    assert "移动" in described or "运动" in described


@pytest.mark.parametrize(
    "words",
    [
        ["stop", ""],
        ["status", "left", "--cell", ""],
        ["record", "--output="],
        ["panel", "--bind", ""],
        ["init", ""],
        ["plot", "run.mcap", ""],
        ["", "status"],
    ],
    ids=" ".join,
)
def test_an_empty_argument_is_refused_before_anything_is_done(
    words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A variable of a script that is not set must not stand for a default."""
    monkeypatch.setattr("sys.argv", ["aioduco", *words])
    monkeypatch.setattr("aioduco.cli.app.app_for", lambda _: pytest.fail("it went on"))
    with pytest.raises(SystemExit) as ended:
        aioduco.cli.main()
    assert ended.value.code == 2
    assert "is a variable empty?" in capsys.readouterr().err


def test_a_text_that_a_call_passes_on_may_be_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    went_on = []
    monkeypatch.setattr("sys.argv", ["aioduco", "call", "get_tcp_pose_coord", "", ""])
    monkeypatch.setattr("aioduco.cli.app.app_for", lambda _: lambda: went_on.append(1))
    aioduco.cli.main()
    assert went_on


def test_a_file_that_cannot_be_written_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "nowhere" / "report.md"
    with pytest.raises(typer.Exit) as ended:
        write_file(path, "text")
    assert ended.value.exit_code == 2
    assert capsys.readouterr().err == f"{path} cannot be written: No such file or directory\n"


def test_a_file_error_ends_a_command_without_a_traceback(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit) as ended, ended_by_errors():
        Path("/no/such/folder/limits.json").write_text("")
    assert ended.value.code == 1
    assert capsys.readouterr().err.endswith("'/no/such/folder/limits.json'\n")


def test_sigterm_cancels_the_program_of_an_event_loop_and_no_other_task(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """So that its robot is left, which needs its own tasks for that."""
    left = []

    async def program() -> None:
        needed = asyncio.create_task(asyncio.sleep(0.02, "needed"))
        asyncio.get_running_loop().call_soon(os.kill, os.getpid(), signal.SIGTERM)
        try:
            await asyncio.sleep(60.0)
        finally:
            left.append(await needed)

    with pytest.raises(SystemExit) as ended, ended_by_errors("interrupted: it stands"):
        anyio.run(program)
    assert (ended.value.code, left) == (128 + signal.SIGTERM, ["needed"])
    assert capsys.readouterr().err == "interrupted: it stands\n"


def test_a_tap_says_that_it_cannot_listen() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        there = f"127.0.0.1:{taken.getsockname()[1]}"
        answer = run("tap", "127.0.0.1:1", "--listen", there)
    assert answer.exit_code == 1
    assert answer.stderr.startswith(f"the tap cannot listen on {there}: ")


@pytest.mark.slow
def test_a_tap_whose_reader_has_ended_ends_without_a_message() -> None:
    with Simulator() as sim:
        words = ("tap", f"{sim.host}:{sim.port}", "--listen", "127.0.0.1:0", "--json")
        with process(*words) as tap:
            assert tap.stdout is not None
            assert tap.stderr is not None
            there = tap.stderr.readline().split()[1]
            tap.stdout.close()
            run("status", there)
            assert (tap.wait(60), tap.stderr.read()) == (1, "")


@for_each("answer, code, says", [(b"", 1, "ended without an answer"), (b"\xff\n", 0, "\\xff")])
def test_what_listens_instead_of_a_simulator_is_shown(answer: bytes, code: int, says: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            connection, _ = server.accept()
            with connection:
                while connection.recv(4096):
                    pass
                connection.sendall(answer)

        serving = threading.Thread(target=serve)
        serving.start()
        done = run("sim-do", "--control-port", str(server.getsockname()[1]), "state")
        serving.join()
    assert done.exit_code == code
    assert says in done.output


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_preflight_that_is_ended_leaves_no_files(tmp_path: Path, number: int, code: int) -> None:
    (tmp_path / "program.py").write_text("print('runs', flush=True)\nwhile True:\n    pass\n")
    (left := tmp_path / "left").mkdir()
    environment = os.environ | {"TMPDIR": str(left)}
    with process("preflight", str(tmp_path / "program.py"), env=environment) as preflight:
        assert preflight.stdout
        assert preflight.stdout.readline() == "runs\n"
        preflight.send_signal(number)
        _, said = preflight.communicate(timeout=60)
    assert (preflight.returncode, said, list(left.iterdir())) == (code, "interrupted\n", [])


def test_a_preflight_of_a_wrong_cell_runs_nothing(tmp_path: Path) -> None:
    (tmp_path / "wrong.xml").write_text("no MJCF")
    (tmp_path / "program.py").write_text("raise SystemExit(7)")
    for option, value in (
        ("--scene", str(tmp_path / "wrong.xml")),
        ("--tool", str(tmp_path / "wrong.xml")),
        ("--pedestal", "nan"),
        ("--vary", "weather"),
    ):
        answer = run("preflight", str(tmp_path / "program.py"), option, value)
        assert answer.exit_code == 2, option
        assert "SystemExit" not in answer.output
        assert option.strip("-") in answer.stderr
        assert "Traceback" not in answer.stderr


NOBODY = "127.0.0.1:1"


@for_each(
    "words, code, says",
    [
        ("sim --render out.mp4", 2, ".gif or .png"),
        ("sim --render no_folder/out.gif", 2, "there is no folder no_folder"),
        ("sim --mounting roof", 2, "mounting is 'roof', but must be"),
        ("sim --mounting 0,0,0.5", 2, "mounting is '0,0,0.5', but must be"),
        ("sim --mounting wall --pedestal 0.5", 2, "a pedestal is for an arm on the floor"),
        ("sim --pedestal -1", 2, "pedestal is -1.0"),
        ("sim --mounting nan,0,0,0,0,0", 2, "mounting is [nan"),
        ("sim --scene nowhere.xml", 2, "nowhere.xml"),
        ("sim --gripper hand", 2, "robotiq_2f85"),
        ("sim --generation 5", 2, "4.3"),
        ("sim-do --port 60000 state", 2, "no port for commands belongs to 60000"),
        ("preflight program.py --mounting 0,0,0.5", 2, "mounting is '0,0,0.5', but must be"),
        ("plot .", 2, "'.' is a directory"),
        (f"tap {NOBODY} --listen nowhere", 2, "--listen"),
        (f"tap {NOBODY} --only movej2,movej3", 2, "'movej3' is not known"),
        (f"tap {NOBODY} --only movej3,", 2, "is not known"),
        (f"tap {NOBODY} --only ,", 2, "'' is not known"),
        ("call no_such_function", 2, "no_such_function"),
        ("call rpc_heartbeat", 2, "each command sends it by itself"),
        ("call move_jog 1 --port 1", 2, "`aioduco jog` carries it out"),
        ("call resume --yes --port 1", 2, "`aioduco resume` does it"),
        ("call get_tcp_pose --port 1", 1, NOBODY),
        ("call movej2 [0,0,0,0,0,0] v=1 v=2 a=1 --port 1", 2, "v is given twice: 1 and 2"),
        ("call movel 3 --port 1", 2, "missing a required argument: 'v'"),
        ("call movel 3 --port 1", 2, "aioduco call movel --describe"),
        ("call cal_fkine 0 0 1.57 0 -1.57 0 --port 1", 2, "too many positional arguments"),
        ("call movej2 [0] v=1 acc=1 --port 1", 2, "missing a required argument: 'a'"),
    ],
)
def test_a_command_says_why_it_cannot_be_carried_out(words: str, code: int, says: str) -> None:
    answer = run(*words.split())
    told = " ".join(answer.output.replace("│", " ").split())  # it stands in a frame
    assert (answer.exit_code, says in told) == (code, True), answer.output
    assert "Error: " not in told


@pytest.mark.cases(8)
@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("sim --port 0 --robot left", "--robot"),
        ("preflight program.py --robot left", "--robot"),
        ("preflight program.py --workers 2", "--workers"),
        ("preflight program.py --vary start --runs 2 --html page.html", "--html"),
        ("preflight program.py --seed 3", "--seed"),
        (f"teleop {NOBODY} --wobj table --yes", "--wobj"),
        (f"teleop {NOBODY} --joint-speed 0.2 --yes", "--joint-speed"),
        (f"teleop {NOBODY} --joints --frame tool --yes", "--frame"),
        (f"teleop {NOBODY} --path /dev/input/js0 --yes", "--path"),
        ("teleop --port 7003", "--port"),
        ("play points.toml --from 2", "--from"),
        ("play points.toml --outputs", "--outputs"),
        ("play points.toml --speed 2", "--speed"),
        ("play run.mcap --port 7003", "--port"),
        ("play run.mcap --check --record again.mcap", "--record"),
        (f"play run.mcap {NOBODY} --check --scene scene.xml", "--scene"),
        (f"play run.mcap {NOBODY} --no-rehearse --scene scene.xml", "--scene"),
        ("plot stream.json --over run.mcap", "--over"),
        ("demo --port 7003", "--port"),
        ("call movel --describe --json", "--json"),
        (f"demo --host {NOBODY} --speed 2 --yes", "--speed"),
        ("demo --plan --plot plan.png", "--plot"),
        ("demo --pictures .", "--pictures"),
        (f"jog j1 + --frame tool --host {NOBODY}", "--frame"),
        (f"jog z + --mm --host {NOBODY}", "--mm"),
        (f"jog z + --step 0.01 --seconds 2 --host {NOBODY}", "--seconds"),
        (f"move pose 0 0 0 0 0 0 --joints --speed 0.01 --host {NOBODY}", "--speed"),
        (f"payload {NOBODY} --sensor force --set-load 1 0 0 0", "--set-load"),
        (f"tool touch {NOBODY} --load 1 0 0 0", "--load"),
        ("check points.toml --output report.md", "--output"),
        ("check points.toml --move", "--move"),
        (f"check {NOBODY} --model gcr10_1300", "--model"),
        (f"check {NOBODY} --reach 0.2", "--reach"),
        (f"check {NOBODY} --ids", "--ids"),
        (f"check {NOBODY} --motions run.mcap --output report.md", "--output"),
        (f"twin {NOBODY} --listen 9000", "--listen"),
        (f"twin {NOBODY} --panel --rate 100", "--rate"),
        (f"twin {NOBODY} --judge run.mcap", "HOST"),
        ("twin --judge run.mcap --action stop", "--action"),
    ],
)
def test_an_option_that_has_no_effect_with_the_others_is_refused(
    words: str, option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("program.py", "points.toml", "run.mcap", "stream.json", "scene.xml"):
        (tmp_path / name).touch()
    answer = run(*words.split())
    assert answer.exit_code == 2, answer.output
    assert f"Invalid value for {option}: " in answer.stderr


@pytest.mark.cases(4)
@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("plot no.json", "'figures'"),
        ("plot no.mcap", "'figures'"),
        ("plot run.mcap --over no.mcap", "'--over'"),
        ("play no.mcap", "'file'"),
        ("calibrate run.mcap no.mcap", "'recordings'"),
        (f"payload {NOBODY} --poses no.toml --yes", "'--poses'"),
        ("twin --judge no.mcap", "'--judge'"),
        ("twin --judge run.mcap --limits no.json", "--limits"),
        ("sim --scene no.xml", "'--scene'"),
        ("fleet serve no.toml", "'file'"),
    ],
)
def test_a_file_that_is_not_there_is_said_before_anything_is_done(
    words: str, option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.mcap").touch()
    _said_to_be_wrong(words, option, r"(file|there is no file) '?no\.")


@pytest.mark.cases(5)
@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("sim --port 0 --render no/arm.png", "--render"),
        (f"demo --host {NOBODY} --plot no/demo.png --yes", "--plot"),
        ("demo --json no/demo.json", "--json"),
        (f"check {NOBODY} --move --yes --output no/report.md", "--output"),
        (f"check {NOBODY} --motions no/run.mcap --yes", "--motions"),
        ("preflight program.py --html no/page.html", "--html"),
        (f"doctor {NOBODY} --json no/figures.json", "--json"),
        ("calibrate run.mcap --output no/arm.toml", "--output"),
        (f"teach {NOBODY} --output no/points.toml --yes", "--output"),
        ("twin --learn run.mcap --limits no/left.json", "--limits"),
        (f"record {NOBODY} --output no/run.mcap", "--output"),
        ("teleop --record no/run.mcap", "--record"),
        ("play run.mcap --record no/run.mcap", "--record"),
        ("plot run.mcap no/run.png", "PICTURE"),
        (f"tap {NOBODY} --output no/calls.jsonl", "--output"),
    ],
)
def test_a_file_that_cannot_be_written_is_said_before_anything_is_done(
    words: str, option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its folder is not there; it is a folder itself; or its folder may not be written."""
    monkeypatch.chdir(tmp_path)
    for name in ("program.py", "run.mcap"):
        (tmp_path / name).touch()
    file = tmp_path / next(word for word in words.split() if word.startswith("no/"))
    _said_to_be_wrong(words, option, "there is no folder no")
    file.mkdir(parents=True)
    _said_to_be_wrong(words, option, r"no/\S+ is a folder")
    file.rmdir()
    # root may write everywhere
    monkeypatch.setattr(os, "access", lambda path, *_: Path(path).name != "no")
    _said_to_be_wrong(words, option, r"no/\S+ cannot be written: no is write-protected")


@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("calibrate run.mcap --output ./run.mcap", "--output"),
        ("twin --learn run.mcap --limits run.mcap", "--limits"),
        ("plot run.mcap run.png --over run.png", "PICTURE"),
        ("preflight program.py --html program.py", "--html"),
    ],
)
def test_a_file_that_a_command_reads_is_not_written_over(
    words: str, option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("program.py", "run.mcap", "run.png"):
        (tmp_path / name).touch()
    _said_to_be_wrong(words, option, r"\S+ is read by this command, and would be overwritten")


def _said_to_be_wrong(words: str, option: str, wrong: str) -> None:
    answer = run(*words.split())
    told = " ".join(answer.output.replace("│", " ").split())
    assert answer.exit_code == 2, answer.output
    assert re.search(f"Invalid value for {option}: {wrong}", told), told


def test_waypoints_are_taught_although_the_controller_does_not_tell_its_arm(
    tmp_path: Path,
) -> None:
    file = tmp_path / "points.toml"
    with Simulator(generation="oldest") as sim:
        at = f"{sim.host}:{sim.port}"
        for name in ("one", "two"):
            done = run("teach", at, "-o", str(file), "--no-guide", typed=f"{name}\nq\n")
            assert done.exit_code == 0, done.output
    assert [each.name for each in WaypointFile.read(file).waypoints] == ["one", "two"]


def test_what_a_cell_tells_and_what_takes_no_cell_is_not_passed_over(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(f'arm = "gcr5_910"\n[robots.arm]\nhost = "{NOBODY}"\n')
    cell = ("--cell", str(tmp_path / "cell.toml"))
    answer = run("teach", *cell, "--output", "points.toml", "--yes")
    assert (answer.exit_code, "--output: it is for waypoints" in answer.stderr) == (2, True)
    answer = run("check", cell[1], "--model", "gcr10_1300")
    assert (answer.exit_code, "--model: it is for points" in answer.stderr) == (2, True)
    answer = run("teleop", *cell)
    assert (answer.exit_code, "--cell: it is for HOST" in answer.stderr) == (2, True)
