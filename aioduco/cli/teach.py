"""`aioduco teach`: store waypoints while the arm is guided by hand."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli.addresses import Host, Port, robot_at
from aioduco.cli.output import say
from aioduco.cli.questions import ask
from aioduco.cli.sessions import control_session, observing_session

if TYPE_CHECKING:
    from aioduco.recording.playback import WaypointFile
    from aioduco.sync import Robot

__all__ = ["teach"]

_END = "q"


def teach(
    host: Host = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="File; new waypoints are appended to it.")
    ] = Path("waypoints.toml"),
    port: Port = None,
    guide: Annotated[
        bool, typer.Option(help="Guide the arm by hand, or move it in another way.")
    ] = True,
    yes: Annotated[
        bool, typer.Option("--yes", help="Do not ask before hand guiding begins.")
    ] = False,
) -> None:
    """Guide the arm by hand, and press Enter to store where it is.

    A line with a name stores a waypoint with that name, an empty line a numbered one; q ends. Each
    is written to the file at once. `aioduco play FILE.toml HOST` moves the arm through them.

    aioduco teach 192.168.1.10 -o cell.toml

    Exit codes: 0 it ended; 1 it failed; 2 wrong options; 3 not confirmed; 4 it is not known that
    the arm stands; 130, 143 Ctrl-C or SIGTERM: the arm stands.
    """
    address = robot_at(host, port)
    # No heartbeat: another program may lead the arm.
    with observing_session(address) as robot:
        kept = _file(robot, output)
        if not guide:
            _keep(robot, kept, output)
            return
    text = (
        f"The arm at {address} will give way to a hand. With a load or tool that its controller "
        "does not know of, it sinks or rises by itself. Hold it."
    )
    ask(text, "Let it give way?", yes=yes)
    # A person may take any time: hand guiding must not stop because no call is made.
    with control_session(address, hold_limit=None) as robot:
        robot.bring_up()
        with robot.motion.teach_mode.start():
            _keep(robot, kept, output)
    say("hand guiding has ended, the arm stands")


def _file(robot: Robot, path: Path) -> WaypointFile:
    """The existing file, or a new one."""
    from aioduco.errors import PathRefused  # noqa: PLC0415
    from aioduco.recording.playback import WaypointFile  # noqa: PLC0415
    from aioduco.recording.playback.player import arm_named  # noqa: PLC0415

    told = arm_named(robot.version.get_robot_type())
    if not path.exists():
        return WaypointFile.new(arm=told, title=str(path))
    kept = WaypointFile.read(path)
    if kept.arm and told and kept.arm != told:
        text = f"it is for a {kept.arm}, and this is a {told}"
        raise PathRefused(f"{path}: {text}; nothing was sent", (text,))
    say(f"{path} has {len(kept.waypoints)} waypoints; new ones follow them")
    return kept


def _keep(robot: Robot, kept: WaypointFile, path: Path) -> None:
    """Store a waypoint for each typed line."""
    while True:
        try:
            line = input(f"name of waypoint {len(kept.waypoints) + 1}, Enter, or {_END}: ")
        except EOFError:
            say()
            return
        if line.strip() == _END:
            return
        name = line.strip() or f"p{len(kept.waypoints) + 1}"
        found = kept.add(name, robot.state.get_actual_joints_position())
        kept.save(path)
        degrees = ", ".join(f"{angle:.2f}°" for angle in found.joints.degrees)
        say(f"{name}: {degrees}")
