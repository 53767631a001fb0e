"""Runs the command line in this process: typer would make all commands anew each time."""

from __future__ import annotations

from functools import cache

from typer import testing
from typer.main import get_command
from typer.testing import CliRunner

__all__ = ["CliRunner"]

vars(testing)["_get_command"] = cache(get_command)
