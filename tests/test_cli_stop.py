"""`aioduco stop`: with and without the command line proper, and until the arm stands."""

from __future__ import annotations

import signal
import subprocess
import threading
from pathlib import Path

import pytest
from cli_runner import CliRunner
from for_each import for_each
from interpreter import python
from patient import COMMAND_LINE
from wire.servers import Peer, ScriptedServer

from aioduco.cli import stopping
from aioduco.cli.app import app
from aioduco.cli.robots_file import RobotAddress
from aioduco.cli.stopping import PlainStop, plain_stop

STATES = [6, 0, 5, 1]


@pytest.fixture(autouse=True)
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file of robots that has one."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("AIODUCO_HOST", "10.0.0.9")
    (tmp_path / "aioduco").mkdir()
    file = tmp_path / "aioduco" / "robots.toml"
    file.write_text('[left]\nhost = "10.0.0.1"\nport = 7\n')
    return file


@pytest.fixture
def by_typer(monkeypatch: pytest.MonkeyPatch) -> list[PlainStop]:
    """The stops that the command line proper arrives at."""
    found: list[PlainStop] = []

    def stop_at(address: RobotAddress, *, as_json: bool) -> None:
        found.append(PlainStop(address, as_json))

    monkeypatch.setattr(stopping, "stop_at", stop_at)
    return found


@pytest.mark.parametrize(
    "words",
    [
        (),
        ("left",),
        ("left", "--json"),
        ("--json", "--port", "8", "left"),
        ("--port=8",),
        ("10.0.0.2:9", "--json"),
        ("[::1]:9",),
        ("::1", "--port", "65535"),
        ("--host", "left", "--json"),
        ("--host=10.0.0.2", "--port", "8"),
    ],
    ids=str,
)
def test_a_plain_stop_is_understood_as_by_the_command_line(
    words: tuple[str, ...], by_typer: list[PlainStop]
) -> None:
    assert CliRunner().invoke(app, ["stop", *words]).exit_code == 0
    assert by_typer == [plain_stop(words)]


@for_each(
    "words, code",
    [
        (("--help",), 0),
        (("-h",), 0),
        (("--jsn",), 2),
        (("--json=1",), 2),
        (("--port",), 2),
        (("--port", "0"), 2),
        (("--port", "70000"), 2),
        (("--port", "x"), 2),
        (("left", "right"), 2),
        (("left", "--host", "right"), 2),
        (("--host", "right", "left"), 2),
        (("--host", "left", "--host", "right"), 2),
        (("--host",), 2),
        (("--host", "--json"), 2),
        (("left:",), 2),
    ],
)
def test_all_else_is_left_to_the_command_line(
    words: tuple[str, ...], code: int, by_typer: list[PlainStop]
) -> None:
    assert plain_stop(words) is None
    assert CliRunner().invoke(app, ["stop", *words]).exit_code == code
    assert by_typer == []


def test_a_file_of_robots_that_is_wrong_is_left_to_the_command_line(config: Path) -> None:
    config.write_text("[left")
    assert plain_stop(["left"]) is None
    answer = CliRunner().invoke(app, ["stop", "left"])
    assert (answer.exit_code, "cannot be read" in answer.output) == (2, True)


def answers(peer: Peer) -> None:
    """A controller whose arm stands at once."""
    while (call := peer.receive()) is not None:
        peer.answer(call, STATES if call.name == "get_robot_state" else 0)


def command(server: ScriptedServer, *options: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [*COMMAND_LINE, "stop", f"{server.host}:{server.port}", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "said"),
    [((), "stopped: the arm stands; robot ENABLE"), (("--json",), '"robot": "ENABLE"')],
)
def test_the_states_after_it_are_printed(options: tuple[str, ...], said: str) -> None:
    with ScriptedServer(answers) as server:
        done, errors = command(server, *options).communicate(timeout=60)
    assert (said in done, errors) == (True, ""), done
    assert server.names[0] == "stop"


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_stop_that_is_told_to_end_goes_on_until_the_arm_stands(
    number: signal.Signals, code: int
) -> None:
    told = threading.Event()

    def silent_until_told(peer: Peer) -> None:
        while (call := peer.receive()) is not None:
            if told.is_set():
                peer.answer(call, STATES if call.name == "get_robot_state" else 0)

    with ScriptedServer(silent_until_told) as server:
        stopping_ = command(server)
        server.wait_calls(1)
        stopping_.send_signal(number)
        told.set()
        _, errors = stopping_.communicate(timeout=60)
    assert (stopping_.returncode, "interrupted" in errors) == (code, True), errors
    assert server.names.count("robotmoving") >= 2


@pytest.mark.slow
@pytest.mark.parametrize("missing", ["typer", "rich"])
def test_it_needs_no_extra(missing: str) -> None:
    program = (
        f"import sys; sys.modules[{missing!r}] = None\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from patient import be_patient\nbe_patient()\n"
        "from aioduco.cli import main\nmain()"
    )
    with ScriptedServer(answers) as server:
        done = python("-c", program, "stop", f"{server.host}:{server.port}")
    assert (done.returncode, done.stderr) == (0, "")
