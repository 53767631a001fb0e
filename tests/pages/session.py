"""Runs the commands of a page as typed: in one folder, some of them side by side.

It needs Python's own library alone, so that it drives an environment other than the one it is in.
"""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Self

__all__ = ["CommandFailed", "Session", "commands"]

#: what only makes the environment, which is there already
INSTALLS = re.compile(
    r"(sudo |python3 -m venv |(\.venv/bin/)?pip install |\. \.venv/|source \.venv/|exit$|cd )"
)
#: what goes on until it is interrupted, and the output by which it is known to have begun
ENDLESS = re.compile(r"aioduco (sim(?!-)|tap|view|record(?!.*--seconds))\b")
#: it cannot be done where there is no display, or no terminal
SHOWN = re.compile(r"aioduco (monitor|sim\b.*--view)\b")
_LONGEST = 300.0


class CommandFailed(Exception):
    """A command of a page did not end as it should."""


def commands(code: str, language: str) -> Iterator[str]:
    """The commands of a block, one by one.

    Args:
        code: the block's lines.
        language: `console` has commands behind `$ `, and what they print between them.
    """
    if language == "console":
        code = "".join(line[2:] for line in code.splitlines(True) if line.startswith("$ "))
    kept = ""
    for line in code.splitlines():
        kept += line
        if kept.endswith("\\"):
            kept = kept[:-1]
            continue
        if kept.strip() and not kept.lstrip().startswith("#"):
            yield kept.strip()
        kept = ""


class Session:
    """Runs commands in a folder, and ends those that go on by themselves.

    Args:
        folder: where they are run.
        environment: variables that they have besides those of this process.
        replaced: words that are replaced in them, such as an address.
        echo: print what is run and what it printed.
    """

    def __init__(
        self,
        folder: Path,
        environment: Mapping[str, str],
        replaced: Mapping[str, str] | None = None,
        *,
        echo: bool = False,
    ) -> None:
        self._folder = folder
        kept = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("PYTEST_", "PYTHON", "AIODUCO_"))
        }
        self._environment = kept | dict(environment)
        self._replaced = dict(replaced or {})
        self._echo = echo
        self._endless: list[_Endless] = []
        self._beside: subprocess.Popen[str] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._beside is not None:
            self._beside.kill()
            self._beside.communicate()
        for each in reversed(self._endless):
            each.end()

    def write(self, name: str, code: str) -> None:
        """Save a file of the page."""
        self._say(f"# {name}: {len(code.splitlines())} lines")
        (self._folder / name).write_text(self._there(code), encoding="utf-8")

    def begin(self, command: str) -> None:
        """Begin a program that ends by itself, or by what comes next. `wait` sees its end."""
        self.wait()
        self._say(f"(beside it) $ {self._there(command)}")
        self._beside = subprocess.Popen(
            shlex.split(self._there(command)),
            cwd=self._folder,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def wait(self) -> None:
        """Wait for the end of what was begun.

        Raises:
            CommandFailed: its exit status was another than 0.
        """
        beside, self._beside = self._beside, None
        if beside is None:
            return
        said, _ = beside.communicate(timeout=_LONGEST)
        self._say(said, "(beside it) | ")
        if beside.returncode:
            raise CommandFailed(f"exit status {beside.returncode}\n{said}")

    def run(self, command: str, *, quiet: bool = False) -> str:
        """Run one command to its end, or until it has begun if it goes on by itself.

        Args:
            command: a line of the shell.
            quiet: do not show it: it is no command of the page.

        Returns:
            What it printed on either output.

        Raises:
            CommandFailed: its exit status was another than 0.
        """
        command = self._there(command)
        self._say("" if quiet else f"$ {command}")
        if ENDLESS.search(command):
            running = _Endless(command, self._folder, self._environment)
            self._endless.append(running)
            begun = running.begun()
            self._say(begun, "| ")
            return begun
        # Whatever is asked is answered by yes: the arm is a simulated one.
        done = subprocess.run(
            ["bash", "-c", command],
            check=False,
            cwd=self._folder,
            env=self._environment,
            input="y\ny\n",
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=_LONGEST,
        )
        self._say("" if quiet else done.stdout, "| ")
        if done.returncode:
            raise CommandFailed(f"{command}: exit status {done.returncode}\n{done.stdout}")
        return done.stdout

    def end_last(self) -> None:
        """Interrupt what was begun last, and see it end as after Ctrl-C."""
        self._endless.pop().end()

    def replace(self, words: Mapping[str, str]) -> None:
        """Replace these words, too."""
        self._replaced.update(words)

    def _there(self, text: str) -> str:
        # each place once: a word may begin another one
        words = sorted(self._replaced, key=len, reverse=True)
        if not words:
            return text
        return re.sub("|".join(map(re.escape, words)), lambda m: self._replaced[m[0]], text)

    def _say(self, text: str, before: str = "") -> None:
        if self._echo:
            for line in text.splitlines():
                print(before + line, flush=True)  # noqa: T201 - what `.ci/tutorial` shows


class _Endless:
    """A command that goes on until Ctrl-C."""

    def __init__(self, command: str, folder: Path, environment: Mapping[str, str]) -> None:
        self._command = command
        words = shlex.split(command, comments=True)
        self._process = subprocess.Popen(
            words,
            cwd=folder,
            env={**environment, "PYTHONUNBUFFERED": "1"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self._lines: list[str] = []
        self._first = threading.Event()
        self._reader = threading.Thread(target=self._read, name=f"output of {words[1]}")
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.append(line)
            self._first.set()
        self._first.set()

    def begun(self) -> str:
        self._first.wait(_LONGEST)
        if not self._lines or self._process.poll() is not None:
            self.end()
            raise CommandFailed(f"{self._command}: did not begin\n{''.join(self._lines)}")
        return self._lines[0]

    def end(self) -> None:
        before = self._process.poll()
        # A program that is interrupted as it begins may not have its handler yet.
        for _ in range(3):
            if self._process.poll() is None:
                self._process.send_signal(signal.SIGINT)
            try:
                self._process.wait(_LONGEST / 3)
                break
            except subprocess.TimeoutExpired:
                continue
        else:
            self._process.kill()
        self._reader.join()
        assert self._process.stdout is not None
        self._process.stdout.close()
        if before is None and self._process.returncode not in {0, 130}:
            raise CommandFailed(
                f"{self._command}: exit status {self._process.returncode} after Ctrl-C\n"
                + "".join(self._lines)
            )
