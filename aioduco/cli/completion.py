"""`aioduco completion`: the script with which a shell completes the commands."""

from __future__ import annotations

import enum
import importlib

from aioduco.cli.output import say


class Shell(enum.StrEnum):
    """Supported shells."""

    BASH = "bash"
    ZSH = "zsh"
    FISH = "fish"


def completion(shell: Shell) -> None:
    """Print the script with which a shell completes commands, options and names of robots.

    aioduco completion bash > ~/.local/share/bash-completion/completions/aioduco

    aioduco completion zsh >> ~/.zshrc

    aioduco completion fish > ~/.config/fish/completions/aioduco.fish

    Exit codes: 0 printed; 2 wrong options.

    Args:
        shell: bash, zsh or fish.
    """
    # typer has this function, but does not declare it for type checkers
    scripts = importlib.import_module("typer.completion")
    names = {"prog_name": "aioduco", "complete_var": "_AIODUCO_COMPLETE"}
    say(scripts.get_completion_script(shell=shell.value, **names))
