"""`aioduco check`: compare a controller with the simulated one, or check taught points."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli.addresses import CellFile, Port, RobotAddress, robot_at
from aioduco.cli.cell_file import is_cell, load_cell
from aioduco.cli.exit_codes import ended_by_errors, write_file, writing
from aioduco.cli.options import numbers, refuse_unused, require_writable, wrong_option
from aioduco.cli.output import say
from aioduco.cli.questions import SAFE, ask
from aioduco.cli.sessions import limits_at, observing_session, require_still_at
from aioduco.cli.status import look
from aioduco.models.numpy_on_use import json_value

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.cli.measuring import Extent


def check(
    context: typer.Context,
    target: str,
    port: Port = None,
    cell: CellFile = None,
    move: bool = False,
    motions: Path | None = None,
    reach: Annotated[float, typer.Option(min=0.1, max=1.5)] = 0.5,
    power: bool = True,
    lapse: bool = True,
    yes: bool = False,
    output: Annotated[Path | None, typer.Option("--output", "-o")] = None,
    bundle: Path | None = None,
    ids: bool = False,
    model: str = "gcr5_910",
    start: str | None = None,
    tool: str | None = None,
    wobj: str | None = None,
) -> None:
    """Check a controller against the simulated one; or taught points, without a controller.

    For a controller: list where it behaves otherwise than `aioduco sim`. It only reads unless
    --move is given. Exit codes: 0 nothing differs; 1 something does, or it was not reached; 2 wrong
    options; 3 not confirmed; 4 it is not known that the arm stands; 130, 143 Ctrl-C or SIGTERM: the
    arm was stopped.

    For a file: check reach, joint limits, singularities, branches of its points. Nothing moves.

    aioduco check 192.168.1.10 --move -o report.md

    aioduco check 192.168.1.10 --bundle report.zip

    With --motions: record the arm while it moves, for `aioduco calibrate`; nothing is compared.

    aioduco check 192.168.1.10 --motions run.mcap

    aioduco check points.toml --model gcr10_1300

    Args:
        target: Address of a controller or a name of your robots.toml; or a file of points, as
            `TaughtPoints.save` writes it; or the file of a cell, for its points.
        move: Also run the checks that move the arm. Asks first.
        motions: Instead, move the arm for some minutes, and record what `aioduco calibrate` needs.
            Asks first.
        reach: With --motions: how far a joint turns from where it is [rad].
        power: With --motions: also disable, enable, power off and on, five times.
        lapse: With --motions: also end the heartbeat in a slow motion, twice, so that the
            controller stops the arm.
        yes: Do not ask before the arm moves.
        output: Also write the report to a .md or .json file.
        bundle: Also write the report as one file to send, .zip: without addresses, names, keys.
        ids: In the bundle, keep the numbers of devices.
        model: Arm, for points.
        start: Joints at the start, for points. Default: the first joints.
        tool: Tool tip from the flange, for points: x,y,z,rx,ry,rz [m, rad].
        wobj: Work object in the base, for points: x,y,z,rx,ry,rz [m, rad].
    """
    with_motions = ("motions", "reach", "power", "lapse")
    with_report = ("move", "output", "bundle", "ids")
    if target.endswith(".toml") or Path(target).is_file():
        refuse_unused(context, "a controller", "port", "cell", *with_report, *with_motions)
        _points(context, Path(target), model, start, tool, wobj)
        return
    refuse_unused(context, "a file of points", "model", "start", "tool", "wobj")
    for option, path in {"--output": output, "--bundle": bundle, "--motions": motions}.items():
        require_writable(option, path)
    if motions is not None:
        refuse_unused(context, "a comparison, without --motions", *with_report)
        from aioduco.cli import extras  # noqa: PLC0415 - for this option alone

        extras.need("record")
        from aioduco.cli.measuring import Extent  # noqa: PLC0415

        extent = Extent(reach=reach, changes=5 if power else 0, lapses=2 if lapse else 0)
        _motions(robot_at(target, port, cell), motions, extent, yes=yes)
    else:
        refuse_unused(context, "--motions", *with_motions)
        if bundle is None:
            refuse_unused(context, "--bundle", "ids")
        address = robot_at(target, port, cell)
        if move:
            _refuse_limits(address)
        _controller(address, move=move, yes=yes, output=output, bundle=bundle, ids=ids)


def _refuse_limits(address: RobotAddress) -> None:
    """Refuse a cell with limits: the checks speak the wire, and keep none."""
    with wrong_option():
        limits = limits_at(address)
    if limits is not None:
        raise typer.BadParameter(
            "the checks that move the arm do not keep the limits of this cell: give the arm's "
            "address instead, if its first joint may turn by 6 degrees and its last one by 17",
            param_hint="--cell",
        )


def _controller(
    address: RobotAddress,
    *,
    move: bool,
    yes: bool,
    output: Path | None,
    bundle: Path | None,
    ids: bool,
) -> None:
    from aioduco.testing.conformance import check_controller  # noqa: PLC0415 - for this command alone

    if output is not None and output.suffix not in (".md", ".json"):
        raise typer.BadParameter("a name that ends in .md or .json", param_hint="--output")
    if bundle is not None and bundle.suffix != ".zip":
        raise typer.BadParameter("a name that ends in .zip", param_hint="--bundle")
    if move:
        what = (
            f"The last joint of the arm at {address} will turn by up to 17 degrees and the first "
            f"one by 6, slowly, several times. It must be enabled.\n{SAFE}"
        )
        ask(what, "Move it?", yes=yes)
    # An interrupted check stops the arm before it ends, as every check does.
    with ended_by_errors(at=address.where):
        report = check_controller(
            address.host,
            address.port,
            move=move,
            progress=lambda each: say(f"... {each.name}", error=True),
        )
    say(str(report))
    if output is not None:
        text = report.json() if output.suffix == ".json" else report.markdown()
        write_file(output, text)
        say(f"written to {output}")
    if bundle is not None:
        from aioduco.testing.conformance.bundle import write_bundle  # noqa: PLC0415 - for this alone

        found = json_value(look(address))
        with writing(bundle):
            write_bundle(bundle, report, found, ids=ids)
        say(f"written to {bundle}; read it before you send it")
    if not report.ok:
        raise typer.Exit(1)


def _motions(address: RobotAddress, path: Path, extent: Extent, *, yes: bool) -> None:
    import anyio  # noqa: PLC0415 - for this option alone

    from aioduco.cli.measuring import measure  # noqa: PLC0415

    with wrong_option():
        limits = limits_at(address)
    reach = extent.reach
    brakes = (
        f" Then its brakes close and its power goes off and on, {extent.changes} times."
        if extent.changes
        else ""
    )
    lapses = (
        " At the end the heartbeat ends in a slow turn of the last joint, "
        f"{extent.lapses} times: the controller stops the arm."
        if extent.lapses
        else ""
    )
    what = (
        f"For some {extent.minutes:.0f} minutes the arm at {address} will move around where it is: "
        f"every joint turns by up to {math.degrees(reach):.0f} degrees either way, those of the "
        f"wrist by up to {math.degrees(1.5 * reach):.0f}, and the tool moves up and aside by "
        f"{1000 * extent.line:.0f} mm.{brakes}{lapses} It must be enabled, its elbow bent, and "
        f"with nothing within that space.\n{SAFE}"
    )
    with observing_session(address) as robot:
        here = robot.state.get_actual_joints_position()
    ask(what, "Move it?", yes=yes)
    with observing_session(address) as robot:
        require_still_at(robot, here)
    with ended_by_errors("interrupted: the arm was stopped", address.where):
        path = anyio.run(
            measure,
            *(address.host, address.port, path, extent),
            lambda text: say(f"... {text}", error=True),
            limits,
        )
    say(f"recorded to {path}; `aioduco calibrate {path}` makes a profile of it")


def _points(
    context: typer.Context,
    file: Path,
    model: str,
    start: str | None,
    tool: str | None,
    wobj: str | None,
) -> None:
    from aioduco.kinematics import check as look  # noqa: PLC0415 - for this command alone
    from aioduco.models.points import TaughtPoints  # noqa: PLC0415
    from aioduco.models.pose import Joints  # noqa: PLC0415

    tip: Sequence[float] | None = None if tool is None else numbers("tool", tool, 6)
    with ended_by_errors():
        if is_cell(file):
            kept = load_cell(file)
            if kept.robots or kept.arm:
                refuse_unused(context, "points of which no cell tells the arm", "model")
            points = TaughtPoints(kept)
            tip = kept.tool.tcp if tip is None else tip
            model = kept.robot().model if kept.robots else kept.arm or model
        else:
            points = TaughtPoints.load(file)
        if start is not None:
            near = points.joints(start)
        else:
            taught = (point for point in points.values() if isinstance(point, Joints))
            near = next(taught, Joints.deg(30, -15, 105, 0, -90, 0))
        base = None if wobj is None else numbers("wobj", wobj, 6)
        report = look(points, arm=model, near=near, tool=tip, wobj=base)
    say(str(report))
    if not report.ok:
        raise typer.Exit(1)
