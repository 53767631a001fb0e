"""`aioduco sim`: a simulated controller that runs until it is told to end."""

from __future__ import annotations

import contextlib
import select
import signal
import socket
from pathlib import Path  # noqa: TC003 - typer reads the annotations
from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli import extras

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["sim"]

ENDS = (signal.SIGINT, signal.SIGTERM)


def sim(
    model: Annotated[str, typer.Option(help="The arm to simulate.")] = "gcr5_910",
    host: Annotated[
        str, typer.Option(help="Address to listen on. 0.0.0.0: the whole network.")
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port to listen on. 0: a free one.")
    ] = 7003,
    status_port: Annotated[
        int | None,
        typer.Option(
            min=0, max=65535, help="Push status frames on this port too; 2001 as a controller."
        ),
    ] = None,
    speed: Annotated[
        float, typer.Option(min=0.01, max=1000.0, help="Times faster than the wall clock.")
    ] = 1.0,
    programs: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help='Folder of programs, "<name>.json".'),
    ] = None,
) -> None:
    """Run a simulated controller until Ctrl-C, or until a client shuts it down."""
    extras.need("sim")
    extras.arm(model)
    from aioduco.sim import Simulator  # noqa: PLC0415 - MuJoCo is for this command alone

    with _bell() as (heard, ring):
        try:
            simulator = Simulator(
                model,
                host=host,
                port=port,
                status_port=status_port,
                speed=speed,
                programs=programs,
                on_shutdown=ring,
            )
        except ValueError as error:
            typer.echo(str(error), err=True)
            raise typer.Exit(1) from None
        try:
            simulator.start()
        except OSError as error:
            ports = f"{port}" if status_port is None else f"{port} and {status_port}"
            typer.echo(f"cannot listen on {host}:{ports}: {error.strerror or error}", err=True)
            raise typer.Exit(1) from None
        with contextlib.closing(simulator):
            typer.echo(f"simulated {model} on {simulator.host}:{simulator.port}; Ctrl-C ends it")
            select.select([heard], [], [])


@contextlib.contextmanager
def _bell() -> Iterator[tuple[socket.socket, Callable[[], object]]]:
    """A socket that can be read from once a signal came, or once something rang.

    The system may hand a signal to any thread, also to one of a library; what the main thread
    waits in would then not end. The byte that is written for it ends a `select` in any case.
    """
    heard, rung = socket.socketpair()
    with heard, rung:
        rung.setblocking(False)
        before = signal.set_wakeup_fd(rung.fileno(), warn_on_full_buffer=False)
        handlers = {number: signal.signal(number, lambda *_: None) for number in ENDS}
        try:
            yield heard, lambda: rung.send(b"!")
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
            signal.set_wakeup_fd(before)
