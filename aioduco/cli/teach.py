"""`aioduco teach`: store waypoints while the arm is guided by hand."""

from __future__ import annotations

from copy import copy
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli.addresses import CellFile, Host, Port, robot_at
from aioduco.cli.cell_file import is_cell, load_cell
from aioduco.cli.exit_codes import say_error
from aioduco.cli.options import Guide, refuse_unused, require_writable
from aioduco.cli.output import say
from aioduco.cli.sessions import (
    guided_session,
    guiding,
    observing_session,
    reported_name,
)
from aioduco.cli.status import degrees, pose_line

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco import Cell
    from aioduco.recording.playback import WaypointFile
    from aioduco.sync import Robot


_END = "q"


def teach(
    context: typer.Context,
    host: Host = None,
    output: Annotated[Path, typer.Option("--output", "-o")] = Path("waypoints.toml"),
    port: Port = None,
    cell: CellFile = None,
    guide: Guide = True,
    yes: bool = False,
) -> None:
    """Guide the arm by hand, and press Enter to store where it is.

    A line with a name stores a waypoint with that name, an empty line a numbered one; q ends. Each
    is written to the file at once. `aioduco play FILE.toml HOST` moves the arm through them.

    With --cell a line with a name stores a point of the cell; one that is there is taught again, as
    the joints or the pose that it is. Comments and order of the file stay.

    aioduco teach 192.168.1.10 -o points.toml

    aioduco teach left --cell cell.toml

    Exit codes: 0 it ended; 1 it failed; 2 wrong options; 3 not confirmed; 4 it is not known that
    the arm stands; 130, 143 Ctrl-C or SIGTERM: the arm stands.

    Args:
        output: File; new waypoints are appended to it.
        yes: Do not ask before hand guiding begins.
    """
    if cell is None and is_cell(output):
        text = f"{output} is the file of a cell: --cell {output} stores points there"
        raise typer.BadParameter(text, param_hint="--output")
    if cell is not None:
        refuse_unused(context, "waypoints: with --cell, points are stored there", "output")
    require_writable("--output", output)
    address = robot_at(host, port, cell)
    # No heartbeat: another program may lead the arm.
    with observing_session(address) as robot:
        store = _file(robot, output) if cell is None else _CellPoints(load_cell(cell))
        if not guide:
            _keep(robot, store)
            return
        states = robot.state.get_robot_state()
    with guided_session(address, states, yes=yes) as robot:
        _keep(robot, store, guiding(robot))
    say("hand guiding has ended, the arm stands")


class _Waypoints:
    """A file of waypoints, to which each taught one is appended."""

    def __init__(self, kept: WaypointFile, path: Path) -> None:
        self._kept = kept
        self._path = path

    @property
    def asked(self) -> str:
        return f"name of waypoint {len(self._kept.waypoints) + 1}, Enter"

    @property
    def usual(self) -> str:
        return f"p{len(self._kept.waypoints) + 1}"

    def store(self, name: str, robot: Robot) -> str:
        """Write the place where the arm is; return it as text."""
        from aioduco.recording.playback import WaypointFile  # noqa: PLC0415 - quick help

        # read again: a person may have edited it meanwhile
        there = self._path.exists()
        kept = WaypointFile.read(self._path) if there else copy(self._kept)
        found = kept.add(name, robot.state.get_actual_joints_position())
        kept.save(self._path)
        self._kept = kept
        return ", ".join(degrees(found.joints))


class _CellPoints:
    """The file of a cell, whose named points are taught."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        say(f"{cell.path} has the points {', '.join(cell) or 'none'}")

    asked = "name of a point"
    usual = ""

    def store(self, name: str, robot: Robot) -> str:
        """Write the place where the arm is; return it as text."""
        from aioduco import Cell, Pose  # noqa: PLC0415 - quick help

        self._cell = Cell.load(self._cell.path)  # again: a person may have edited it meanwhile
        if isinstance(self._cell.get(name), Pose):
            self._compare_tools(robot)
            pose = robot.state.get_tcp_pose()
            self._cell.teach(name, pose)
            self._cell.save()
            return pose_line(pose)
        joints = robot.state.get_actual_joints_position()
        self._cell.teach(name, joints)
        self._cell.save()
        return ", ".join(degrees(joints))

    def _compare_tools(self, robot: Robot) -> None:
        """Say if the controller's tool, whose pose is stored, is another than the cell's."""
        tip, known = robot.frames.get_tcp_offset(), self._cell.tool.tcp
        if not tip.almost_equal(known, position=1e-3, rotation=0.01):
            text = f"the controller's tool has its tip at {pose_line([*tip])}, the cell's at "
            say(f"{text}{pose_line([*known])}: the pose is that of the controller's", error=True)


def _file(robot: Robot, path: Path) -> _Waypoints:
    """The existing file of waypoints, or a new one."""
    from aioduco.errors import PathRefused  # noqa: PLC0415
    from aioduco.recording.playback import WaypointFile  # noqa: PLC0415
    from aioduco.recording.playback.player import for_another_arm  # noqa: PLC0415

    told = reported_name(robot)
    if not path.exists():
        return _Waypoints(WaypointFile.new(arm=told, title=str(path)), path)
    kept = WaypointFile.read(path)
    if text := for_another_arm(kept.arm, told):
        raise PathRefused(f"{path}: {text}; nothing was sent", (text,))
    say(f"{path} has {len(kept.waypoints)} waypoints; new ones follow them")
    return _Waypoints(kept, path)


def _keep(
    robot: Robot, store: _Waypoints | _CellPoints, check: Callable[[], None] = lambda: None
) -> None:
    """Store the place of the arm for each typed line that passes a check."""
    from aioduco.errors import (  # noqa: PLC0415 - quick help
        CellFileError,
        ParameterError,
        WaypointFileError,
    )

    while True:
        try:
            line = input(f"{store.asked}, or {_END}: ").strip()
        except EOFError:
            say()
            return
        if line == _END:
            return
        check()
        if name := line or store.usual:
            try:
                say(f"{name}: {store.store(name, robot)}")
            # of the name or the file, which a person can correct; the arm is still guided
            except (ParameterError, CellFileError, WaypointFileError) as error:
                say_error(f"not stored: {error}")
