"""`aioduco panel`: an arm in the browser."""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Annotated

import anyio
import typer

from aioduco.cli import extras
from aioduco.cli.addresses import CellFile, Host, Port, robot_at
from aioduco.cli.cell_file import load_cell
from aioduco.cli.exit_codes import SIGNALLED
from aioduco.cli.jog import Manual  # noqa: TC001 - typer evaluates it
from aioduco.cli.output import say
from aioduco.cli.sessions import page_session
from aioduco.cli.signals import receive_signals
from aioduco.cli.sim_do import control_port_of
from aioduco.models.host_port import is_loopback

if TYPE_CHECKING:
    from aioduco.integrations.panel import Panel


_TOKEN = "AIODUCO_PANEL_TOKEN"
_SHORTEST = 12


def panel(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    listen: Annotated[int, typer.Option(min=0, max=65534)] = 8080,
    bind: str = "127.0.0.1",
    watch_only: bool = False,
    model: str | None = None,
    rate: Annotated[float, typer.Option(min=2, max=50)] = 20.0,
    hold_limit: Annotated[float, typer.Option(min=0.1, max=2.0)] = 0.4,
    manual: Manual | None = None,
    control_port: Annotated[int | None, typer.Option(min=1, max=65535)] = None,
) -> None:
    """Show an arm in the browser, and let one page command it. This alone moves nothing.

    It prints a link with the token that a page needs to command; AIODUCO_PANEL_TOKEN sets a token
    of your own. Everyone who can reach the page may watch, and stop the arm. To take control, a
    user must confirm that everyone is out of reach; after that each motion lasts as long as a
    button is held down. When the page is closed or this command ends, its motions are stopped.

    aioduco panel 192.168.1.10

    aioduco panel left --watch-only --bind 0.0.0.0

    Exit codes: 1 no controller, or the port is taken; 2 wrong options; 130, 143, 129 Ctrl-C,
    SIGTERM, or the terminal was closed: motions of the panel were stopped.

    Args:
        listen: Port of the page and its picture. 0: any.
        bind: Address of the page. 0.0.0.0: the whole network may watch, and stop the arm.
        watch_only: Pages can only watch, and stop the arm.
        model: Arm to draw. Default: the one that the controller reports, or else the cell's.
        rate: States per second.
        hold_limit: Seconds until a button of a page that is silent or late counts as released, two
            states or more.
        manual: How the controller understands + and - of jogs; its version says it.
        control_port: Port for commands of a simulator on this computer. Default: port + 10000.
    """
    extras.need("panel")
    address = robot_at(host, port, cell)
    if model is not None:
        extras.arm(model)
    made_of = load_cell(cell) if cell is not None else None
    token = "" if watch_only else os.environ.get(_TOKEN)
    if token is not None and not watch_only and len(token) < _SHORTEST:
        raise typer.BadParameter(f"{_TOKEN} has less than {_SHORTEST} characters")
    if control_port is None and is_loopback(address.host):
        control_port = control_port_of(address.port) or None
    # All imports run before the event loop: loading would block it.
    from aioduco.integrations.panel import Panel  # noqa: PLC0415

    directions = None if manual is None else manual.directions()
    import_module("aioduco.integrations.panel.arm_scene")  # imports viser too

    with page_session(address, f"{bind}:{listen} (--bind, --listen)"):
        made = Panel(
            address.host,
            address.port,
            listen=listen,
            bind=bind,
            token=token,
            name=address.name,
            model=model,
            scene=None if made_of is None else made_of.scene(address.name),
            envelope=None if made_of is None else made_of.envelope(address.name),
            simulator_port=control_port,
            rate=rate,
            hold_limit=hold_limit,
            directions=directions,
        )
        told = anyio.run(_serve, made, str(address))
    say("the panel was ended; what it moved stands", error=True)
    raise typer.Exit(SIGNALLED + told)


async def _serve(made: Panel, address: str) -> int:
    """Serve the page until a signal arrives; return its number."""
    with receive_signals() as signals:
        async with made:
            say(f"{address} is on {made.url}; whoever reaches it may watch, and stop the arm")
            if made.token:
                say(f"to command it: {made.link}\ntoken: {made.token}")
            say("Ctrl-C ends it")
            return await anext(aiter(signals))
