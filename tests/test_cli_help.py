"""What the help of each command says of its options."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from cli_runner import CliRunner
from for_each import for_each
from typer.main import get_command

from aioduco.cli.app import app, app_for


def commands(command: Any, *names: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Each command that does something, with the names that lead to it."""
    inner = getattr(command, "commands", None)
    if inner is None:
        yield names, command
        return
    for name, each in inner.items():
        yield from commands(each, *names, name)


ROOT = Path(__file__).parents[1]
COMMANDS = dict(commands(get_command(app)))


def said(text: str) -> str:
    """Its words, without the frames of a terminal."""
    return " ".join(re.sub(r"[│╭╮╰╯─]", " ", text.replace("`", "")).split())


#: commands that end as any program does
NO_CODES = {"plot", "demo", "sim", "sim-do", "preflight", "tap", "export"}


@pytest.mark.parametrize("names", COMMANDS, ids=" ".join)
def test_help_shows_an_example_the_exit_codes_and_every_text_whole(names: tuple[str, ...]) -> None:
    done = CliRunner().invoke(
        app, [*names, "--help"], env={"COLUMNS": "400", "TERMINAL_WIDTH": "400"}
    )
    assert done.exit_code == 0
    helps = [text for each in COMMANDS[names].params if (text := getattr(each, "help", None))]
    assert helps
    assert f"aioduco {' '.join(names)} " in said(done.stdout)
    assert "Exit codes: " in done.stdout or names[0] in NO_CODES
    missing = [text for text in helps if said(text) not in said(done.stdout)]
    assert not missing


@for_each("names", COMMANDS)
def test_every_option_and_argument_has_a_help(names: tuple[str, ...]) -> None:
    """A name that the docstring of a command spells in another way would leave it without one."""
    assert [str(each.name) for each in COMMANDS[names].params if not each.help] == []


ADDRESSED = [
    names
    for names, command in COMMANDS.items()
    if any(each.name == "host" and "--host" not in each.opts for each in command.params)
]


@for_each("names", ADDRESSED)
def test_an_address_that_is_an_argument_may_be_an_option(names: tuple[str, ...]) -> None:
    """As others have it: an operator who stops an arm has no time to look up which do."""
    command = COMMANDS[names]
    needed = [__file__ for each in command.params if each.required]
    for words in (["left"], ["--host", "left"], ["--host=left"]):
        context = command.make_context(" ".join(names), [*needed, *words])
        assert context.params["host"] == "left"


def test_a_command_is_made_alone() -> None:
    """To make all of them takes as long as Python to start."""
    for name in vars(get_command(app))["commands"]:
        assert list(vars(get_command(app_for([name, "--help"])))["commands"]) == [name]
    for words in ([], ["--help"], ["stat"]):
        assert app_for(words) is app


def linked(row: str) -> list[str]:
    """The commands of a row of links: of `tool touch` the first word, the command of the list."""
    texts = ", ".join(re.findall(r"\[(.*?)\]", row)).split(", ")
    return list(dict.fromkeys(text.split()[0] for text in texts))


def test_the_list_of_commands_is_in_parts_which_are_those_of_the_page() -> None:
    """Thirty names in one list are read by nobody."""
    parts: dict[str, list[str]] = {}
    for name, command in vars(get_command(app))["commands"].items():
        parts.setdefault(str(command.rich_help_panel).lower(), []).append(name)
    page = (ROOT / "docs" / "reference" / "cli.md").read_text("utf-8")
    rows = re.findall(r"^\| ([a-z ,]+) \| (\[.*) \|$", page, re.MULTILINE)
    shown = {part: linked(row) for part, row in rows}
    assert {part: sorted(names) for part, names in parts.items()} == {
        part: sorted(names) for part, names in shown.items()
    }
    assert max(map(len, parts.values())) <= 7
