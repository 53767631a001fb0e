"""Control characters in texts of controllers, gateways and files do not reach the terminal."""

from __future__ import annotations

import ast
import errno
import io
import logging
import os
import signal
import subprocess
import sys
from pathlib import Path

import anyio
import pytest
import typer
from interpreter import python
from rich.live import Live
from rich.table import Table
from rich.text import Text

import aioduco
import aioduco.cli
from aioduco.cli.exit_codes import NOT_CONFIRMED, ended_by_errors
from aioduco.cli.output import ended_by_output, one_line, say, shown
from aioduco.cli.questions import ask, typed_line
from aioduco.cli.safe_console import SafeConsole

#: what a terminal carries out, or shows otherwise than it is: title, clipboard, colours, C1, DEL,
#: changed direction, invisible characters, half of a pair, line separator
FOREIGN = (
    "\x1b]0;pwned\x07", "\x1b]52;c;cm0=\x07", "\x1b[2J", "\x1b[8m", "\x9b2J", "\x9d0;x\x9c", "\x7f",
    "\r", "\x08\x08", "\x00", "\u202e", "\u2066", "\u200b", "\ufeff", "\U000e0041", "\ud800",
    "\u2028", "\x85",
)  # fmt: skip
ROOT = Path(aioduco.cli.__file__).parent


def harmless(text: str) -> bool:
    return all(each.isprintable() or each in "\n\u3000\xa0" for each in text)


@pytest.mark.parametrize("text", FOREIGN)
def test_controls_are_spelled_out(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert harmless(shown(text))
    assert shown(f"a{text}b") != "ab", "nothing is hidden"
    say(f"version 3.8{text}")
    say(ValueError(text), error=True)
    told = capsys.readouterr()
    assert harmless(told.out)
    assert harmless(told.err)


def test_what_can_be_read_stays() -> None:
    text = "关节 1\u3000超限\n\t12.5 mm, 90°, −0.1\xa0rad, é́"
    assert shown(text) == text
    assert one_line("a\nready  yes") == "a\\nready  yes"


@pytest.mark.parametrize("text", [each for each in FOREIGN if each != "\ud800"])
def test_a_console_draws_no_controls_and_no_markup(
    text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    console = SafeConsole()
    console.file = drawn = io.StringIO()
    table = Table("name", title=f"t{text}")
    table.add_row(f"[link=http://evil.example]x[/link]{text}")
    console.print(f"[red]a{text}")
    console.print(table)
    console.print(Text(f"b{text}"))
    with Live(Text(f"c{text}"), console=console, auto_refresh=False):
        pass
    assert text not in drawn.getvalue()
    assert "[red]a" in drawn.getvalue()
    assert "[link=" in drawn.getvalue()


def test_a_console_colours_no_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    console = SafeConsole()
    console.file = drawn = io.StringIO()
    console.print("12.5 mm of 'a'")
    assert drawn.getvalue() == "12.5 mm of 'a'\n"


def test_each_command_prints_by_these_functions_alone() -> None:
    """A command that prints by other means would print what a controller sends as it is."""
    others = set()
    for path in sorted(ROOT.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module == "rich.console":
                names = {each.name for each in node.names} & {"Console", "print"}
                others |= {(path.name, f"rich's {name}") for name in names}
            if isinstance(node, ast.Call):
                called = ast.unparse(node.func)
                if called in {"typer.echo", "typer.secho", "click.echo", "print"} or (
                    called.endswith((".stdout.write", ".stderr.write"))
                ):
                    others.add((path.name, called))
    assert others == {("output.py", "print"), ("safe_console.py", "rich's Console")}


def test_warnings_and_tracebacks_of_a_command_are_shown_not_carried_out() -> None:
    program = (
        "import logging, aioduco.cli.output as o; o.guard_streams()\n"
        "log = logging.getLogger('aioduco.x')\n"
        "log.warning('told %s', '\\x1b]0;pwned\\x07')\n"
        "try: robot.motion.movel()\n"
        "except NameError: log.exception('call robot.recover(), then robot.motion.movel')\n"
        "raise RuntimeError('\\x1b[2J')\n"
    )
    ended = python("-c", program, env={**os.environ, "PYTHONIOENCODING": "utf-8"})
    assert ended.returncode == 1
    assert "told \\x1b]0;pwned" in ended.stderr
    assert "RuntimeError: \\x1b[2J" in ended.stderr
    assert "call `aioduco recover`, then `aioduco call movel`\nTraceback" in ended.stderr
    assert harmless(ended.stderr)
    assert logging.lastResort is not None


def test_an_interrupt_while_a_command_is_loaded_is_no_traceback() -> None:
    program = "import aioduco.cli.output as o; o.guard_streams(); raise KeyboardInterrupt"
    ended = python("-c", program)
    assert (ended.returncode, ended.stderr) == (-signal.SIGINT, "interrupted\n")


def test_log_messages_name_commands_for_the_arm_of_the_command() -> None:
    program = (
        "import logging, aioduco.cli.output as o; o.guard_streams()\n"
        "from aioduco.cli.exit_codes import ended_by_errors\n"
        "with ended_by_errors(at='left'):\n"
        "    logging.getLogger('aioduco.x').warning('call robot.recover(), then robot.stop()')\n"
    )
    told = python("-c", program).stderr
    assert told.splitlines() == ["call `aioduco recover left`, then `aioduco stop left`"]


def test_every_command_guards_its_streams(monkeypatch: pytest.MonkeyPatch) -> None:
    guarded = []
    monkeypatch.setattr(aioduco.cli.output, "guard_streams", lambda: guarded.append(1))
    monkeypatch.setattr(sys, "argv", ["aioduco", "--version"])
    with pytest.raises(SystemExit):
        aioduco.cli.main()
    assert guarded


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_what_an_output_cannot_show_is_spelled_out(encoding: str) -> None:
    """As in a file to which the output of a command goes, on Windows."""
    program = (
        "import aioduco.cli.output as o; from aioduco.cli.safe_console import SafeConsole\n"
        "o.guard_streams()\n"
        "o.say('关节 90°'); o.say('超限', error=True); SafeConsole().print('检测 ✓')\n"
        "raise RuntimeError('检测')\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, check=False,
        env={**os.environ, "PYTHONIOENCODING": encoding, "NO_COLOR": "1"},
    )  # fmt: skip
    assert b"UnicodeEncodeError" not in ended.stderr
    assert b"\\u5173\\u8282 90" in ended.stdout
    assert b"\\u68c0\\u6d4b \\u2713" in ended.stdout
    assert b"\\u8d85\\u9650" in ended.stderr
    assert b"RuntimeError: \\u68c0\\u6d4b" in ended.stderr


@pytest.mark.slow
@pytest.mark.linux("/dev/full")
@pytest.mark.parametrize("words", [["--version"], ["--help"], ["completion", "bash"]])
def test_an_output_that_cannot_be_written_ends_the_command_without_a_traceback(
    words: list[str],
) -> None:
    command = [sys.executable, "-m", "aioduco.cli", *words]
    with Path("/dev/full").open("wb") as full:
        ended = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, check=False)
    said = b"the output cannot be written: No space left on device\n"
    assert (ended.returncode, ended.stderr) == (1, said)
    ours, theirs = os.pipe()
    os.close(ours)
    with os.fdopen(theirs, "wb") as closed:
        ended = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, check=False)
    assert (ended.returncode, ended.stderr) == (1, b"")
    closing = "import os, sys; os.close(1); os.execv(sys.executable, sys.argv[1:])"  # as `>&-`
    ended = subprocess.run(
        [sys.executable, "-c", closing, *command], stderr=subprocess.PIPE, check=False
    )
    said = b"the output cannot be written: Bad file descriptor\n"
    assert (ended.returncode, ended.stderr) == (1, said)


class FullDisk(io.StringIO):
    def flush(self) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")


def test_no_command_takes_a_full_disk_for_a_failure_of_its_own(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    async def serve() -> None:
        async with anyio.create_task_group():
            say("left is on http://127.0.0.1:8080/")

    monkeypatch.setattr(sys, "stdout", FullDisk())
    with pytest.raises(SystemExit, match=r"^1$"), ended_by_output(), ended_by_errors():
        anyio.run(serve)
    assert capsys.readouterr().err == "the output cannot be written: No space left on device\n"
    with pytest.raises(FileNotFoundError), ended_by_output():
        raise FileNotFoundError(errno.ENOENT, "no such file")


def test_a_closed_terminal_does_not_change_how_a_command_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for gone in (FullDisk(), None):
        monkeypatch.setattr(sys, "stderr", gone)
        monkeypatch.setattr(sys, "stdout", told := io.StringIO())
        with pytest.raises(SystemExit, match=r"^4$"), ended_by_output(), ended_by_errors():
            raise aioduco.StopUnconfirmed("it is not known")
        assert told.getvalue() == "", "no message is taken for the result"


def test_without_a_standard_input_no_question_is_confirmed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As under `<&-`."""
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(typer.Exit) as ended:
        ask("The arm will move.", "Move the arm?", yes=False)
    assert ended.value.exit_code == NOT_CONFIRMED
    assert "not confirmed: nothing was sent" in capsys.readouterr().err
    assert typed_line("touch 1: ") is None


def test_what_is_typed_in_another_encoding_is_a_wrong_answer() -> None:
    """As a name in Latin-1, which ended hand guiding by a traceback."""
    program = (
        "import aioduco.cli.output as o; from aioduco.cli.questions import ask, typed_line\n"
        "o.guard_streams(); o.say(ascii(typed_line('name: ')))\n"
        "ask('The arm will move.', 'Move the arm?', yes=False)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, check=False, input=b"caf\xe9\n\xff\n",
        env={**os.environ, "PYTHONIOENCODING": "utf-8:strict"},
    )  # fmt: skip
    assert ended.stdout.strip() == b"'caf\\udce9'"
    assert b"not confirmed" in ended.stderr


@pytest.mark.linux("descriptors that a child inherits by number")
@pytest.mark.slow  # a process
def test_no_socket_takes_the_number_of_a_closed_stream() -> None:
    """A process that is started would take it for its standard output; and a stream is no None."""
    looked = (
        "import sys, socket; from aioduco.cli.output import guard_streams; guard_streams()\n"
        "number = socket.socket().fileno()\n"
        "sys.stderr.write('lost')\n"
        "sys.exit(10 * (number > 2) + sys.stdin.isatty() + len(sys.stdin.read()))"
    )
    closed = "import os, sys; os.closerange(0, 3); os.execv(sys.executable, sys.argv[1:])"
    words = [sys.executable, "-c", closed, sys.executable, "-W", "ignore", "-c", looked]
    assert subprocess.run(words, check=False).returncode == 10
