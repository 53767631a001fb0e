"""`aioduco doctor`: the rate that this machine and the network to an arm can hold."""

from __future__ import annotations

from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import Annotated

import anyio
import typer

from aioduco.cli.addresses import CellFile, Host, Port, robot_at
from aioduco.cli.exit_codes import ended_by_errors, writing
from aioduco.cli.options import require_writable


def doctor(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    seconds: Annotated[float, typer.Option(min=0.1, max=600.0)] = 3.0,
    json: Path | None = None,
) -> None:
    """Measure the rate that this machine and the network to an arm can hold. Nothing moves.

    aioduco doctor left --seconds 10

    Exit codes: 0 measured; 1 not measured, for example without a controller; 2 wrong options.

    Args:
        seconds: Duration of each measurement [s].
        json: File for the figures, for `aioduco plot`.
    """
    from aioduco.cli.safe_console import SafeConsole  # noqa: PLC0415 - for this command alone
    from aioduco.cli.stream_rate import examine  # noqa: PLC0415

    require_writable("--json", json, cell)
    address = robot_at(host, port, cell)

    async def run() -> None:
        found = await examine(address.host, address.port, seconds=seconds)
        SafeConsole().print(found)
        if json is not None:
            with writing(json):
                found.plain.save(json)

    with ended_by_errors(at=address.where):
        anyio.run(run)
