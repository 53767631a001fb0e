"""`aioduco status`: what state an arm and its controller are in."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import typer

from aioduco.cli.addresses import CellFile, Host, Port, RobotAddress, robot_at
from aioduco.cli.exit_codes import FAILED
from aioduco.cli.output import one_line, print_json, say
from aioduco.cli.sessions import observing_session

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.state import RobotStates, RobotStatus
    from aioduco.sync import Robot


def status(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    ready: bool = False,
    json: bool = False,
) -> None:
    """Say what state an arm and its controller are in. Nothing moves.

    aioduco status 192.168.1.10

    aioduco status left --ready && aioduco move joints 0 0 90 0 -90 0 --deg --host left

    Exit codes: 0 it was read; 1 no controller, or not ready; 2 wrong options.

    Args:
        ready: End with 1 if a motion would not start now.
        json: Print it as JSON: metres, radians.
    """
    address = robot_at(host, port, cell)
    found = look(address)
    if json:
        print_json(found)
    else:
        say("\n".join(_lines(address, found)))
    if ready and not found["ready"]:
        raise typer.Exit(FAILED)


def look(address: RobotAddress, *, in_work_object: bool = False) -> dict[str, Any]:
    """Read the states of a controller and its arm, and disconnect. Nothing else is sent.

    Args:
        address: the robot.
        in_work_object: whether the tool's pose in the work object is read, too.

    Returns:
        The values that `--json` prints.
    """
    with observing_session(address) as robot:
        found = _read(address, robot)
        if in_work_object:
            found["pose_in_work_object"] = [*robot.state.get_tcp_pose_coord()]
        return found


def _read(address: RobotAddress, robot: Robot) -> dict[str, Any]:
    from aioduco.errors import ControllerError  # noqa: PLC0415

    try:
        series, model, extension, serial = robot.version.get_robot_type()
    except ControllerError:  # older software lacks the function
        series = model = extension = serial = ""
    states = robot.state.get_robot_state()
    arm = robot.state.getRobotStatus()
    return {
        "name": address.name,
        "host": address.host,
        "port": address.port,
        "arm": f"{series} {model}{extension}".strip(),
        "serial_number": serial,
        "software": robot.version.controller.text,
        "robot": states.robot,
        "program": states.program,
        "safety": states.safety,
        "mode": states.mode,
        "ready": _is_ready(states, arm),
        "moving": robot.state.robotmoving(),
        "emergency_stop": arm.emergency_stop,
        "collision_joint": arm.collision_axis if arm.collision else None,
        "joints": [*arm.joints],
        "pose": [*robot.state.get_tcp_pose()],
        "errors": robot.state.get_last_error(),
    }


def _is_ready(states: RobotStates, arm: RobotStatus) -> bool:
    """Whether a motion would start: whether `bring_up` would have nothing to do."""
    from aioduco.errors import DucoError  # noqa: PLC0415
    from aioduco.supervision.bringup import BringUp, BringUpStep  # noqa: PLC0415

    try:
        step = BringUp().next(states, emergency_stop=arm.emergency_stop, collision=arm.collision)
    except DucoError:
        return False
    return step is BringUpStep.DONE


def _lines(address: RobotAddress, found: dict[str, Any]) -> list[str]:
    software = one_line(found["software"]) or "not told"
    arm = one_line(found["arm"]) or "an arm of a type that is not told"
    errors = "; ".join(map(one_line, found["errors"])) or "none"
    stopped = ", EMERGENCY STOP pressed" if found["emergency_stop"] else ""
    if found["collision_joint"] is not None:
        stopped += f", COLLISION at joint {found['collision_joint']}"
    return [
        f"{address}: {arm}, software {software}",
        f"{states_line(found)}{stopped}",
        f"joints {joints_line(found['joints'])}",
        f"tool   {pose_line(found['pose'])}",
        f"moving {'yes' if found['moving'] else 'no'}",
        f"ready  {readiness(address, found)}",
        f"errors {errors}",
    ]


def states_line(found: dict[str, Any]) -> str:
    """The four states as one line."""
    names = ("robot", "program", "safety", "mode")
    return ", ".join(f"{name} {found[name].name}" for name in names)


def readiness(address: RobotAddress, found: dict[str, Any]) -> str:
    """Whether a motion would start, or what stands against it and which command helps."""
    return "a motion would start" if found["ready"] else f"no: {remedy(address, found)}"


def remedy(address: RobotAddress, found: dict[str, Any]) -> str:
    """What makes an arm ready that is not; with its address, or it would be the default robot."""
    from aioduco.models.enums import ProgramState, RobotState  # noqa: PLC0415

    arm = address.where
    if found["emergency_stop"]:
        return f"release the emergency stop, then `aioduco recover {arm}`"
    if found["collision_joint"] is not None:
        return f"see that the arm is free, then `aioduco recover {arm}`"
    if found["robot"] in (RobotState.POWER_OFF, RobotState.DISABLE):
        return f"`aioduco bring-up {arm}` switches the arm on"
    return {
        ProgramState.PAUSED: f"`aioduco resume {arm}` goes on, `aioduco stop {arm}` ends it",
        ProgramState.PAUSING: "it is being paused",
        ProgramState.RUNNING: f"a program runs: `aioduco stop {arm}` ends it",
        ProgramState.TASK_RUNNING: f"a motion runs: `aioduco stop {arm}` ends it",
    }.get(found["program"], f"see the states; `aioduco recover {arm}` leads out of most stops")


def degrees(angles: Sequence[float]) -> list[str]:
    """Angles as texts in degrees."""
    return [f"{math.degrees(angle):.2f}°" for angle in angles]


def joints_line(joints: Sequence[float]) -> str:
    """Joint angles as one line, in degrees."""
    return "  ".join(degrees(joints))


def pose_line(pose: Sequence[float]) -> str:
    """A pose as one line: the place in millimetres, the rotation in degrees."""
    place = "  ".join(f"{name} {part * 1e3:.1f}" for name, part in zip("xyz", pose, strict=False))
    return f"{place} mm,  {'  '.join(degrees(pose[3:]))}"
