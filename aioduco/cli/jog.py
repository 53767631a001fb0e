"""`aioduco jog`: one joint or one direction of the tool, by a step or for a time."""

from __future__ import annotations

import enum
import math
import re
from typing import TYPE_CHECKING, Annotated, Any

import typer

from aioduco.cli.addresses import CellFile, HostOption, Port, robot_at
from aioduco.cli.move import carry_out, ready_arm
from aioduco.cli.options import Json, Yes, refuse_unused, wrong_option
from aioduco.cli.questions import SAFE, ask
from aioduco.cli.sessions import require_still_at

if TYPE_CHECKING:
    from aioduco.models.enums import Outcome
    from aioduco.models.jog import JogDirections
    from aioduco.sync import Robot


_JOINT = re.compile(r"j([1-6])")
_DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


class Direction(enum.StrEnum):
    """Direction of the motion."""

    PLUS = "+"
    MINUS = "-"


class JogFrameName(enum.StrEnum):
    """The frame that the directions refer to."""

    WORLD = "world"
    BASE = "base"
    TOOL = "tool"
    WORK_OBJECT = "work-object"


class Manual(enum.StrEnum):
    """Version of the manual whose jog directions the controller follows."""

    OLDER = "3.8"
    NEWER = "4.3"

    def directions(self) -> JogDirections:
        """Return the numbers of its directions."""
        from aioduco.models.jog import JogDirections  # noqa: PLC0415 - for commands with a robot

        return JogDirections[f"MANUAL_{self.replace('.', '_')}"]


def jog(
    context: typer.Context,
    axis: str,
    direction: Direction,
    step: Annotated[float | None, typer.Option(min=0.0)] = None,
    seconds: Annotated[float, typer.Option(min=0.01, max=60.0)] = 0.5,
    deg: bool = False,
    mm: bool = False,
    percent: Annotated[float, typer.Option(min=0.1, max=100.0)] = 5.0,
    frame: JogFrameName = JogFrameName.BASE,
    manual: Manual | None = None,
    host: HostOption = None,
    port: Port = None,
    cell: CellFile = None,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Jog one joint, or the tool along or about one direction. It asks first.

    aioduco jog j1 + --step 5 --deg

    aioduco jog z - --step 10 --mm --frame tool --host left --yes

    Exit codes: as of `aioduco move joints`.

    Args:
        axis: Joint or axis: j1 to j6, or x, y, z, rx, ry, rz.
        direction: Direction: `+` or `-`.
        step: Size of the step [rad, or m along x, y, z].
        seconds: Duration of a jog without a step [s].
        deg: The step is in degrees.
        mm: The step is in millimetres.
        percent: Speed of jogs [%].
        frame: Frame of x, y, z, rx, ry, rz.
        manual: How the controller understands + and -; its version says it, if it has one. Try with
            a small step.
    """
    from aioduco.models.jog import Jog, JogFrame  # noqa: PLC0415 - for commands with a robot alone

    joint = _JOINT.fullmatch(axis)
    if joint is None and axis not in _DIRECTIONS:
        raise typer.BadParameter(f"{axis!r} is none of j1 to j6, {', '.join(_DIRECTIONS)}")
    if joint is not None:
        refuse_unused(context, "x, y, z, rx, ry, rz", "frame")
    if step is None:
        refuse_unused(context, "--step", "deg", "mm")
    else:
        refuse_unused(context, "a jog without --step", "seconds")
    along = axis in {"x", "y", "z"}
    if (mm and not along) or (deg and along):
        raise typer.BadParameter(f"{axis} goes in {'metres' if along else 'radians'}, or with "
                                 f"--{'mm' if along else 'deg'} otherwise")  # fmt: skip
    length = None if step is None else step * (1e-3 if mm else math.pi / 180 if deg else 1.0)
    sign = 1 if direction is Direction.PLUS else -1
    named: Any = axis
    with wrong_option():
        if joint is not None:
            made = Jog.joint(int(joint[1]), sign, percent, step=length)
        else:
            in_frame = JogFrame[frame.name]
            made = Jog.cartesian(named, sign, percent, frame=in_frame, step=length)
    directions = None if manual is None else manual.directions()
    address = robot_at(host, port, cell)
    here = ready_arm(address)["joints"]
    if length is None:
        far = f"for {seconds:g} s"
    else:
        far = f"by {length * 1e3:g} mm" if along else f"by {math.degrees(length):.2f}°"
    which = f"Joint {joint[1]} turns" if joint else f"The tool moves in {axis} of the {frame.value}"
    text = f"{which} in the direction {direction.value} {far}, at {percent:g} % of the jog speed."
    ask(f"arm    {address}\n{text}\n{SAFE}", "Jog the arm?", yes=yes)

    def go(robot: Robot) -> Outcome:
        require_still_at(robot, here)
        return robot.motion.move_jog(made, time=seconds, directions=directions)

    carry_out(address, go, json)
