"""`aioduco twin`: watch an arm beside a simulated one, and learn what is normal for it."""

from __future__ import annotations

import dataclasses
from contextlib import ExitStack
from pathlib import Path  # noqa: TC003 - Typer reads the annotations
from typing import TYPE_CHECKING, Annotated, Any

import typer

from aioduco.cli import extras
from aioduco.cli.addresses import Host, Port, robot_at
from aioduco.cli.exit_codes import FAILED, ended_by_errors
from aioduco.cli.number_lists import mounting_option
from aioduco.cli.output import print_json, say
from aioduco.cli.sessions import observing_session, wait_until_ended

if TYPE_CHECKING:
    from aioduco.models.pose import Pose
    from aioduco.sim.twin import TwinLimits
    from aioduco.sync._generated_objects import Twin

__all__ = ["twin"]

#: exit status if the arm and its twin have parted
PARTED = 6


def twin(
    host: Host = None,
    port: Port = None,
    learn: Annotated[
        Path | None,
        typer.Option(exists=True, dir_okay=False, help="Learn the limits from this good run."),
    ] = None,
    limits: Annotated[
        Path | None,
        typer.Option(help="File of the limits: with --learn it is written, and otherwise read."),
    ] = None,
    judge: Annotated[
        Path | None,
        typer.Option(exists=True, dir_okay=False, help="Judge this recording; no arm is needed."),
    ] = None,
    arm: Annotated[
        str | None, typer.Option(help="The arm. Default: the one that the controller reports.")
    ] = None,
    mounting: Annotated[
        str, typer.Option(help="floor, wall, ceiling, or the base's x,y,z,rx,ry,rz [m, rad].")
    ] = "floor",
    action: Annotated[str, typer.Option(help="When they part: report, pause or stop.")] = "report",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Record the arm to this file, too.")
    ] = None,
    rate: Annotated[float, typer.Option(min=25, max=500, help="Samples per second.")] = 125.0,
    seconds: Annotated[
        float | None, typer.Option(min=0.0, help="Duration [s]. Default: until Ctrl-C.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print each divergence as JSON.")] = False,
) -> None:
    """Watch an arm beside a simulated one, whichever program moves it, until Ctrl-C.

    It says where the two part, since when, and the probable cause. It moves nothing; with --action
    it pauses or stops the arm. What other programs command is not known here, so that paths and
    delays are judged by `robot.twin()` alone, in the program that moves the arm.

    aioduco record left -o good.mcap

    aioduco twin --learn good.mcap --limits left.json

    aioduco twin left --limits left.json --action pause

    aioduco twin --judge run.mcap --limits left.json

    Exit codes: 0 nothing parted; 1 no controller, or it ended early; 2 wrong options; 6 they
    parted.
    """
    extras.need("sim", "record")
    if action not in ("report", "pause", "stop"):
        raise typer.BadParameter("report, pause or stop", param_hint="--action")
    with ended_by_errors():
        base = _base(mounting, arm)
        known = _limits(learn, limits, arm, base)
        if judge is not None:
            _judge(judge, known, arm, base, as_json=json)
        if learn is not None and host is None:
            return
    with observing_session(robot_at(host, port), state_rate=rate) as robot, ExitStack() as stack:
        if output is not None:
            stack.enter_context(robot.record(output))
        options: dict[str, Any] = {"action": action, "arm": arm, "mounting": base}
        made = stack.enter_context(robot.twin(known, commands=False, **options))
        shown = _Shown(made, as_json=json)
        what = f"a twin watches {robot.host}:{robot.port}"
        wait_until_ended(what, robot, shown.going, seconds)
        shown.going()
    if made.error is not None:
        say(f"it ended early: {made.error}", error=True)
        raise typer.Exit(FAILED)
    raise typer.Exit(PARTED if shown.count else 0)


def _base(mounting: str, arm: str | None) -> Pose:
    from aioduco.kinematics import arm as arm_of  # noqa: PLC0415 - for this command alone
    from aioduco.kinematics.mounting import base_in_world  # noqa: PLC0415

    return base_in_world(mounting_option(mounting), arm_of(arm or "gcr5_910"))


def _limits(run: Path | None, file: Path | None, arm: str | None, base: Pose) -> TwinLimits | None:
    """Limits learned from a run or read from a file; None for wide ones."""
    from aioduco.sim.twin import TwinLimits, learn  # noqa: PLC0415 - for this command alone

    if run is None:
        return None if file is None else TwinLimits.load(file)
    known = learn(run, arm=arm, mounting=base)
    say(
        f"{known.arm}, {known.learned:g} s in motion. Limits: payload {known.mass:.2f} kg, "
        f"force {known.force:.1f} N, friction {100 * known.friction:.0f} %, "
        f"position {1000 * known.position:.2f} mm, path {1000 * known.path:.1f} mrad, "
        f"delay {1000 * known.delay:.0f} ms"
    )
    if file is not None:
        known.save(file)
        say(f"written to {file}")
    return known


def _judge(
    run: Path, known: TwinLimits | None, arm: str | None, base: Pose, *, as_json: bool
) -> None:
    """Print where the arm of a recording and its twin parted, and end the command."""
    from aioduco.sim.twin import judge  # noqa: PLC0415 - for this command alone

    found = judge(run, known, arm=arm, mounting=base)
    for divergence in found:
        if as_json:
            values = divergence._asdict()
            names = {name: values[name].value for name in ("quantity", "cause")}
            print_json({**values, **names})
        else:
            say(f"{divergence.since:8.2f} s  {divergence}")
    if not found:
        say("nothing parted")
    raise typer.Exit(PARTED if found else 0)


class _Shown:
    """Prints the divergences of a twin as they come."""

    def __init__(self, made: Twin, *, as_json: bool) -> None:
        self._made = made
        self._as_json = as_json
        self.count = 0

    def going(self) -> bool:
        """Print what is new; return whether the twin still runs."""
        count = self._made.statistics().divergences
        new, self.count = count - self.count, count
        for event in list(self._made.divergences)[-new:] if new else ():
            if self._as_json:
                print_json(dataclasses.asdict(event))
            else:
                say(event.line())
        return bool(self._made.running)
