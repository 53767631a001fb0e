"""`aioduco fleet`: the arms of several computers, with one view and one stop."""

from __future__ import annotations

import json as json_module
import math
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import anyio
import typer

from aioduco.cli import extras
from aioduco.cli.described import DescribedCommand
from aioduco.cli.exit_codes import FAILED, SIGNALLED, STOP_UNCONFIRMED, USAGE, ended_by_errors, fail
from aioduco.cli.output import OutputFailed, print_json, say
from aioduco.models.similar import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco.integrations.fleet import FleetGateway, FleetSettings, FleetStop, FleetView


fleet: typer.Typer = typer.Typer(
    name="fleet",
    help="The arms of several computers: serve, see and stop them.",
    no_args_is_help=True,
)

#: how soon a heartbeat that was withheld is resumed at the latest [s]
_REARMED_EVERY: Final = 0.2

File = Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="The fleet: fleet.toml.")]
Timeout = Annotated[float, typer.Option(min=0.1, max=60.0, help="Until gateways answered [s].")]
Json = Annotated[bool, typer.Option("--json", help="As one line of JSON.")]


@fleet.command(cls=DescribedCommand)
def serve(file: File) -> None:
    """Supervise the arms of a file until Ctrl-C, and offer their state and stop to the fleet.

    At the end the arms are stopped.

    Exit codes: 1 an address cannot be listened on; 2 a wrong file; 130, 143, 129 Ctrl-C, SIGTERM,
    or the terminal was closed.
    """
    settings = _settings(file)
    from aioduco.cli.signals import receive_signals  # noqa: PLC0415 - quick help
    from aioduco.integrations.fleet import FleetGateway  # noqa: PLC0415

    async def run() -> int:
        gateway = FleetGateway(settings)
        with receive_signals() as signals:
            async with gateway, anyio.create_task_group() as tasks:
                tasks.start_soon(_rearm_heartbeats, gateway)
                arms = ", ".join(arm.name for arm in settings.arms) or "no arm"
                where = ", ".join(settings.listen)
                say(f"gateway {settings.gateway} of {settings.name} on {where}: {arms}")
                async for number in signals:
                    tasks.cancel_scope.cancel()
                    return SIGNALLED + number
        return FAILED

    with _ended():
        code = anyio.run(run)
    raise typer.Exit(code)


async def _rearm_heartbeats(gateway: FleetGateway) -> None:
    """Resume each heartbeat that is withheld, since this computer slept or this program hung.

    The controllers have stopped the arms. This process commands no arm that a resumed heartbeat
    would let go on, but has to stop the arms of other programs if it dies.
    """
    from aioduco import DucoError, HeartbeatState  # noqa: PLC0415 - quick help
    from aioduco.supervision.concurrency import every  # noqa: PLC0415

    async for _ in every(_REARMED_EVERY):
        for name, robot in [*gateway.robots.items()]:
            heartbeat = robot.heartbeat
            if heartbeat is not None and heartbeat.state is HeartbeatState.STALLED:
                with suppress(DucoError):  # the view says that the controller does not answer
                    await robot.rearm_heartbeat()
                    say(f"the gateway had stood still: it supervises {name} again", error=True)


@fleet.command(cls=DescribedCommand)
def status(file: File, timeout: Timeout = 3.0, json: Json = False) -> None:
    """Show every arm of the fleet.

    Exit codes: 0 all gateways reported their state; 1 some are missing; 2 a wrong file.
    """
    settings = _settings(file)
    from aioduco.integrations.fleet import FleetClient  # noqa: PLC0415 - quick help

    async def ask() -> FleetView:
        async with FleetClient(settings) as client:
            return await client.status(timeout)

    with _ended():
        view = anyio.run(ask)
    if json:
        table = {
            "gateways": [json_module.loads(report.encode()) for report in view.gateways],
            "missing": view.missing,
        }
        print_json(table)
    else:
        _show(view)
    if view.missing or not view.gateways:
        raise typer.Exit(FAILED)


@fleet.command(cls=DescribedCommand)
def stop(
    file: File,
    arm: Annotated[list[str] | None, typer.Argument()] = None,
    timeout: Timeout = 6.0,
    json: Json = False,
) -> None:
    """Stop all arms of the fleet, or those that are named.

    Exit codes: 0 all of them stand, which each gateway proved by its key; 2 a wrong file; 4 it is
    not known that all of them stand.

    Args:
        arm: Arms; all if none is named.
    """
    settings = _settings(file)
    from aioduco.errors import ConnectError, StopUnconfirmed  # noqa: PLC0415 - quick help
    from aioduco.integrations.fleet import FleetClient  # noqa: PLC0415

    async def ask() -> FleetStop:
        try:
            async with FleetClient(settings) as client:
                return await client.stop(arm or None, timeout, waiting=_tell_waiting)
        except ConnectError as error:
            raise StopUnconfirmed(f"no stop was sent: {error}. Press the emergency stop") from error

    with _ended("interrupted: it is not known whether the arms of the fleet stand"):
        done = anyio.run(ask)
    try:
        if json:
            _print(done)
        else:
            _tell_standing(done)
    except OutputFailed as error:
        if done.confirmed:
            raise
        say(error, error=True)  # what follows, and the exit code, matter more
    if not json:
        _tell_lacking(done)
    if not done.confirmed:
        raise typer.Exit(STOP_UNCONFIRMED)


def _settings(file: Path) -> FleetSettings:
    extras.need("fleet")
    from aioduco.integrations.fleet import FleetSettings  # noqa: PLC0415 - quick help
    from aioduco.integrations.fleet.proof import read_keys  # noqa: PLC0415

    with _wrong_file_told():
        settings = FleetSettings.read(file)
        if settings.keys:
            read_keys(settings.keys)
    return settings


@contextmanager
def _wrong_file_told() -> Iterator[None]:
    from aioduco.integrations.fleet import FleetFileError  # noqa: PLC0415 - quick help

    try:
        yield
    except FleetFileError as error:
        fail(str(error), USAGE)


@contextmanager
def _ended(interrupted: str = "interrupted") -> Iterator[None]:
    """End the command on an error or a signal; a file may be found wrong only when it is used."""
    with ended_by_errors(interrupted), _wrong_file_told():
        yield


def _show(view: FleetView) -> None:
    for report in view.gateways:
        for arm in report.arms:
            joints = " ".join(f"{math.degrees(joint):.1f}" for joint in arm.joints)
            known = f"{arm.robot} {arm.program} {arm.safety} {arm.mode} [{joints}]°"
            said = arm.error if arm.link == "lost" else known if arm.robot else ""
            say(f"{report.gateway:16} {arm.name:16} {arm.link:8} {said}".rstrip())
    for name in view.missing:
        say(f"{name:16} missing: it does not tell its state", error=True)
    if not view.gateways and not view.missing:
        say("no gateway was found", error=True)


def _print(done: FleetStop) -> None:
    table = {
        "confirmed": done.confirmed,
        "gateways": [json_module.loads(report.encode()) for report in done.reports],
        "missing": done.missing,
        "unknown": done.unknown,
        "unproven": done.unproven,
    }
    print_json(table)


def _tell_waiting(known: FleetStop) -> None:
    """Print on the standard error who has answered, and for whom the stop still waits."""
    names = (report.gateway for report in known.reports)
    answered = ", ".join(name for name in names if name not in known.missing)
    say(f"answered: {answered}; still waiting for {', '.join(known.missing)}", error=True)


def _tell_standing(done: FleetStop) -> None:
    """Print the arms that stand, as their gateways proved."""
    for report in done.reports:
        if report.gateway not in done.unproven:
            for arm in report.arms:
                if not arm.error:
                    say(f"{report.gateway:16} {arm.name:16} stands")


def _tell_lacking(done: FleetStop) -> None:
    """Print all else to the standard error."""
    for report in done.reports:
        if report.note:
            say(f"{report.gateway}: {report.note}", error=True)
        for arm in report.arms:
            if arm.error or report.gateway in done.unproven:
                said = arm.error or "stands, says an answer without proof"
                say(f"{report.gateway:16} {arm.name:16} {said}", error=True)
    answered = {report.gateway for report in done.reports}
    for name in done.unproven:
        said = "someone answered in its name without its key"
        if name in answered:
            said = "anyone may have answered: this computer has no key of it, see docs/fleet.md"
        say(f"{name:16} not proven: {said}", error=True)
    for name in done.missing:
        other = "another gateway of this name is " if name in answered else ""
        say(f"{name:16} {other}missing: it is not known whether its arms stand", error=True)
    known = [arm.name for report in done.reports for arm in report.arms]
    for name in done.unknown:
        say(f"no gateway has an arm {name}{did_you_mean(name, known)}", error=True)
    if not done.reports and not done.missing:
        say("no gateway was found: nothing was stopped", error=True)
