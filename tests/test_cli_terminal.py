"""Each command in a pseudo-terminal, with its questions answered there.

`demo` and `monitor` are tried there by their own tests, in `test_cli.py` and `test_cli_monitor.py`.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from patient import COMMAND_LINE
from ports import free_port
from recording.playback.recorded import write
from terminals import terminal
from test_cli_robot import ready_arm

from aioduco.cli.app import app
from aioduco.sim import Simulator

pytestmark = pytest.mark.slow

CTRL_C = b"\x03"
YES = ((b"[y/N]", b"y\r"),)


class Row(NamedTuple):
    """A command, what is typed when the terminal shows what, and how it ends.

    In the words, `{at}` is the controller's address, `{host}` and `{port}` its parts, and `{here}`
    a folder: in it are a recording, run.mcap, a program, main.py, a fleet's file, fleet.toml, and
    one without arms, alone.toml.
    """

    words: str
    typed: tuple[tuple[bytes, bytes], ...] = ()
    shows: bytes = b""
    code: int = 0


ROWS = [
    Row("sim --port 0", ((b"127.0.0.1", CTRL_C),)),
    Row("status {at}", shows=b"ENABLE"),
    Row("bring-up {at}", YES, b"ENABLE"),
    Row("recover {at}", YES, b"ENABLE"),
    Row("move joints 0.1 0 0 0 0 0 --by --host {at}", YES, b"finished"),
    Row("jog j1 + --step 1 --deg --host {at}", YES),
    Row("io read --host {at}", shows=b"inputs"),
    Row("io set 5 on --host {at}", YES),
    Row("record {at} --seconds 0.5 -o {here}/new.mcap", shows=b"entries"),
    Row("plot {here}/run.mcap {here}/run.html", shows=b"written to"),
    Row("play {here}/run.mcap {at} --no-rehearse", ((b"[y/N]", b"n\r"),), b"not confirmed", 3),
    Row(
        "teach {at} -o {here}/cell.toml",
        (*YES, (b"waypoint 1", b"corner\r"), (b"waypoint 2", b"q\r")),
        b"the arm stands",
    ),
    Row("tool touch {at}", (*YES, (b"touch 1", b"q\r")), b"0 touches gave no tip", 1),
    Row("payload {at}", (*YES, (b"pose 1", b"q\r")), b"0 poses", 1),
    Row("init {here}/project", shows=b"written to"),
    Row("preflight {here}/main.py", shows=b"main.py"),
    Row("export urdf -o {here}/urdf", shows=b"urdf"),
    Row("doctor {at} --seconds 0.1"),
    Row("call robotmoving --host {at}"),
    Row("tap {host} --port {port} --listen 127.0.0.1:0", ((b"between", CTRL_C),)),
    Row("check {at}", shows=b"0 different"),
    Row("completion bash", shows=b"complete_bash"),
    Row("view {at} --foxglove --listen 0 --seconds 0.5", shows=b"ws://"),
    Row("panel {at} --listen 0", ((b"http://", CTRL_C),), code=130),
    Row("panel {at} --listen 0 --watch-only", ((b"http://", CTRL_C),), code=130),
    Row("fleet serve {here}/fleet.toml", ((b"left", CTRL_C),), code=130),
    Row("fleet status {here}/alone.toml", shows=b"no gateway was found", code=1),
    Row("ros1 --host {host}", shows=b"of ROS 1", code=1),
    Row("ros2 --host {host}", shows=b"of ROS 2", code=1),
]
#: in the files named above and test_cli_robot.py, or, for twin and calibrate, in tests/sim
ELSEWHERE = {
    *("demo", "monitor", "stop", "pause", "resume", "teleop", "sim-do", "twin", "calibrate")
}


@pytest.fixture(scope="module")
def arm() -> Iterator[Simulator]:
    """One for all of the commands, each of which leaves it enabled and standing."""
    with ready_arm() as sim:
        yield sim


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.words.partition(" {")[0])
def test_a_command_in_a_terminal(row: Row, arm: Simulator, tmp_path: Path) -> None:
    write(tmp_path / "run.mcap")
    (tmp_path / "main.py").write_text(
        "import aioduco.sync\n"
        "with aioduco.sync.connect('192.0.2.1') as robot:\n"
        "    robot.bring_up()\n"
    )
    at = f"{arm.host}:{arm.port}"
    for name, arms in (
        ("fleet", f'[[arm]]\nname = "left"\nhost = "{arm.host}"\nport = {arm.port}\n'),
        ("alone", ""),
    ):
        where = f'name = "tried"\ngateway = "{name}"\nlisten = ["tcp/127.0.0.1:{free_port()}"]\n'
        (tmp_path / f"{name}.toml").write_text(f"[fleet]\n{where}{arms}")
    known = {"at": at, "host": arm.host, "port": arm.port, "here": tmp_path}
    with terminal(*row.words.format(**known).split(), command=COMMAND_LINE) as shell:
        for text, keys in row.typed:
            shell.until_it_shows(text)
            if keys == CTRL_C:  # its terminal is not the one that controls it
                os.killpg(shell.program.pid, signal.SIGINT)
            else:
                shell.press(keys)
        code = shell.exit_code()
        shown = bytes(shell.seen)
    assert code == row.code, shown
    assert row.shows in shown
    assert b"Traceback" not in shown
    assert not arm.moving


def test_each_command_is_tried_in_a_terminal() -> None:
    groups = {group.name for group in app.registered_groups}
    commands = {
        each.name or each.callback.__name__.replace("_", "-")
        for each in app.registered_commands
        if each.callback is not None
    }
    tried = {row.words.split()[0] for row in ROWS}
    assert {*commands, *groups} == tried | ELSEWHERE
