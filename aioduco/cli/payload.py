"""`aioduco payload`: find mass and centre of what an arm carries, by readings at several poses."""

from __future__ import annotations

import enum
import time
from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli.addresses import CellFile, Host, Port, robot_at
from aioduco.cli.cell_file import is_cell, load_cell
from aioduco.cli.exit_codes import USAGE, ended_by_errors, fail
from aioduco.cli.extras import arm as arm_named
from aioduco.cli.options import Json, Mounting, Yes, wrong_option
from aioduco.cli.output import print_json, say
from aioduco.cli.questions import GIVES_WAY, SAFE, ask, typed_line
from aioduco.cli.sessions import (
    control_session,
    guiding,
    observing_session,
    require_reported_arm,
    require_same_state,
    require_still_at,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from aioduco import Cell
    from aioduco.kinematics import Arm, MeasuredLoad
    from aioduco.models.load import Load
    from aioduco.models.pose import Joints
    from aioduco.models.rotation import Array
    from aioduco.models.state import Vector
    from aioduco.recording.playback import WaypointFile
    from aioduco.sync import Robot


#: readings at a pose, and seconds between two
_READINGS, _EVERY = 50, 0.02
#: seconds in which an arm that has just stopped comes to rest
_REST = 0.5
#: largest difference of a joint over the readings of a pose [rad]
_AT_REST = 2e-3
#: speed and acceleration between the poses of a file [rad/s, rad/s²]
_SPEED, _ACCELERATION = 0.3, 0.5

#: step between two places of a way that are checked [rad]
_CHECKED = 0.02

_Numbers = tuple[float, float, float, float]


class Sensor(enum.StrEnum):
    """What is read."""

    TORQUE = "torque"
    FORCE = "force"


def payload(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    sensor: Sensor = Sensor.TORQUE,
    poses: Annotated[Path | None, typer.Option(exists=True, dir_okay=False)] = None,
    set_load: Annotated[_Numbers | None, typer.Option(metavar="KG X Y Z")] = None,
    tool: str | None = None,
    held: bool = False,
    mounting: Mounting | None = None,
    model: str | None = None,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Find mass and centre of gravity of the tool with what it holds.

    Eight poses or more are read, at rest: turn the wrist to several sides and bend the elbow, by 30
    degrees or more. Let go of the arm before each reading. Stop other programs, and tare nothing.

    With --poses the arm moves to them by itself, all joints together. In a cell, the ways are
    checked against its scene first, and its limits are kept; otherwise see that they are free.

    aioduco payload 192.168.1.10 --tool grip

    aioduco payload left --poses around.toml --sensor force --held

    Exit codes: 0 it was found; 1 it was not, or no controller; 2 wrong options; 3 not confirmed:
    nothing was written; 4 it is not known that the arm stands; 130, 143 Ctrl-C or SIGTERM.

    Args:
        sensor: The joints' torques, or the force sensor at the flange.
        poses: File of `aioduco teach`, or of a cell: the arm moves to its waypoints. Without it,
            the arm is guided by hand.
        set_load: For torques: the load that a program has set by set_load_data, in the tool's frame
            [m]; the controller does not tell it.
        tool: Write the result as the load of a tool of this name: it asks first.
        held: Write what the result has beyond the tool's load, as held by the tool: it asks first.
        mounting: Where the arm is mounted. Default: as the cell says, or floor.
        model: Model of the arm. Default: as the controller says.
    """
    if held and tool is not None:
        raise typer.BadParameter("--tool and --held write the result in two ways: give one of them")
    address = robot_at(host, port, cell)
    known_arm = None if model is None else arm_named(model)
    if set_load is not None:
        _check_load(set_load, sensor)
    with ended_by_errors():
        _check_name(tool)
    kept, file = (None, None) if poses is None else _file(poses)
    if cell is not None:
        kept = load_cell(cell)
    name = address.name if kept is not None and address.name in kept.robots else None
    with ended_by_errors():
        down = _gravity(mounting, kept, name)
    if file is None:
        what = GIVES_WAY.format(address)
    else:
        around = (
            "The ways are checked against the scene of the cell"
            if kept is not None
            else "What stands around it is not known without --cell: see that the ways are free"
        )
        what = (
            f"The arm at {address} will turn all joints together to {len(file.waypoints)} poses, "
            f"in their order, at 17 °/s. {around}.\n{SAFE}"
        )
    with observing_session(address) as robot:
        here = robot.state.get_actual_joints_position()
        states = robot.state.get_robot_state()
    ask(what, "Begin?", yes=yes)
    # A person may take any time: hand guiding must not stop because no call is made.
    with control_session(address, hold_limit=None) as robot:
        if kept is not None and file is not None:
            robot.envelope = robot.envelope or kept.envelope(name)
            _check_ways(kept, name, robot.state.get_actual_joints_position(), file)
        arm = known_arm or require_reported_arm(robot, "--model")
        _require_arm(robot, arm, file)
        require_same_state(robot, states.robot, states.safety)
        robot.bring_up()
        gone_to = _guided(robot) if file is None else _moved(robot, file, here)
        joints, read = _readings(robot, sensor, gone_to)
        found = _found(robot, sensor, arm, joints, read, set_load, down)
        if json:
            print_json({"load": found.load._asdict(), "uncertainty": found.uncertainty})
        else:
            _tell(found)
        if tool is not None:
            _define(robot, tool, found.load, yes=yes)
        elif held:
            _set_held(robot, found.load, yes=yes)
        else:
            say("nothing was written to the controller: --tool and --held do that", error=True)


def _check_load(load: _Numbers, sensor: Sensor) -> None:
    """Refuse --set-load if its value is no load, or if it has no effect."""
    if sensor is Sensor.FORCE:
        raise typer.BadParameter("it is for --sensor torque", param_hint="--set-load")
    from aioduco.models.ranges import LOAD  # noqa: PLC0415 - quick help

    with wrong_option("--set-load"):
        LOAD("load", load)


def _check_name(tool: str | None) -> None:
    """Refuse a name of a tool that the controller would not get, before anything is measured."""
    from aioduco.models.ranges import NAME  # noqa: PLC0415 - quick help

    if tool is not None:
        NAME("tool", tool)


def _file(path: Path) -> tuple[Cell | None, WaypointFile]:
    """Waypoints of a file, and the cell if it is one."""
    from aioduco.kinematics.payload import MIN_POSES  # noqa: PLC0415 - quick help
    from aioduco.recording.playback import WaypointFile  # noqa: PLC0415

    with ended_by_errors():
        kept = load_cell(path) if is_cell(path) else None
        file = WaypointFile.read(path) if kept is None else kept.waypoints
    if len(file.waypoints) < MIN_POSES:
        fail(
            f"{path} has {len(file.waypoints)} poses, but {MIN_POSES} or more are needed, and "
            "eight are good: nothing moved",
            USAGE,
        )
    return kept, file


def _gravity(mounting: Mounting | None, cell: Cell | None, name: str | None) -> Array:
    """Gravity along the axes of an arm's base: as the option says, or the cell, or on a floor.

    Raises:
        ParameterError: the cell has several robots, and it is not known which one is meant.
    """
    from aioduco.kinematics import gravity  # noqa: PLC0415 - quick help

    if mounting is not None:
        return gravity(mounting.value)
    return gravity(cell.robot(name).mounting if cell is not None and cell.robots else "floor")


def _check_ways(cell: Cell, name: str | None, start: Joints, file: WaypointFile) -> None:
    """End the command if a joint motion to one of the poses meets something in the cell."""
    import numpy as np  # noqa: PLC0415 - quick help

    from aioduco.cli import extras  # noqa: PLC0415

    extras.need("sim")
    scene = cell.scene(name)
    before, where = np.array(start), "where the arm stands"
    for number, waypoint in enumerate(file.waypoints, 1):
        after, there = np.array(waypoint.joints), waypoint.name or f"pose {number}"
        steps = max(2, int(np.abs(after - before).max() / _CHECKED) + 1)
        for q in np.linspace(before, after, steps):
            if scene.collides(q):
                fail(
                    f"on the way from {where} to {there}, {scene.clearance(q)}: nothing moved. "
                    "`aioduco teach` stores other poses, or ones in between; without --poses the "
                    "arm is guided by hand",
                )
        before, where = after, there


def _require_arm(robot: Robot, arm: Arm, file: WaypointFile | None) -> None:
    """End the command if it is about another arm than the one that is there."""
    from aioduco.kinematics.catalogue import same_arm  # noqa: PLC0415 - quick help

    if file is not None and file.arm and not same_arm(file.arm, arm.name):
        fail(f"the poses are those of a {file.arm}, and this is a {arm.name}: nothing moved")
    if not arm.fits(robot.state.get_actual_joints_position(), robot.state.get_flange_pose()):
        fail(f"the arm is no {arm.name}, by the place of its flange: nothing moved")


def _guided(robot: Robot) -> Iterator[Joints]:
    """The arm at rest at each pose to which a person guided it."""
    number = 1
    while True:
        with robot.motion.teach_mode.start():
            check = guiding(robot)
            word = typed_line(f"guide the arm to pose {number}: Enter, q ends: ")
            if word == "":
                check()
        if word in (None, "q"):
            return
        if word:
            say("Enter or q?", error=True)
            continue
        typed_line("let go of the arm: Enter: ")
        robot.sleep(_REST)
        yield robot.state.get_actual_joints_position()
        number += 1


def _moved(robot: Robot, file: WaypointFile, here: Joints) -> Iterator[Joints]:
    """The arm at rest at each waypoint of a file, from where it was at the question."""
    require_still_at(robot, here)
    for waypoint in file.waypoints:
        robot.motion.movej2(waypoint.joints, v=_SPEED, a=_ACCELERATION)
        robot.sleep(_REST)
        yield robot.state.get_actual_joints_position()


def _readings(
    robot: Robot, sensor: Sensor, poses: Iterable[Joints]
) -> tuple[list[Joints], list[Vector]]:
    """Joints and readings of the poses; one at which the arm moves is left out."""
    joints, read = [], []
    for number, q in enumerate(poses, 1):
        mean = _mean(robot, sensor)
        if not robot.state.get_actual_joints_position().almost_equal(q, _AT_REST):
            say(f"pose {number} is left out: the arm moved while it was read", error=True)
            continue
        joints.append(q)
        read.append(mean)
        say(f"pose {number} is read", error=True)
    return joints, read


def _mean(robot: Robot, sensor: Sensor) -> Vector:
    """The mean of many readings."""
    import numpy as np  # noqa: PLC0415 - quick help

    from aioduco.errors import UnknownFunction  # noqa: PLC0415

    read = robot.force.fc_get_ft if sensor is Sensor.FORCE else robot.state.get_ext_torque
    values = []
    begin = time.monotonic()
    for number in range(1, _READINGS + 1):
        try:
            values.append(read())
        except UnknownFunction:
            values.append(np.full(6, np.nan))
        robot.sleep(max(0.0, begin + number * _EVERY - time.monotonic()))
    mean: Vector = np.mean(values, axis=0)
    if not np.isfinite(mean).all():
        fail(
            f"the controller tells no {sensor.value}: "
            + (
                "is a sensor set up? Try --sensor torque"
                if sensor is Sensor.FORCE
                else "it is older; try --sensor force"
            ),
        )
    return mean


def _found(
    robot: Robot,
    sensor: Sensor,
    arm: Arm,
    joints: list[Joints],
    read: list[Vector],
    set_load: _Numbers | None,
    down: Array,
) -> MeasuredLoad:
    """The load of tool and held things; too few poses end the command."""
    from aioduco.kinematics import (  # noqa: PLC0415 - quick help
        identify_load_by_forces,
        identify_load_by_torques,
    )
    from aioduco.kinematics.payload import MIN_POSES  # noqa: PLC0415
    from aioduco.models.load import Load  # noqa: PLC0415

    if len(joints) < MIN_POSES:
        needed = f"{MIN_POSES} or more are needed, and eight are good"
        fail(f"{len(joints)} poses were read, but {needed}: nothing was written")
    if sensor is Sensor.FORCE:
        flanges = [arm.fkine(q) for q in joints]
        return identify_load_by_forces(flanges, read, gravity=down)
    known = robot.frames.get_tool_load()
    if set_load is not None:
        known = known.with_load(Load(*set_load).in_flange(robot.frames.get_tcp_offset()))
    return identify_load_by_torques(arm, joints, read, known=known, gravity=down)


def _load_line(load: Load) -> str:
    x, y, z = (part * 1e3 for part in load[1:])
    return f"{load.mass:.3f} kg at x {x:.1f}  y {y:.1f}  z {z:.1f} mm"


def _tell(found: MeasuredLoad) -> None:
    say(f"{_load_line(found.load)} in the flange's frame: tool and held things together")
    say(f"mass within {found.uncertainty[0]:.3f} kg, centre within "
        f"{found.uncertainty[1] * 1e3:.1f} mm; readings up to {max(found.deviations):.2f} N·m "
        "off")  # fmt: skip


def _define(robot: Robot, name: str, load: Load, *, yes: bool) -> None:
    """Write the load of a tool, after a question."""
    offset = robot.frames.get_tcp_offset()
    ask(
        f"The controller will define the tool {name!r} with {_load_line(load)}, the tip of the "
        "tool in use and no inertia, and use it from now on.",
        "Write it?",
        yes=yes,
    )
    robot.frames.set_tool_data(name, offset, load)
    say(f"the controller uses the tool {name!r} from now on", error=True)


def _set_held(robot: Robot, load: Load, *, yes: bool) -> None:
    """Write the held load, after a question."""
    held = load.without_load(robot.frames.get_tool_load())
    held = held.in_tool(robot.frames.get_tcp_offset())
    ask(
        f"The controller will take {_load_line(held)} of the tool's tip for what the tool holds.",
        "Write it?",
        yes=yes,
    )
    robot.frames.set_load_data(held)
    say("the controller knows the held load from now on", error=True)
