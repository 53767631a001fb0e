"""`aioduco play`: play a recording or waypoints on a simulated or a real arm."""

from __future__ import annotations

from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli import extras
from aioduco.cli.addresses import CellFile, HostOrSimulator, Port, robot_at
from aioduco.cli.cell_file import is_cell, load_cell
from aioduco.cli.exit_codes import ended_by_errors
from aioduco.cli.options import SceneFile, refuse_unused, require_writable
from aioduco.cli.output import say

if TYPE_CHECKING:
    from aioduco.recording.playback import RecordedPath, WaypointFile


def play(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False)],
    host: HostOrSimulator = None,
    port: Port = None,
    cell: CellFile = None,
    model: str | None = None,
    speed: Annotated[float, typer.Option(min=0.01, max=10.0)] = 1.0,
    begin: Annotated[float | None, typer.Option("--from", min=0.0)] = None,
    end: Annotated[float | None, typer.Option("--to", min=0.0)] = None,
    bridge: Annotated[float, typer.Option(min=0.0, max=0.1)] = 0.005,
    outputs: bool = False,
    record: Path | None = None,
    scene: SceneFile = None,
    envelope: Annotated[Path | None, typer.Option(exists=True, dir_okay=False)] = None,
    check: bool = False,
    rehearse: bool = True,
    yes: bool = False,
) -> None:
    """Move an arm along a recording or through waypoints: a simulated arm, or the one at HOST.

    Before a real arm moves, the file is checked (arm, joint limits, speeds,
    accelerations, the envelope), played on a simulated arm, and you are asked. Ctrl-C brings the
    arm to rest.

    aioduco play run.mcap

    aioduco play run.mcap 192.168.1.10 --speed 0.5 --from 2 --to 8.5

    aioduco play points.toml 192.168.1.10 --envelope limits.toml

    aioduco play run.mcap left --cell cell.toml

    Exit codes: 0 it was played; 1 it was not, or not to its end; 2 wrong options; 3 not confirmed;
    4 it is not known that the arm stands; 130, 143 Ctrl-C or SIGTERM: the arm was brought to rest.

    Args:
        file: A recording, .mcap, or waypoints, .toml.
        model: The arm. Default: from the controller or the file.
        speed: Times as fast; waypoints: up to 1.
        begin: Begin there in the recording [s].
        end: End there in the recording [s].
        bridge: Bridge gaps in which the arm is known to within this [rad].
        outputs: Also set the digital outputs that changed on the way.
        record: Record what the arm does to this file.
        envelope: Limits to keep to, besides those of --cell: TOML, see docs.
        check: Print the reasons against playing it; move nothing.
        rehearse: Play it on a simulated arm before a real one.
        yes: Do not ask before an arm moves.
    """
    simulates = not check and (host is None or rehearse)
    _refuse_unused(context, file, host, speed, check=check, simulates=simulates)
    require_writable("--record", record)
    extras.need("record", *(("sim",) if simulates else ()))
    if model is not None:
        extras.arm(model)
    from aioduco.cli.playing import PlayedFile  # noqa: PLC0415 - for this command alone
    from aioduco.envelope import Envelope  # noqa: PLC0415
    from aioduco.recording import read  # noqa: PLC0415
    from aioduco.recording.playback import (  # noqa: PLC0415
        RecordedPath,
        WaypointFile,
        read_envelope,
    )
    from aioduco.recording.playback.sample_times import gaps_in_words  # noqa: PLC0415

    with ended_by_errors():
        what: RecordedPath | WaypointFile
        if file.suffix == ".toml":
            cell = file if cell is None and is_cell(file) else cell
            what = load_cell(file).waypoints if is_cell(file) else WaypointFile.read(file)
        else:
            run = read(file)
            what = RecordedPath.of(run, begin=begin, end=end, speed=speed, bridge=bridge)
            if not run.complete:
                say(f"{file} was cut off: it is played up to there")
            if what.gaps:
                say(f"bridged: {gaps_in_words(what.gaps)}")
        told = model or _model_of(what)
        around = {} if scene is None else {"scene": str(scene.resolve())}
        limits = None
        if cell is not None:
            found = load_cell(cell)
            limits = found.envelope(host)
            around = {**found.simulator_options(host), **around}
            told = model or found.robot(host).model if found.robots else told
        if envelope is not None:
            of_cell = () if limits is None else limits.limits
            given = read_envelope(envelope, arm=told if limits is None else limits.arm.name)
            limits = Envelope(given.arm, *of_cell, *given.limits)
        if limits is not None:
            told = limits.arm.name
        task = PlayedFile(what, told, speed, outputs, record, limits)
        if check and host is None:
            task.check()
            return
        address = None if host is None else robot_at(host, port, cell)
        here = task.simulate(around, address) if simulates else None
        if address is not None:
            task.on_arm(address, here, only_check=check, yes=yes)


def _refuse_unused(
    context: typer.Context,
    file: Path,
    host: str | None,
    speed: float,
    *,
    check: bool,
    simulates: bool,
) -> None:
    if check:
        refuse_unused(context, "playing it, without --check", "outputs", "record")
    if not simulates:
        refuse_unused(context, "the simulated arm, which is left out here", "scene")
    if host is None:
        refuse_unused(context, "HOST: without it, a simulated arm plays the file", "port")
    if file.suffix == ".toml":
        refuse_unused(context, "a recording", "begin", "end", "bridge", "outputs")
        if speed > 1.0:
            raise typer.BadParameter("waypoints are played at up to 1", param_hint="--speed")


def _model_of(what: RecordedPath | WaypointFile) -> str | None:
    """The model that a file is for; None if the file names none or an unknown one."""
    from aioduco.kinematics.catalogue import model_named  # noqa: PLC0415

    found = model_named(what.arm)
    return None if found is None else found.name
