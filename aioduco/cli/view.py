"""`aioduco view`: an arm live in Foxglove or Lichtblick."""

from __future__ import annotations

from typing import Annotated

import typer

from aioduco.cli import extras
from aioduco.cli.addresses import CellFile, Host, Port, robot_at
from aioduco.cli.exit_codes import fail
from aioduco.cli.options import Duration
from aioduco.cli.sessions import observing_session, wait_until_ended


def view(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    foxglove: bool = False,
    listen: Annotated[int, typer.Option(min=0, max=65535)] = 8765,
    bind: str = "127.0.0.1",
    rate: Annotated[float, typer.Option(min=1, max=1000)] = 50.0,
    seconds: Duration = None,
    forces: bool = True,
) -> None:
    """Publish what an arm does, until Ctrl-C, whichever program moves it. This moves nothing.

    It only reads from the controller. It sends no heartbeat, and ending it stops nothing.

    aioduco view --foxglove 192.168.1.10

    Exit codes: 0 it ran until it was ended; 1 no controller, or the port is taken; 2 wrong
    options; 143 SIGTERM.

    Args:
        foxglove: As a WebSocket for Foxglove and Lichtblick.
        listen: Port of the WebSocket. 0: a free one.
        bind: Address of the WebSocket. 0.0.0.0: the whole network may watch.
        rate: Samples a second.
        forces: Also forces and external torques.
    """
    if not foxglove:
        raise typer.BadParameter("say what to view it with: --foxglove")
    extras.need("record")
    address = robot_at(host, port, cell)
    with observing_session(address, state_rate=rate) as robot:
        publication = robot.publish(listen, host=bind, forces=forces)
        with publication:
            what = f"{address} is on {publication.url}"
            wait_until_ended(what, robot, lambda: publication.running, seconds)
    if publication.error is not None:
        fail(f"it ended early: {publication.error}")
