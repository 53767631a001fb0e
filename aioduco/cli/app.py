"""All commands of `aioduco` in one app. Each command has a module of its own."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any, Final

import typer
from typer.main import get_command_name

import aioduco
from aioduco.cli.calibrate import calibrate
from aioduco.cli.call import call
from aioduco.cli.check import check
from aioduco.cli.completion import completion
from aioduco.cli.demo import demo
from aioduco.cli.described import DescribedCommand
from aioduco.cli.doctor import doctor
from aioduco.cli.export import export
from aioduco.cli.fleet import fleet
from aioduco.cli.init import init
from aioduco.cli.io import io
from aioduco.cli.jog import jog
from aioduco.cli.monitor.monitor import monitor
from aioduco.cli.move import move
from aioduco.cli.options import WITH_NUMBERS
from aioduco.cli.output import say
from aioduco.cli.panel import panel
from aioduco.cli.payload import payload
from aioduco.cli.play import play
from aioduco.cli.plot import plot
from aioduco.cli.preflight import preflight
from aioduco.cli.record import record
from aioduco.cli.ros import ros1, ros2
from aioduco.cli.sim import sim
from aioduco.cli.sim_do import sim_do
from aioduco.cli.status import status
from aioduco.cli.supervise import bring_up, pause, recover, resume, stop
from aioduco.cli.tap import tap
from aioduco.cli.teach import teach
from aioduco.cli.teleop import teleop
from aioduco.cli.tool import tool
from aioduco.cli.twin import twin
from aioduco.cli.view import view

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


app: typer.Typer = typer.Typer(
    name="aioduco",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    # by default units in brackets, such as [rad/s], are taken for styles, and not shown
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)
#: the parts of `aioduco --help`, as in the table of docs/reference/cli.md
_PARTS: Final[dict[str, tuple[typer.Typer | Callable[..., object], ...]]] = {
    "Watch an arm": (status, monitor, panel, view, twin),
    "Bring it up, stop it": (bring_up, recover, stop, pause, resume),
    "Move it": (move, jog, teleop, teach, io, call),
    "Recordings": (record, plot, play),
    "Try without an arm": (demo, sim, sim_do, preflight),
    "Several computers": (fleet,),
    "Other programs": (ros1, ros2, tap, export),
    "Prepare": (init, doctor, check, calibrate, tool, payload, completion),
}
_SETTINGS: Final[dict[object, dict[str, Any]]] = {
    **dict.fromkeys((jog, call, sim_do), WITH_NUMBERS),
    # arguments after --ros-args are for ROS
    ros2: {"allow_extra_args": True, **WITH_NUMBERS},
}
for _part, _members in _PARTS.items():
    for _member in _members:
        if isinstance(_member, typer.Typer):
            app.add_typer(_member, name=_member.info.name, rich_help_panel=_part)
        else:
            app.command(
                cls=DescribedCommand, rich_help_panel=_part, context_settings=_SETTINGS.get(_member)
            )(_member)


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


def app_for(words: Sequence[str]) -> typer.Typer:
    """Give the app for words of a command line.

    It has the command alone that they name: typer takes as long to make all of them as Python to
    start. If they name none, it is the whole app.
    """
    name = words[0] if words else ""
    alone = copy.copy(app)
    alone.registered_groups = [each for each in app.registered_groups if each.name == name]
    alone.registered_commands = [
        each
        for each in app.registered_commands
        if each.callback is not None
        and (each.name or get_command_name(each.callback.__name__)) == name
    ]
    return alone if alone.registered_commands or alone.registered_groups else app
