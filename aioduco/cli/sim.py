"""`aioduco sim`: a simulated controller that runs until a signal or a client ends it."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path  # noqa: TC003 - typer reads the annotations
from typing import TYPE_CHECKING, Annotated, cast

import typer

from aioduco.cli import extras, picture, watching
from aioduco.cli.addresses import CellFile
from aioduco.cli.cell_file import RobotName, load_cell, simulated_parts
from aioduco.cli.exit_codes import USAGE, cannot_listen, fail, failing
from aioduco.cli.options import (
    MountingOption,
    Pedestal,
    SceneFile,
    ToolFile,
    mounting_option,
    require_writable,
)
from aioduco.cli.output import say
from aioduco.cli.signals import wakeup_socket
from aioduco.cli.sim_do import control_port_of
from aioduco.errors import ParameterError, RenderError, SceneError
from aioduco.models.address import PORT
from aioduco.models.host_port import host_port

if TYPE_CHECKING:
    from aioduco.planning.cell import CellRobot
    from aioduco.sim.server.generations import Generation


def sim(
    model: str | None = None,
    profile: Annotated[Path | None, typer.Option(exists=True, dir_okay=False)] = None,
    generation: str = "3.8",
    cell: CellFile = None,
    robot: RobotName = None,
    host: str = "127.0.0.1",
    port: Annotated[int | None, typer.Option(min=0, max=65535)] = None,
    status_port: Annotated[int | None, typer.Option(min=0, max=65535)] = None,
    force_port: Annotated[int | None, typer.Option(min=0, max=65535)] = None,
    control_port: Annotated[int | None, typer.Option(min=0, max=65535)] = None,
    speed: Annotated[float, typer.Option(min=0.01, max=1000.0)] = 1.0,
    programs: Annotated[Path | None, typer.Option(exists=True, file_okay=False)] = None,
    scene: SceneFile = None,
    tool: ToolFile = None,
    gripper: str | None = None,
    mounting: MountingOption = "floor",
    pedestal: Pedestal = 0.0,
    render: Path | None = None,
    strict: bool = False,
    real_readings: bool = False,
    view: bool = False,
) -> None:
    """Run a simulated controller until Ctrl-C, or until a client shuts it down.

    Args:
        model: The arm to simulate. Default: the profile's, or gcr5_910.
        profile: Profile of one arm, from `aioduco calibrate`.
        generation: The controller that it plays: 3.8, 4.3, older, oldest or first; see the docs.
        host: Address to listen on. 0.0.0.0: the whole network.
        port: Port to listen on. 0: a free one. Default: that of the cell's robot, or 7003.
        status_port: Also push status frames on this port. A controller: 2001.
        force_port: Also stream forces from this UDP port. A controller: 2011.
        control_port: Port for `aioduco sim-do`. Default: port + 10000.
        speed: Speed of simulated time, as a multiple of real time.
        programs: Folder of programs, `NAME.json`.
        gripper: A gripper at the flange, such as robotiq_2f85, dh_ag95, parallel.
        render: At the end, write what the arm did as .gif, or how it stands as .png.
        strict: Refuse calls that the manual forbids. Default: log them.
        real_readings: Readings in single precision, with noise of forces.
        view: Show the arm in MuJoCo's window.
    """
    extras.need("sim", *(("plot",) if render else ()))
    if model is None and profile is None:
        model = "gcr5_910"
    if model is not None:
        extras.arm(model)
    parts = simulated_parts(
        cell,
        robot,
        model=model,
        scene=scene,
        tool=tool,
        gripper=gripper,
        mounting=mounting_option(mounting),
        pedestal=pedestal,
    )
    listed = _listed(cell, robot)
    if port is None:
        port = PORT if listed is None else listed.port
    if render is not None and render.suffix not in picture.KINDS:
        raise typer.BadParameter(f"its name must end in {' or '.join(picture.KINDS)}")
    require_writable("--render", render)
    from aioduco.sim import Simulator  # noqa: PLC0415 - MuJoCo is for this command alone
    from aioduco.sim.console import Console  # noqa: PLC0415 - as above
    from aioduco.sim.server.line_server import LineServer  # noqa: PLC0415 - as above
    from aioduco.sim.spawned import SWITCH_INTERVAL  # noqa: PLC0415 - as above

    sys.setswitchinterval(SWITCH_INTERVAL)
    with wakeup_socket() as (heard, ring):
        try:
            simulator = Simulator(
                generation=cast("Generation", generation),
                **parts,
                profile=profile,
                host=host,
                port=port,
                status_port=status_port,
                force_port=force_port,
                speed=speed,
                programs=programs,
                strict=strict,
                real_readings=real_readings,
                on_shutdown=ring,
            )
            simulator.start()
        except (ParameterError, SceneError) as error:
            fail(str(error), USAGE)
        except ValueError as error:
            fail(str(error))
        except OSError as error:
            given = (port, status_port, force_port)
            ports = " or ".join(str(each) for each in given if each is not None)
            cannot_listen(f"{host}:{ports}", error)
        with contextlib.ExitStack() as stack:
            stack.enter_context(contextlib.closing(simulator))
            commands = control_port_of(port) if control_port is None else control_port
            try:
                lines = LineServer(Console(simulator).answer, commands)
            except OSError as error:
                cannot_listen(f"127.0.0.1:{commands} for commands", error)
            stack.enter_context(contextlib.closing(lines))
            with failing(RenderError):
                watch = watching.SimulatorWatch(simulator, render, view=view)
            where = host_port(simulator.host, simulator.port)
            if simulator.status_port is not None:
                where += f", status frames on {simulator.status_port}"
            if simulator.force_port is not None:
                where += f", forces from UDP {simulator.force_port}"
            where += f", commands on {lines.port}"
            say(f"simulated {simulator.arm.name} on {where}; Ctrl-C ends it")
            _say_whom_programs_move(cell, listed, host)
            watch.until(heard)


def _listed(cell: Path | None, robot: str | None) -> CellRobot | None:
    """The robot as its programs find it in the file of the cell; None without one."""
    found = None if cell is None else load_cell(cell)
    return found.robot(robot) if found is not None and found.robots else None


def _say_whom_programs_move(cell: Path | None, listed: CellRobot | None, host: str) -> None:
    if listed is not None and listed.host not in (host, "127.0.0.1", "localhost"):
        say(
            f"programs that use {cell} move the arm at {host_port(listed.host, listed.port)}, and "
            "not this one: for it, set `host` there to 127.0.0.1",
            error=True,
        )
