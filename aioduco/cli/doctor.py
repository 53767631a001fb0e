"""`aioduco doctor`: what rate this machine and the network to an arm can hold."""

from __future__ import annotations

from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import Annotated

import anyio
import typer

__all__ = ["doctor"]


def doctor(
    host: Annotated[str, typer.Argument(help="Address of the controller.")],
    port: Annotated[int, typer.Option(min=1, max=65535, help="Port of the controller.")] = 7003,
    seconds: Annotated[
        float, typer.Option(min=0.1, max=600.0, help="How long to measure, each way [s].")
    ] = 3.0,
    json: Annotated[
        Path | None, typer.Option(help="Where to write the figures, for `aioduco plot`.")
    ] = None,
) -> None:
    """Measure what rate this machine and the network to an arm can hold. Nothing moves."""
    from rich.console import Console  # noqa: PLC0415 - for this command alone

    from aioduco.errors import StreamError  # noqa: PLC0415
    from aioduco.streaming.doctor import examine  # noqa: PLC0415

    async def run() -> None:
        found = await examine(host, port, seconds=seconds)
        Console().print(found)
        if json is not None:
            found.plain.save(json)

    try:
        anyio.run(run)
    except StreamError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(1) from None
