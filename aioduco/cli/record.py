"""`aioduco record`: what a controller does, as a file."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from aioduco.cli import extras

__all__ = ["record"]

#: seconds between two looks at the recording
_LOOK = 0.1


def record(
    host: Annotated[str, typer.Argument(help="Address of the controller.")],
    output: Annotated[
        Path,
        typer.Option("--output", "-o", help="The file; one that exists is kept beside it."),
    ] = Path("run.mcap"),
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port of the controller.")] = 7003,
    rate: Annotated[float, typer.Option(min=1, max=1000, help="Samples a second.")] = 125.0,
    seconds: Annotated[
        float | None, typer.Option(min=0.0, help="For how long; until Ctrl-C if left out.")
    ] = None,
    forces: Annotated[bool, typer.Option(help="Also forces and external torques.")] = True,
) -> None:
    """Record what an arm does, whoever moves it, until Ctrl-C. Nothing moves by this.

    It only asks the controller: no heartbeat is sent, and leaving stops nothing.

    aioduco record 192.168.1.10 -o run.mcap
    """
    extras.need("record")
    import aioduco.sync  # noqa: PLC0415 - for this command alone

    robot = aioduco.sync.connect(host, port, heartbeat=None, state_rate=rate)
    try:
        with robot:
            recording = robot.record(output, forces=forces)
            with recording:
                typer.echo(f"recording to {recording.path}; Ctrl-C ends it")
                until = None if seconds is None else time.monotonic() + seconds
                try:
                    while recording.running and (until is None or time.monotonic() < until):
                        left = _LOOK if until is None else until - time.monotonic()
                        robot.sleep(min(_LOOK, max(0.0, left)))
                except KeyboardInterrupt:
                    typer.echo()  # the ^C stands on a line of its own
    except aioduco.DucoError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(1) from None
    figures = recording.statistics()
    dropped = f", {figures.dropped} dropped" if figures.dropped else ""
    typer.echo(f"{recording.path}: {figures.written} entries{dropped}, {figures.size} bytes")
    if recording.error is not None:
        typer.echo(f"it ended early: {recording.error}", err=True)
        raise typer.Exit(1)
