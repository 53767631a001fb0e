"""`aioduco twin`: watch an arm beside a simulated one, and learn what is normal for it."""

from __future__ import annotations

import dataclasses
import signal
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path  # noqa: TC003 - Typer reads the annotations
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import anyio
import typer

from aioduco.cli import extras
from aioduco.cli.addresses import Host, Port, RobotAddress, robot_at
from aioduco.cli.exit_codes import SIGNALLED, ended_by_errors, fail
from aioduco.cli.options import (
    Duration,
    MountingOption,
    mounting_option,
    refuse_unused,
    require_readable,
    require_writable,
)
from aioduco.cli.output import print_json, say
from aioduco.cli.sessions import (
    observing_session,
    page_session,
    require_reported_arm,
    wait_until_ended,
)
from aioduco.cli.signals import receive_signals
from aioduco.models.host_port import host_port
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from aioduco.integrations.panel import Panel
    from aioduco.kinematics.mounting import MountingLike
    from aioduco.sim.twin import Twin, TwinLimits
    from aioduco.sync._generated_objects import Twin as BlockingTwin


#: exit status if the arm and its twin have parted
PARTED = 6
#: seconds between two looks at a twin that the browser shows
_LOOK = 0.1


def twin(
    context: typer.Context,
    host: Host = None,
    port: Port = None,
    learn: Annotated[Path | None, typer.Option(exists=True, dir_okay=False)] = None,
    limits: Path | None = None,
    judge: Annotated[Path | None, typer.Option(exists=True, dir_okay=False)] = None,
    arm: str | None = None,
    mounting: MountingOption = "floor",
    action: str = "report",
    output: Annotated[Path | None, typer.Option("--output", "-o")] = None,
    rate: Annotated[float, typer.Option(min=25, max=500)] = 125.0,
    seconds: Duration = None,
    json: bool = False,
    panel: bool = False,
    listen: Annotated[int, typer.Option(min=0, max=65534)] = 8080,
) -> None:
    """Watch an arm beside a simulated one, whichever program moves it, until Ctrl-C.

    It says where the two part, since when, and the probable cause. It moves nothing; with --action
    it pauses or stops the arm. What other programs command is not known here, so that paths and
    delays are judged by `robot.twin()` alone, in the program that moves the arm.

    aioduco record left -o good.mcap

    aioduco twin --learn good.mcap --limits left.json

    aioduco twin left --limits left.json --action pause

    aioduco twin left --limits left.json --panel

    aioduco twin --judge run.mcap --limits left.json

    Exit codes: 0 nothing parted; 1 no controller, it ended early, or the controller did not answer
    at the end; 2 wrong options; 6 they parted.

    Args:
        learn: Learn the limits from this good run.
        limits: File of the limits: with --learn it is written, and otherwise read.
        judge: Judge this recording; no arm is needed.
        arm: The arm. Default: the one that the controller reports.
        action: When they part: report, pause or stop.
        output: Record the arm to this file, too.
        rate: Samples per second.
        json: Print each divergence as JSON.
        panel: Show the arm and its twin in the browser.
        listen: With --panel: port of the page. 0: any.
    """
    without_page = ("action", "output", "rate")
    if judge is not None or (learn is not None and host is None):
        live = ("host", "port", "seconds", "panel", *without_page)
        refuse_unused(context, "an arm that is watched", *live)
    if panel:
        refuse_unused(context, "a twin without --panel, which only shows", *without_page)
    else:
        refuse_unused(context, "--panel", "listen")
    if learn is None:
        require_readable("--limits", limits)
    else:
        require_writable("--limits", limits, learn, judge)
    require_writable("--output", output)
    extras.need("sim", "record")
    if action not in ("report", "pause", "stop"):
        raise typer.BadParameter("report, pause or stop", param_hint="--action")
    with ended_by_errors():
        base = mounting_option(mounting)
        known = _limits(learn, limits, arm, base)
        if judge is not None:
            _judge(judge, known, arm, base, as_json=json)
        if learn is not None and host is None:
            return
    if panel:
        _show_page(robot_at(host, port), known, arm, base, listen, seconds, as_json=json)
    with observing_session(robot_at(host, port), state_rate=rate) as robot, ExitStack() as stack:
        if output is not None:
            recording = stack.enter_context(robot.record(output))
            say(f"recording to {recording.path}", error=json)
        options: dict[str, Any] = {"action": action, "arm": arm, "mounting": base}
        made = stack.enter_context(robot.twin(known, commands=False, **options))
        shown = _Shown(made, as_json=json)
        what = f"a twin watches {host_port(robot.host, robot.port)}"
        answered = wait_until_ended(what, robot, shown.going, seconds)
        shown.going()
    if made.error is not None:
        fail(f"it ended early: {made.error}")
    if not answered and not shown.count:
        fail("the controller did not answer at the end: it is not known whether they parted")
    raise typer.Exit(PARTED if shown.count else 0)


def _limits(
    run: Path | None, file: Path | None, arm: str | None, base: MountingLike
) -> TwinLimits | None:
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
    run: Path, known: TwinLimits | None, arm: str | None, base: MountingLike, *, as_json: bool
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


def _show_page(
    address: RobotAddress,
    known: TwinLimits | None,
    arm: str | None,
    base: MountingLike,
    listen: int,
    seconds: float | None,
    *,
    as_json: bool,
) -> NoReturn:
    """Show the arm and its twin in the browser until Ctrl-C, and end the command."""
    extras.need("panel")
    # All imports run before the event loop: loading would block it.
    from aioduco.integrations.panel import Panel  # noqa: PLC0415
    from aioduco.planning import Scene  # noqa: PLC0415

    import_module("aioduco.integrations.panel.arm_scene")
    with page_session(address, f"port {listen}"):
        made = Panel(
            address.host,
            address.port,
            listen=listen,
            token="",  # watching only: the twin's page commands nothing
            name=address.name,
            model=arm,
            scene=None if base == "floor" else Scene(_model(address, known, arm), mounting=base),
            twin=known or True,
        )
        told, count = anyio.run(_serve_page, made, str(address), seconds, as_json)
    if told not in (0, signal.SIGINT):
        raise typer.Exit(SIGNALLED + told)
    if made.twin is not None and made.twin.error is not None:
        fail(f"it ended early: {made.twin.error}")
    raise typer.Exit(PARTED if count else 0)


def _model(address: RobotAddress, known: TwinLimits | None, arm: str | None) -> str:
    """The arm of which a mounting is: how high it hangs depends on its lengths."""
    if arm is not None:
        return arm
    if known is not None:
        return known.arm
    with observing_session(address) as robot:
        return require_reported_arm(robot, "--arm").name


async def _serve_page(
    made: Panel, address: str, seconds: float | None, as_json: bool
) -> tuple[int, int]:
    """Serve the page; return the signal that ended it, 0 for none, and how often they parted."""
    told = 0
    with receive_signals() as signals:
        async with made:
            assert made.twin is not None
            shown = _Shown(made.twin, as_json=as_json)
            say(f"{address} and its twin are on {made.url}; Ctrl-C ends it")
            async with anyio.create_task_group() as group:

                async def signalled() -> None:
                    nonlocal told
                    told = await anext(aiter(signals))
                    group.cancel_scope.cancel()

                group.start_soon(signalled)
                with anyio.move_on_after(seconds):
                    async for _ in every(_LOOK):
                        if not shown.going():
                            break
                group.cancel_scope.cancel()
            shown.going()
    return told, shown.count


class _Shown:
    """Prints the divergences of a twin as they come."""

    def __init__(self, made: Twin | BlockingTwin, *, as_json: bool) -> None:
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
