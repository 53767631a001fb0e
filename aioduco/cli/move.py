"""`aioduco move`: to joint angles, or with the tool to a pose."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from aioduco.cli.addresses import CellFile, HostOption, Port, RobotAddress, robot_at
from aioduco.cli.described import DescribedCommand
from aioduco.cli.exit_codes import ended_by_errors, fail
from aioduco.cli.options import WITH_NUMBERS, Json, Yes, refuse_unused
from aioduco.cli.output import print_json, say
from aioduco.cli.questions import SAFE, ask
from aioduco.cli.sessions import control_session, require_still_at
from aioduco.cli.status import joints_line, look, pose_line, remedy

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.models.enums import Outcome
    from aioduco.sync import Robot


Six: TypeAlias = tuple[float, float, float, float, float, float]

move: typer.Typer = typer.Typer(
    name="move",
    no_args_is_help=True,
    help="Move the arm to joint angles or to a pose. It asks first.",
)


@move.command(cls=DescribedCommand, context_settings=WITH_NUMBERS)
def joints(
    angles: Annotated[Six, typer.Argument(metavar="J1 J2 J3 J4 J5 J6")],
    deg: bool = False,
    by: bool = False,
    speed: Annotated[float, typer.Option("--speed", "-v")] = 0.3,
    acceleration: Annotated[float, typer.Option("--acceleration", "-a")] = 0.5,
    host: HostOption = None,
    port: Port = None,
    cell: CellFile = None,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Move to joint angles, all joints together. It shows the motion, and asks.

    aioduco move joints 0 -20 110 0 -90 0 --deg --host left

    aioduco move joints 0 0 0 0 0 0.1 --by --speed 0.1 --yes

    Exit codes: 0 the arm is there; 1 it is not; 2 wrong options; 3 not confirmed; 4 it is not known
    that the arm stands; 130, 143 Ctrl-C or SIGTERM: the arm was stopped.

    Args:
        angles: Angles [rad].
        deg: The angles are in degrees.
        by: Turn by these angles, not to them.
        speed: Speed of the joints [rad/s].
        acceleration: Acceleration of the joints [rad/s²].
    """
    from aioduco.models import ranges  # noqa: PLC0415 - for commands with a robot alone

    with ended_by_errors():
        ranges.JOINT_SPEED("speed", speed)
        ranges.JOINT_ACCELERATION("acceleration", acceleration)
    address = robot_at(host, port, cell)
    found = ready_arm(address)
    given = [math.radians(angle) for angle in angles] if deg else [*angles]
    now = found["joints"]
    target = [a + b for a, b in zip(now, given, strict=True)] if by else given
    with ended_by_errors():
        ranges.JOINTS("joints", target)
    turns = [abs(a - b) for a, b in zip(target, now, strict=True)]
    far = max(turns)
    text = f"""\
arm    {address}: {found["arm"] or "type not told"}, software {found["software"] or "not told"}
now    {joints_line(now)}
to     {joints_line(target)}
The joints turn at up to {math.degrees(speed):.0f} °/s. Joint {turns.index(far) + 1} turns by \
{math.degrees(far):.0f}°.
{SAFE}"""
    ask(text, "Move the arm?", yes=yes)

    def go(robot: Robot) -> Outcome:
        require_still_at(robot, now)
        return robot.motion.movej2(target, v=speed, a=acceleration)

    carry_out(address, go, json)


@move.command(cls=DescribedCommand, context_settings=WITH_NUMBERS)
def pose(
    context: typer.Context,
    numbers: Annotated[Six, typer.Argument(metavar="X Y Z RX RY RZ")],
    mm: bool = False,
    deg: bool = False,
    by: bool = False,
    curved: Annotated[bool, typer.Option("--joints")] = False,
    speed: Annotated[float, typer.Option("--speed", "-v")] = 0.05,
    acceleration: Annotated[float, typer.Option("--acceleration", "-a")] = 0.2,
    host: HostOption = None,
    port: Port = None,
    cell: CellFile = None,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Move the tool to a pose in the work object, on a line. It shows the distance, and asks.

    aioduco move pose 400 0 350 180 0 -90 --mm --deg

    aioduco move pose 0 0 -50 0 0 0 --mm --by --host left

    Exit codes: as of `aioduco move joints`.

    Args:
        numbers: Position [m] and rotation [rad].
        mm: X, Y, Z are in millimetres.
        deg: RX, RY, RZ are in degrees.
        by: Move by this along and about the tool's axes.
        curved: Move all joints together at 0.3 rad/s, not on a line.
        speed: Speed of the tool [m/s].
        acceleration: Acceleration of the tool [m/s²].
    """
    from aioduco.models import ranges  # noqa: PLC0415 - for commands with a robot alone
    from aioduco.models.pose import Pose  # noqa: PLC0415

    if curved:
        refuse_unused(context, "a motion on a line", "speed", "acceleration")
    scale, turn = (1e-3 if mm else 1.0), (math.pi / 180 if deg else 1.0)
    with ended_by_errors():
        ranges.LINE_SPEED("speed", speed)
        ranges.LINE_ACCELERATION("acceleration", acceleration)
        position, rotation = numbers[:3], numbers[3:]
        given = Pose(*(part * scale for part in position), *(part * turn for part in rotation))
    address = robot_at(host, port, cell)
    found = ready_arm(address, in_work_object=True)
    here = Pose(*found["pose_in_work_object"])
    target = here @ given if by else given
    with ended_by_errors():
        ranges.POSE("pose", target)
    distance = math.dist([*here][:3], [*target][:3])
    way = (
        "All joints move together, at up to 17 °/s: not on a line."
        if curved
        else f"The tool moves on a line, at up to {speed * 1e3:.0f} mm/s."
    )
    text = f"""\
arm    {address}: {found["arm"] or "type not told"}, software {found["software"] or "not told"}
now    {pose_line([*here])}
to     {pose_line([*target])}
{way} It is {distance * 1e3:.0f} mm away.
{SAFE}"""
    ask(text, "Move the arm?", yes=yes)

    def go(robot: Robot) -> Outcome:
        require_still_at(robot, found["joints"], here)
        if curved:
            return robot.motion.movej_pose2(target, v=0.3, a=0.5)
        return robot.motion.movel(target, v=speed, a=acceleration)

    carry_out(address, go, json, in_work_object=True)


def ready_arm(address: RobotAddress, *, in_work_object: bool = False) -> dict[str, Any]:
    """Read the state of an arm, and end the command if the arm could not move now.

    Args:
        address: the robot.
        in_work_object: whether the tool's pose in the work object is read, too.

    Returns:
        The values that `status` shows.
    """
    found = look(address, in_work_object=in_work_object)
    if not found["ready"]:
        fail(
            f"the arm at {address} is not ready: robot {found['robot'].name}, program "
            f"{found['program'].name}, safety {found['safety'].name}; nothing was sent; "
            f"{remedy(address, found)}",
        )
    return found


def carry_out(
    address: RobotAddress,
    motion: Callable[[Robot], Outcome],
    as_json: bool,
    *,
    in_work_object: bool = False,
) -> None:
    """Carry out a motion under supervision, and print how it ended, and where the arm is.

    Args:
        address: the robot.
        motion: carries it out.
        as_json: whether that is printed as JSON.
        in_work_object: whether the tool's pose is that in the work object, and not in the base.
    """
    begin = time.monotonic()
    with control_session(address) as robot:
        outcome = motion(robot)
        seconds = time.monotonic() - begin
        there: Sequence[float] = [*robot.state.get_actual_joints_position()]
        state = robot.state
        pose = state.get_tcp_pose_coord() if in_work_object else state.get_tcp_pose()
        tool: Sequence[float] = [*pose]
    if as_json:
        ended = {"outcome": outcome, "seconds": round(seconds, 3)}
        print_json(ended | {"joints": there, "pose": tool})
    else:
        say(f"{outcome.value} after {seconds:.1f} s")
        say(f"joints {joints_line(there)}\ntool   {pose_line(tool)}")
