"""All commands of `aioduco` in one app. Each command has a module of its own."""

from __future__ import annotations

import typer

import aioduco
from aioduco.cli.call import call
from aioduco.cli.check import check
from aioduco.cli.completion import completion
from aioduco.cli.demo.command import demo
from aioduco.cli.doctor import doctor
from aioduco.cli.export import export
from aioduco.cli.fleet import fleet
from aioduco.cli.io import io
from aioduco.cli.jog import jog
from aioduco.cli.monitor.monitor import monitor
from aioduco.cli.move import move
from aioduco.cli.output import say
from aioduco.cli.panel import panel
from aioduco.cli.play import play
from aioduco.cli.plot import plot
from aioduco.cli.preflight import preflight
from aioduco.cli.record import record
from aioduco.cli.ros1 import ros1
from aioduco.cli.ros2 import ros2
from aioduco.cli.sim import sim
from aioduco.cli.sim_do import sim_do
from aioduco.cli.status import status
from aioduco.cli.supervise import bring_up, pause, recover, resume, stop
from aioduco.cli.tap import tap
from aioduco.cli.teach import teach
from aioduco.cli.teleop import teleop
from aioduco.cli.view import view

__all__ = ["app"]

app: typer.Typer = typer.Typer(
    name="aioduco",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    # by default units in brackets, such as [rad/s], are taken for styles, and not shown
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(sim)
# A negative number is an argument, not an option.
app.command("sim-do", context_settings={"ignore_unknown_options": True})(sim_do)
app.command()(demo)
app.command()(status)
app.command()(monitor)
app.command()(panel)
app.command()(view)
app.command("bring-up")(bring_up)
app.command()(recover)
app.command()(stop)
app.command()(pause)
app.command()(resume)
app.add_typer(move, name="move")
app.command()(jog)
app.command()(teleop)
app.add_typer(io, name="io")
app.command()(doctor)
app.command()(record)
app.command()(plot)
app.command()(play)
app.command()(teach)
app.command()(check)
app.command(context_settings={"ignore_unknown_options": True})(call)
app.command()(export)
app.command()(preflight)
app.command()(ros1)
# Arguments after --ros-args are for ROS.
app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(ros2)
app.command()(tap)
app.add_typer(fleet, name="fleet")
app.command()(completion)


def _version(wanted: bool) -> None:
    if wanted:
        say(aioduco.__version__)
        raise typer.Exit


@app.callback()
def main(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Print the version and end."
    ),
) -> None:
    """DUCO robot arms: watch, lead, move and record them; and a simulated controller."""
