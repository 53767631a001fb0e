"""`aioduco tool`: find the tip of a tool and its axes, by touching a fixed point with it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli.addresses import CellFile, Host, Port, robot_at
from aioduco.cli.described import DescribedCommand
from aioduco.cli.exit_codes import ended_by_errors, fail, say_error
from aioduco.cli.options import Guide, Json, Yes, refuse_unused
from aioduco.cli.output import print_json, say
from aioduco.cli.questions import ask, typed_line
from aioduco.cli.sessions import guided_session, guiding, observing_session
from aioduco.cli.status import pose_line

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.kinematics import ToolAxes, ToolTip
    from aioduco.models.load import Load
    from aioduco.models.pose import Pose
    from aioduco.sync import Robot


tool: typer.Typer = typer.Typer(
    name="tool", no_args_is_help=True, help="Measure the tool at the flange."
)

#: fewer touches give no result
_MIN_TOUCHES = 4

_HOW = """\
Fix a pointed thing within reach, such as a nail in a board. Touch it with the tool's tip, {count}
times or more: tilted by 30 to 60 degrees to different sides, and turned about the tool's own axis
in between."""


@tool.command(cls=DescribedCommand)
def touch(
    context: typer.Context,
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    name: str | None = None,
    axes: bool = False,
    load: Annotated[
        tuple[float, float, float, float] | None, typer.Option(metavar="KG X Y Z")
    ] = None,
    touches: Annotated[int, typer.Option(min=_MIN_TOUCHES, max=100)] = 6,
    guide: Guide = True,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Find the tip of a tool by touching one point with it from several sides.

    Enter stores a touch, d drops the last one, q ends. From the fourth touch on, each says where
    the tip is, and how sure that is. Errors that all touches share, such as wrong lengths of the
    arm, are not in it.

    aioduco tool touch 192.168.1.10 --axes --name pen

    Exit codes: 0 it was found; 1 it was not, or no controller; 2 wrong options; 3 not confirmed:
    nothing was written; 4 it is not known that the arm stands; 130, 143 Ctrl-C or SIGTERM.

    Args:
        name: Define a tool of this name on the controller: it asks first.
        axes: Find the tool's axes, too, by two more positions.
        load: Mass of the tool, and its centre in the flange's frame [m], for --name. Default: that
            of the tool in use.
        touches: Least number of touches.
    """
    if name is None:
        refuse_unused(context, "--name", "load")
    with ended_by_errors():
        _check_tool(name, load)
    address = robot_at(host, port, cell)
    say(_HOW.format(count=touches), error=True)
    session = observing_session(address)  # no heartbeat: another program may lead the arm
    if guide:
        with session as robot:
            states = robot.state.get_robot_state()
        session = guided_session(address, states, yes=yes)
    with session as robot:
        check = guiding(robot) if guide else lambda: None  # else another program leads the arm
        tip, frame = _measured(robot, touches, check, axes=axes)
    with observing_session(address) as robot:
        offset = _offset(robot, tip, frame)
        if json:
            print_json(
                {"tip": tip.tip, "uncertainty": tip.uncertainty, "distances": tip.distances,
                 "tool_offset": [*offset], "axes_uncertainty": frame and frame.uncertainty}
            )  # fmt: skip
        else:
            _tell(tip, frame, offset)
        if name is not None:
            _define(robot, name, offset, load, yes=yes)
    if name is None:
        say("nothing was written to the controller; --name does that, after a question", error=True)


def _check_tool(name: str | None, load: tuple[float, ...] | None) -> None:
    """Refuse a name or a load that the controller would not get, before a person touches anything.

    Raises:
        ParameterError: one of them is not valid.
    """
    from aioduco.models import ranges  # noqa: PLC0415 - quick help

    if name is not None:
        ranges.NAME("name", name)
    if load is not None:
        ranges.PAYLOAD("load", load)


def _measured(
    robot: Robot, least: int, check: Callable[[], None], *, axes: bool
) -> tuple[ToolTip, ToolAxes | None]:
    """Read the flange's poses at the touches, as a person says, if a check before each passes."""

    def flange() -> Pose:
        check()
        return robot.state.get_flange_pose()

    tip = _touched(flange, least)
    return tip, _axes(flange, tip) if axes else None


def _touched(flange: Callable[[], Pose], least: int) -> ToolTip:
    from aioduco.errors import CalibrationError  # noqa: PLC0415 - quick help
    from aioduco.kinematics import calibrate_tool_tip  # noqa: PLC0415

    poses: list[Pose] = []
    tip: ToolTip | None = None
    while True:
        word = _line(f"touch {len(poses) + 1}: Enter, d drops the last one, q ends: ")
        if word == "q":
            if tip is not None and len(poses) >= least:
                return tip
            fail(f"{len(poses)} touches gave no tip: nothing was written")
        if word == "d":
            del poses[-1:]
        elif word:
            say("Enter, d or q?", error=True)
            continue
        else:
            poses.append(flange())
        tip = None
        if len(poses) >= _MIN_TOUCHES:
            try:
                tip = calibrate_tool_tip(poses)
                say(_tip_line(tip), error=True)
            except CalibrationError as error:
                say_error(error)


def _axes(flange: Callable[[], Pose], tip: ToolTip) -> ToolAxes:
    from aioduco.errors import CalibrationError  # noqa: PLC0415 - quick help
    from aioduco.kinematics import calibrate_tool_axes  # noqa: PLC0415

    while True:
        _line("draw the tool straight back by 50 mm or more, along its own axis: Enter: ")
        ahead = flange()
        _line("shift it aside, so that the point is on the side of its x axis: Enter: ")
        try:
            return calibrate_tool_axes(tip, ahead, flange())
        except CalibrationError as error:
            say_error(error)


def _line(question: str) -> str:
    word = typed_line(question)
    if word is None:
        fail("it was ended: nothing was written")
    return word


def _tip_line(tip: ToolTip) -> str:
    x, y, z = (part * 1e3 for part in tip.tip)
    return (
        f"tip at x {x:.2f}  y {y:.2f}  z {z:.2f} mm in the flange's frame, within "
        f"{tip.uncertainty * 1e3:.2f} mm; the touches are up to "
        f"{max(tip.distances) * 1e3:.2f} mm off"
    )


def _offset(robot: Robot, tip: ToolTip, frame: ToolAxes | None) -> Pose:
    """The tool's frame: with the measured axes, or those of the tool in use."""
    from aioduco.models.pose import Pose  # noqa: PLC0415

    if frame is not None:
        return frame.frame
    return Pose(*tip.tip.tolist(), *robot.frames.get_tcp_offset()[3:])


def _tell(tip: ToolTip, frame: ToolAxes | None, offset: Pose) -> None:
    say(_tip_line(tip))
    say(f"tool   {pose_line([*offset])}")
    if frame is None:
        say("its axes are those of the tool in use; --axes finds them")
    else:
        tilt, turn = map(math.degrees, frame.uncertainty)
        say(f"its z axis within {tilt:.2f}°, the turn about it within {turn:.2f}°")


def _define(
    robot: Robot, name: str, offset: Pose, load: tuple[float, ...] | None, *, yes: bool
) -> None:
    """Write the tool to the controller, after a question."""
    from aioduco.models.load import Load  # noqa: PLC0415

    kept: Load = robot.frames.get_tool_load() if load is None else Load(*load)
    whose = "of the tool in use" if load is None else "as given"
    ask(
        f"The controller will define the tool {name!r} at {pose_line([*offset])}, with the mass "
        f"{kept.mass:.3f} kg {whose} and no inertia, and use it from now on: motions that name no "
        "tool then move this tip.",
        "Write it?",
        yes=yes,
    )
    robot.frames.set_tool_data(name, offset, kept)
    say(f"the controller uses the tool {name!r} from now on", error=True)
