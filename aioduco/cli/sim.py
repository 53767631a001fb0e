"""`aioduco sim`: a simulated controller that runs until it is told to end."""

from __future__ import annotations

import contextlib
import signal
from queue import SimpleQueue
from typing import Annotated

import typer

from aioduco.cli import extras

__all__ = ["sim"]


def sim(
    model: Annotated[str, typer.Option(help="The arm to simulate.")] = "gcr5_910",
    host: Annotated[
        str, typer.Option(help="Address to listen on. 0.0.0.0: the whole network.")
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port to listen on. 0: a free one.")
    ] = 7003,
    speed: Annotated[
        float, typer.Option(min=0.01, max=1000.0, help="Times faster than the wall clock.")
    ] = 1.0,
) -> None:
    """Run a simulated controller until Ctrl-C, or until a client shuts it down."""
    extras.need("sim")
    extras.arm(model)
    from aioduco.sim import Simulator  # noqa: PLC0415 - MuJoCo is for this command alone

    # Not an event: a signal handler that sets one can meet the lock that its own thread holds.
    ended: SimpleQueue[str] = SimpleQueue()
    simulator = Simulator(
        model,
        host=host,
        port=port,
        speed=speed,
        on_shutdown=lambda: ended.put("a client shut it down"),
    )
    try:
        simulator.start()
    except OSError as error:
        typer.echo(f"cannot listen on {host}:{port}: {error.strerror or error}", err=True)
        raise typer.Exit(1) from None
    with contextlib.closing(simulator):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: ended.put("told to end"))
        typer.echo(f"simulated {model} on {simulator.host}:{simulator.port}; Ctrl-C ends it")
        typer.echo(ended.get())
