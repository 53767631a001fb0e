"""The commands of `aioduco`, put together. Each lives in a module of its own."""

from __future__ import annotations

import typer

import aioduco
from aioduco.cli.call import call
from aioduco.cli.check import check
from aioduco.cli.demo.command import demo
from aioduco.cli.doctor import doctor
from aioduco.cli.export import export
from aioduco.cli.plot import plot
from aioduco.cli.preflight import preflight
from aioduco.cli.record import record
from aioduco.cli.ros1 import ros1
from aioduco.cli.sim import sim
from aioduco.cli.sim_do import sim_do

__all__ = ["app"]

app: typer.Typer = typer.Typer(
    name="aioduco",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(sim)
# A number below zero is a word, not an option.
app.command("sim-do", context_settings={"ignore_unknown_options": True})(sim_do)
app.command()(demo)
app.command()(doctor)
app.command()(record)
app.command()(plot)
app.command()(check)
app.command(context_settings={"ignore_unknown_options": True})(call)
app.command()(export)
app.command()(preflight)
app.command()(ros1)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(aioduco.__version__)
        raise typer.Exit


@app.callback()
def main(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Print the version and end."
    ),
) -> None:
    """DUCO robot arms: a simulated controller, and a demonstration on it or on an arm."""
