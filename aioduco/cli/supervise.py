"""`aioduco bring-up`, `recover`, `stop`, `pause`, `resume`: change the state of an arm.

They send no heartbeat: it would take the arm's supervision away from the program that moves it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli.addresses import CellFile, Host, Port, RobotAddress, robot_at
from aioduco.cli.command_terms import in_commands
from aioduco.cli.exit_codes import fail, say_error
from aioduco.cli.options import Yes
from aioduco.cli.output import print_json, say
from aioduco.cli.questions import SAFE, ask
from aioduco.cli.sessions import observing_session
from aioduco.models.numpy_on_use import json_value

if TYPE_CHECKING:
    from aioduco import RecoverReport


Json = Annotated[bool, typer.Option("--json", help="Print the states afterwards as JSON.")]
Timeout = Annotated[
    float, typer.Option(min=0.1, max=600.0, help="Seconds within which the arm must be ready.")
]


def bring_up(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    timeout: Timeout = 30.0,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Power the arm on, enable it and clear a stop, until it can move. It asks first.

    aioduco bring-up 192.168.1.10

    aioduco bring-up left --yes --json

    Exit codes: 0 ready; 1 not ready in time, or no controller; 2 wrong options; 3 not confirmed;
    5 a person has to do something first.
    """
    address = robot_at(host, port, cell)
    what = f"The arm at {address} will be powered on and enabled: its brakes open.\n{SAFE}"
    ask(what, "Bring it up?", yes=yes)
    with observing_session(address) as robot:
        report = robot.bring_up(timeout=timeout)
    _ready(address, report, json)


def recover(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    timeout: Timeout = 30.0,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Lead the arm out of a stop, and end the running program. It asks first.

    aioduco recover left

    Exit codes: as of bring-up.
    """
    address = robot_at(host, port, cell)
    what = (
        f"At {address} a collision is reset, a program that runs is ended, and the arm is powered "
        f"off and on where that is needed: its brakes close and open.\n{SAFE}"
    )
    ask(what, "Recover it?", yes=yes)
    with observing_session(address) as robot:
        report = robot.recover(timeout=timeout)
    _ready(address, report, json)


def stop(host: Host = None, port: Port = None, cell: CellFile = None, json: Json = False) -> None:
    """Stop the arm, whichever program moves it, and wait until it stands. It does not ask.

    aioduco stop left

    Exit codes: 0 it stands; 1 no controller; 2 wrong options; 4 it is not known that it stands, or
    another program's set-points move it again: press the emergency stop.
    """
    from aioduco.cli.stopping import stop_at  # noqa: PLC0415 - quick help

    stop_at(robot_at(host, port, cell), as_json=json)


def pause(host: Host = None, port: Port = None, cell: CellFile = None, json: Json = False) -> None:
    """Pause the arm's motion, and wait until it stands. It does not ask.

    aioduco pause left

    Exit codes: as of stop; 1 also if there was nothing to pause.
    """
    address = robot_at(host, port, cell)
    with observing_session(address) as robot:
        paused = robot.pause()
        states = robot.state.get_robot_state()
    if json:
        print_json(states)
    elif paused:
        say(f"{address}: paused: the arm stands; {states}")
    if not paused:
        fail(f"{address}: nothing was paused: the arm stands, and may be moved; {states}")


def resume(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Resume the paused motion. It asks first: the arm moves at once.

    aioduco resume left --yes

    Exit codes: 0 resumed; 1 nothing was paused, or no controller; 2 wrong options; 3 not confirmed.
    """
    address = robot_at(host, port, cell)
    what = f"The arm at {address} goes on with what was paused, at the speed that it had.\n{SAFE}"
    ask(what, "Resume?", yes=yes)
    from aioduco import ClosingSteps  # noqa: PLC0415 - quick help

    # A program that leaves its robot stops what it resumed; this operator wants it to go on.
    left_moving = ClosingSteps(stop=None, standstill=None)
    with observing_session(address, closing_steps=left_moving) as robot:
        paused = robot.resume()
        states = robot.state.get_robot_state()
    if json:
        print_json(states)
    elif paused:
        say(f"{address}: resumed; {states}")
    if not paused:
        fail(f"{address}: nothing was paused; {states}")


def _ready(address: RobotAddress, report: RecoverReport, as_json: bool) -> None:
    """Print the states of an arm that can move, and what to do before forces are measured."""
    if as_json:
        print_json(
            json_value(report.states) | {"advice": in_commands(report.advice, address.where)}
        )
    else:
        say(f"{address}: ready; {report.states}")
    if report.advice:
        say_error(report.advice, address.where)
