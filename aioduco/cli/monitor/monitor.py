"""`aioduco monitor`: options, the terminal, and how it ends."""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated

import anyio
import typer

from aioduco.cli.addresses import CellFile, Host, Port, robot_at
from aioduco.cli.exit_codes import SIGNALLED, USAGE, ended_by_errors, fail
from aioduco.cli.output import OutputFailed, say

if TYPE_CHECKING:
    from aioduco.cli.monitor.view_state import MonitorState


_ENDED = "the monitor was ended; nothing was stopped"


def monitor(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    rate: Annotated[float, typer.Option(min=1, max=50)] = 10.0,
    forces: bool = True,
) -> None:
    """Watch an arm in the terminal, whichever program moves it; keys stop, pause and resume it.

    It has connections of its own and sends no heartbeat; quitting stops nothing. Space or s
    stops the arm at once, p pauses, r resumes, q quits.

    aioduco monitor 192.168.1.10

    Exit codes: 0 quit; 1 no controller; 2 wrong options, or no terminal; 4 a stop failed, and it is
    not known that the arm stands; 130, 143, 129 Ctrl-C, SIGTERM, or the terminal was closed.

    Args:
        rate: Samples per second.
        forces: Also show forces and external torques.
    """
    address = robot_at(host, port, cell)
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        fail("this needs a terminal; `aioduco status --json` does not", USAGE)
    # All imports run before the event loop: loading would block it.
    from rich.live import Live  # noqa: PLC0415

    import aioduco  # noqa: PLC0415
    from aioduco._process.platform import single_keys  # noqa: PLC0415
    from aioduco.cli.monitor.observer import MonitorClient  # noqa: PLC0415
    from aioduco.cli.monitor.screen import screen  # noqa: PLC0415
    from aioduco.cli.safe_console import SafeConsole  # noqa: PLC0415 - for this command alone

    robot = aioduco.connect(
        address.host,
        address.port,
        heartbeat=None,
        state_rate=rate,
        lag_limit=None,
        # a robot that is left stops what it resumed; quitting stops nothing
        closing_steps=aioduco.ClosingSteps(stop=None, standstill=None),
    )
    robot.feed.forces = forces
    console = SafeConsole()
    live = Live(console=console, screen=True, auto_refresh=False, vertical_overflow="crop")

    def draw(state: MonitorState) -> None:
        if not live.is_started:
            live.start()
        live.update(screen(state, console.width, console.height), refresh=True)

    terminal = sys.stdin.fileno()
    with ended_by_errors(_ENDED, address.where):
        try:
            with single_keys(terminal):
                told = anyio.run(MonitorClient(robot, str(address), terminal, draw).watch)
        finally:
            with suppress(OutputFailed):  # the terminal is gone
                live.stop()
    if told is not None:
        say(_ENDED, error=True)
        raise typer.Exit(SIGNALLED + told)
